// How closely comparisons with a reference table are held, by the rule of agree.h.
#pragma once

#include <catch2/catch.hpp>

#include "tests/support/verified.h"

namespace obscura::test {

/// Each comparison: standard error of at most `error` (of the quantity, in its unit), z below its limit.
inline AgreeOptions held_to(double reference, double error, double comparisons, double batches,
                            double reference_error = 0) {
  const double limit = student_limit(kFalseAlarm / comparisons, batches - 1);
  return {.resolution = error * (limit + 3.09) / std::abs(reference),
          .reference_error = reference_error,
          .comparisons = comparisons,
          .degrees_of_freedom = batches - 1};
}

/// What all comparisons of a table have in common is known much better than one of them: no bias beyond its
/// error, that error below `largest_error`, and single errors that are told rightly.
inline void check_common(const Verified& verified, double largest_error) {
  INFO("in common " << verified.common().mean << " +- " << verified.common().standard_error);
  CHECK(std::abs(verified.common().mean) < 4.9 * verified.common().standard_error);
  CHECK(verified.common().standard_error < largest_error);
  // Its own scatter is 1 / sqrt(2 n).
  CHECK(std::abs(verified.rms_z() - 1) < 0.05 + 4.9 / std::sqrt(2.0 * verified.count()));
}

}  // namespace obscura::test
