// When does a measured mean agree with a reference? It must be within the limit z* of its standard
// error, and that error must be small enough to have seen the bias that the test is there to see.
#pragma once

#include <cmath>
#include <limits>
#include <ostream>

#include "tests/support/distributions.h"

namespace obscura::test {

/// Verdict and its reasons; prints itself in a failing CHECK.
struct Agreement {
  double value, reference;
  double z, z_limit;
  double error, error_limit;
  explicit operator bool() const { return std::abs(z) <= z_limit && error <= error_limit; }
};

inline std::ostream& operator<<(std::ostream& out, const Agreement& a) {
  return out << "value " << a.value << " against " << a.reference << ": z = " << a.z << " (limit " << a.z_limit
             << "), standard error " << a.error << " (limit " << a.error_limit << ")"
             << (std::abs(a.z) <= a.z_limit ? "" : " OFF") << (a.error <= a.error_limit ? "" : " TOO WEAK");
}

inline constexpr double kFalseAlarm = 1e-6;

struct AgreeOptions {
  double resolution = 0.01;    ///< relative bias that the test must be able to see
  double reference_error = 0;  ///< standard error of the reference
  double comparisons = 1;      ///< how many such comparisons the test makes
  double degrees_of_freedom = std::numeric_limits<double>::infinity();  ///< 15 for 16 batches
};

/// |z| <= z* and total error <= resolution |reference| / (z* + 3.09): a bias of the stated
/// resolution is then found with a probability of 99.9 %. z* belongs to a false-alarm rate of 1e-6
/// shared among the comparisons (Bonferroni). `CHECK(agree(mean, error, truth, {.resolution =
/// 0.01}))`
inline Agreement agree(double value, double standard_error, double reference, const AgreeOptions& options = {}) {
  const double limit = student_limit(kFalseAlarm / options.comparisons, options.degrees_of_freedom);
  const double error = std::hypot(standard_error, options.reference_error);
  const double difference = value - reference;
  const double z = difference == 0 ? 0 : difference / error;
  return {value, reference, z, limit, error, options.resolution * std::abs(reference) / (limit + 3.09)};
}

}  // namespace obscura::test
