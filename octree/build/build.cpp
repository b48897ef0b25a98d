#include "octree/build/build.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "octree/base/error.h"
#include "octree/build/collect.h"
#include "octree/build/compress.h"
#include "octree/build/measure.h"

namespace obscura {
namespace {

constexpr std::size_t kTrialRays = 8192;  // that judge a trial; the last word have all
constexpr double kMergeShare = 0.5;       // of the tolerance that merging may use
constexpr double kLargestThreshold = 0.05;

// Finds threshold and step whose measured error stays within the tolerance.
class Search {
 public:
  Search(const Octree& lossless, const BuildSettings& settings, const Progress& progress)
      : settings_(settings),
        progress_(progress),
        analysis_(detail::analyse(lossless.data(), settings.measure)),
        rays_(lossless, settings.measure, settings.seed),
        occupied_(lossless.domain()) {}

  detail::Compressed run(BuildReport& report) {
    const double tolerance = settings_.tolerance;

    // Quantising alone: the error grows in proportion to the step. A ray crosses n cells whose errors are
    // uniform in +-step/2: the first guess. Four bits of the largest extinction remain in any case.
    const Vec3i extent = occupied_.max - occupied_.min;
    const double n = std::max(1, std::max(std::max(extent.x, extent.y), extent.z));
    const double chord = analysis_.voxel_chord_m / std::sqrt(3.0);
    const double largest_step = std::max(1e-300, analysis_.largest_extinction / 15);
    detail::Compression how{0, std::min(largest_step, tolerance / (chord * std::sqrt(n)))};
    double error = fit(how, how.step, largest_step, tolerance);
    std::size_t bytes = trial_.tree.record_bytes;

    // Merging with what it may have of the tolerance; kept where it makes the tree smaller.
    detail::Compression merging{kMergeShare * tolerance, how.step / 32};
    if (would_merge(kLargestThreshold * 0.1)) {
      const double merge_error = fit(merging, merging.merge_threshold, kLargestThreshold, kMergeShare * tolerance);
      detail::Compression both{merging.merge_threshold, how.step};
      const double both_error = fit(both, both.step, largest_step, tolerance);
      if (trial_.tree.record_bytes < bytes) {
        how = both;
        error = both_error;
        report.merging_error = merge_error;
      }
    }

    // All measuring rays decide at the end.
    for (int attempt = 0;; ++attempt) {
      detail::Compressed result = detail::compress(analysis_, how);
      Octree tree(std::move(result.tree));
      const auto errors = rays_.compare(tree, detail::MeasuringRays::kCount);
      error = errors.largest();
      if (error <= tolerance || attempt == 8) {
        report.error_measured = errors.transmission;
        report.source_error_measured = errors.source;
        report.rays = detail::MeasuringRays::kCount;
        report.merged_share = std::min(1.0, report.merging_error / tolerance);
        report.quantised_share = std::max(0.0, error / tolerance - report.merged_share);
        report.error_bound = -std::expm1(-result.depth_bound);
        result.tree = std::move(tree).take();
        return result;
      }
      const double less = 0.9 * tolerance / error;
      how.step *= less;
      how.merge_threshold *= less;
      report.merging_error *= less;
    }
  }

 private:
  // Scales one number of the compression until the trial's error is a little below the goal.
  double fit(detail::Compression& how, double& number, double largest, double goal) {
    double error = 0;
    for (int trial = 0; trial < 6; ++trial) {
      if (progress_.cancelled()) throw ResourceError("octree", "cancelled while it was compressed");
      progress_.report("compressing the octree", static_cast<std::uint64_t>(trial), 6);
      trial_ = detail::compress(analysis_, how);
      Octree tree(std::move(trial_.tree));
      error = rays_.compare(tree, kTrialRays).largest();
      trial_.tree = std::move(tree).take();
      const bool enough = error > 0.6 * goal || number >= largest;
      if (error <= 0.9 * goal && enough) break;
      number = std::min(largest, number * std::clamp(0.78 * goal / std::max(error, 1e-300), 1.0 / 64, 64.0));
    }
    return error;
  }

  bool would_merge(double threshold) const {
    for (const detail::BrickAnalysis& brick : analysis_.bricks) {
      if (static_cast<double>(brick.cost[0]) <= threshold) return true;
    }
    return false;
  }

  const BuildSettings& settings_;
  const Progress& progress_;
  detail::Analysis analysis_;
  detail::MeasuringRays rays_;
  Box3i occupied_;
  detail::Compressed trial_;
};

void require_measure(const VoxelStream& stream, const BuildSettings& settings) {
  const double tolerance = settings.tolerance;
  if (!(tolerance >= 0 && tolerance < 1)) {
    throw InputError("octree_tolerance", fmt::format("is {}", tolerance),
                     "give a number from 0 up to, not including, 1");
  }
  if (tolerance == 0) return;
  const std::vector<double>& weights = settings.measure.optical_weight;
  if (weights.size() != stream.channels.size()) {
    throw InputError(stream.name,
                     fmt::format("has {} channels but {} optical weights", stream.channels.size(), weights.size()),
                     "give one per channel, or tolerance 0");
  }
  for (std::size_t c = 0; c < weights.size(); ++c) {
    if (!(weights[c] >= 0 && std::isfinite(weights[c]))) {
      throw InputError(fmt::format("{}, {}", stream.name, stream.channels[c]),
                       fmt::format("its optical weight is {}", weights[c]), "give a finite one that is not negative");
    }
  }
}

}  // namespace

std::pair<Octree, BuildReport> build_octree(const VoxelStream& stream, const BuildSettings& settings,
                                            const Progress& progress) {
  using Clock = std::chrono::steady_clock;
  const auto seconds_since = [](Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  require_measure(stream, settings);
  const Clock::time_point start = Clock::now();
  BuildReport report;
  Octree lossless(detail::collect(stream, progress));
  report.pour_seconds = seconds_since(start);
  if (settings.tolerance == 0 || lossless.block_count() == 0) {
    report.seconds = seconds_since(start);
    return {std::move(lossless), report};
  }
  detail::Compressed compressed = Search(lossless, settings, progress).run(report);
  report.seconds = seconds_since(start);
  return {Octree(std::move(compressed.tree)), report};
}

}  // namespace obscura
