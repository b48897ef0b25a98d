// Builds an Octree from a stream of voxels: lossless, or merged and quantised within an error of the
// transmission that is measured on rays, never guessed.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "octree/base/progress.h"
#include "octree/source/voxels.h"
#include "octree/tree/octree.h"

namespace obscura {

/// What a deviation of a value costs. It is given by who knows optics; the octree does not.
struct ErrorMeasure {
  /// Per channel: optical depth per (unit of value x metre), in the band where it is largest. 0: does not attenuate.
  std::vector<double> optical_weight;
  /// Emitted radiance per metre of a cell with these values (one per channel), relative to the largest
  /// radiance that the cloud can have. Empty: nothing is emitted. Called from several threads.
  std::function<double(std::span<const float>)> emission;
};

struct BuildSettings {
  double tolerance = 1e-3;  ///< of a whole ray's transmission (and of its emitted radiance, relative); 0: lossless
  ErrorMeasure measure;     ///< needed where tolerance > 0
  std::uint64_t seed = 1;   ///< of the measuring rays
};

struct BuildReport {
  double error_measured = 0;           ///< largest error of the transmission over the measuring rays
  double error_bound = 0;              ///< rigorous bound of it over all rays
  double emission_error_measured = 0;  ///< largest error of the emitted radiance over the measuring rays, relative
  double merging_error = 0;            ///< part of error_measured there is with merging alone
  double merged_share = 0;             ///< share of the tolerance that went to merging
  double quantised_share = 0;          ///< share of the tolerance that went to quantising
  std::uint64_t rays = 0;              ///< measuring rays
  double seconds = 0;                  ///< whole build, pouring included
  double pour_seconds = 0;             ///< pouring alone
};

/// Builds the octree in one streaming pass. The result is the same for any number of threads.
/// @throws InputError where stream and settings do not fit each other; ResourceError where the domain or
/// the data exceed what an octree holds (kMaxTopCells, kMaxRecordBytes), or when the work was cancelled.
std::pair<Octree, BuildReport> build_octree(const VoxelStream& stream, const BuildSettings& settings,
                                            const Progress& progress = {});

}  // namespace obscura
