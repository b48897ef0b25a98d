// The rows that the table, the page and the CSV of an obscuration share.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "scene/hiding/obscuration.h"

namespace obscura::detail {

/// A quantity with and without the cloud and what one is of the other; none: it has no meaning, or no name there.
struct ObscurationRow {
  std::string quantity, unit;
  std::optional<Confident> with, without, ratio;
};

/// Numbers without an interval have NaN for its ends.
std::vector<ObscurationRow> obscuration_rows(const BandObscuration& band, const ObscurationSettings& thresholds);

/// "0.3 [0.29, 0.31]"
std::string confident_text(const std::optional<Confident>& c);

/// How much of the picture the object has and how it was looked at.
std::string object_text(const ObjectObscuration& object);

}  // namespace obscura::detail
