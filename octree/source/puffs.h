// A smoke screen of a few pyrotechnic sources: Gaussian puffs that drift, rise, grow and break up.
// For demonstrations and tests; not a dispersion model to decide by (formulas: octree/METHODS.md).
#pragma once

#include <cstdint>
#include <vector>

#include "octree/source/voxels.h"

namespace obscura {

struct PuffSource {
  Vec3d position_m{0, 0, 0};
  double mass_g = 0;  ///< whole yield, released at a constant rate over burn_s
  double burn_s = 0;  ///< 0: all at once
  double K = 600;     ///< at the source; what the smoke is diluted with has 288 K
};

struct PuffSettings {
  std::vector<PuffSource> sources;
  Vec3d wind_m_s{0, 0, 0};
  double turbulence = 0.3;  ///< 0: smooth puffs; 0.3: a usual day; at most 1
  double age_s = 20;        ///< since ignition of all sources
  double voxel_m = 0.25;
  std::uint64_t seed = 1;
};

/// Channels "density" (g/m3) and "temperature" (K). The sum of density times voxel volume is the mass
/// released by age_s to 1e-6. Smoke stays above z = 0 where no source lies below. The same bits for
/// any number of threads. Computes at once and keeps the voxels, 8 bytes each, in the stream.
/// @throws InputError for values out of range, or when the smoke would take more than 2^27 voxels.
VoxelStream puffs_stream(const PuffSettings& settings);

}  // namespace obscura
