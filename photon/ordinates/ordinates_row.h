// What the kernel of the sweep is given for a row of cells.
#pragma once

#include "photon/ordinates/ordinates_sweep.h"

namespace obscura::detail {

/// Of one octant at S32: 16 levels of 16 azimuths.
inline constexpr std::size_t kMostOrdinates = 256;

struct RowJob {
  const SweepAngles* angles;
  const SweepArrays* arrays;
  int octant;
  bool surfaces;
  /// Angular fluxes on the faces across each axis where the sweep stands, [row][corner][ordinate], rows
  /// counted in the octant's own direction.
  std::array<double*, 3> face;
};

/// For every opaque face through which light would enter the cell: what arrives there is added to the surface's
/// irradiance, and what the surface sends off enters the cell in its place.
void pass_surfaces(const RowJob& job, const Vec3i& cell, const std::array<double*, 3>& faces) noexcept;

}  // namespace obscura::detail
