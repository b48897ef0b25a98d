// A rough cloud for agreement tests: voids, thin beside thick, and a smooth slab edge to graze.
#pragma once

#include "tests/support/voxel_fields.h"

namespace obscura::test {

inline constexpr int kRoughSide = 32;

/// Density in [0, 4]: a third of the 4^3 cells are void, thick cells stand beside thin ones, voxels
/// vary by a factor of up to 4; the lowest quarter is a uniform slab.
inline double rough_density(const Vec3i& v) {
  for (int axis = 0; axis < 3; ++axis) {
    if (v[axis] < 0 || v[axis] >= kRoughSide) return 0;
  }
  if (v.z < kRoughSide / 4) return 0.5;
  const Vec3i cell(v.x >> 2, v.y >> 2, v.z >> 2);
  const double kind = voxel_noise(5, cell, 1);
  if (kind < 0.35) return 0;
  const double level = kind < 0.7 ? 0.04 : 2.0;
  return level * (0.5 + 1.5 * voxel_noise(5, v, 2));
}

}  // namespace obscura::test
