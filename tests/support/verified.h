// How well a table of reference values and a method agree, gathered while a test compares them: worst
// deviation, worst z, error of the whole. Where OBSCURA_VERIFICATION names a file, each such comparison
// appends a row to it, from which tests/verification.sh makes VERIFICATION.md.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "octree/base/statistics.h"
#include "tests/support/agree.h"
#include "tests/support/csv.h"
#include "tests/support/places.h"

namespace obscura::test {

/// A table of tests/data/reference.
inline Csv reference_table(const std::string& file) { return Csv(data_file("reference/" + file)); }

class Verified {
 public:
  /// @param file of tests/data/reference; @param method "path tracer", "photon tracing", ...
  /// @param what is compared; @param asked accuracy that the comparison demands
  Verified(std::string file, std::string method, std::string what, std::string asked)
      : file_(std::move(file)), method_(std::move(method)), what_(std::move(what)), asked_(std::move(asked)) {}
  Verified(const Verified&) = delete;
  Verified& operator=(const Verified&) = delete;

  ~Verified() {
    const char* path = std::getenv("OBSCURA_VERIFICATION");
    if (!path || count_ == 0) return;
    std::ofstream(path, std::ios::app) << file_ << " | " << method_ << " | " << what_ << " | " << count_ << " | "
                                       << asked_ << " | " << reached() << '\n';
  }

  /// Deviation relative to `scale` (none: to the reference) within the tolerance.
  bool within(double value, double reference, double tolerance, double scale = 0) {
    const double deviation = std::abs(value - reference);
    const double relative = deviation == 0 ? 0 : deviation / (scale > 0 ? scale : std::abs(reference));
    ++count_;
    worst_ = std::max(worst_, relative);
    if (!(relative <= tolerance)) ++failed_;
    return relative <= tolerance;
  }

  /// By the statistical rule of agree.h.
  Agreement mean(const BatchMean& found, double reference, const AgreeOptions& options) {
    const Agreement verdict = agree(found.mean, found.standard_error, reference, options);
    if (!verdict) ++failed_;
    ++count_;
    statistical_ = true;
    z2_ += verdict.z * verdict.z;
    worst_z_ = std::max(worst_z_, std::abs(verdict.z));
    if (reference != 0) {
      const double error = verdict.error / std::abs(reference);
      worst_error_ = std::max(worst_error_, error);
      if (error > 0) {
        weight_ += 1 / (error * error);
        weighted_ += (found.mean / reference - 1) / (error * error);
      }
    }
    return verdict;
  }

  /// Mean relative deviation of all comparisons, weighted with their errors: what all have in common is
  /// seen much more sharply than what one of them has.
  BatchMean common() const {
    return weight_ > 0 ? BatchMean{weighted_ / weight_, 1 / std::sqrt(weight_)} : BatchMean{};
  }

  /// In place of what the comparisons say.
  void note(std::string reached) { note_ = std::move(reached); }

  int count() const { return count_; }
  double worst() const { return worst_; }
  /// About 1 where the errors are told rightly.
  double rms_z() const { return count_ ? std::sqrt(z2_ / count_) : 0.0; }

 private:
  std::string reached() const {
    char text[240];
    if (!note_.empty()) {
      std::snprintf(text, sizeof text, "%s", note_.c_str());
    } else if (statistical_) {
      std::snprintf(text, sizeof text, "worst z %.1f (rms %.2f), SE up to %.2g %%, together %+.3f +- %.3f %%", worst_z_,
                    std::sqrt(z2_ / count_), 100 * worst_error_, 100 * common().mean, 100 * common().standard_error);
    } else {
      std::snprintf(text, sizeof text, "worst %.1e", worst_);
    }
    std::string result = text;
    if (failed_) result.append(", ").append(std::to_string(failed_)).append(" FAILED");
    return result;
  }

  std::string file_, method_, what_, asked_, note_;
  int count_ = 0, failed_ = 0;
  bool statistical_ = false;
  double worst_ = 0, worst_z_ = 0, worst_error_ = 0, z2_ = 0, weight_ = 0, weighted_ = 0;
};

}  // namespace obscura::test
