// A whole run: from the description to image and report.
#pragma once

#include <optional>
#include <string>

#include "octree/base/progress.h"
#include "scene/file/description.h"
#include "scene/run/report.h"
#include "sensor/picture/image.h"

namespace obscura {

struct RunOptions {
  std::optional<double> time_s;  ///< in place of the scene's
  int threads = 0;               ///< 0: all
};

struct RunResult {
  Image image;
  Report report;
  /// Why the numbers cannot be trusted, where they cannot: more than one anomaly in a million.
  std::optional<std::string> failure;
};

/// @throws InputError, ResourceError, NumericalError (the method refuses the scene). Cancelled: what
/// there is, marked partial.
RunResult run_scene(const Description& scene, const RunOptions& options, const Progress& progress = {});

}  // namespace obscura
