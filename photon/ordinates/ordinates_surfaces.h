// Surfaces on the grid of discrete ordinates: faces of cells that are opaque because a surface lies between
// the middles of the two cells.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "photon/ordinates/ordinates_grid.h"
#include "photon/world/spectral_world.h"

namespace obscura {

/// One side of an opaque face.
struct OrdinatesSide {
  bool inside = true;  ///< false: looks out of the grid, where nothing is solved
  int axis = 0;
  Vec3i cell;  ///< that it looks into, or looks out of
  FaceId id;
  Vec3d position, normal;  ///< of the true surface, world
  double emission = 0;     ///< W/m2/sr
  double reflectance = 0;
  double sunlight = 0;   ///< irradiance by sun and moon at first hand, W/m2
  double reflected = 0;  ///< radiance, once solved
};

struct OrdinatesSurfaces {
  /// @pre unfit_for_ordinates() has nothing to say
  OrdinatesSurfaces(SpectralWorld world, const OrdinatesGrid& grid);

  bool empty() const noexcept { return sides.empty(); }
  /// The opaque face that stands for a place on a surface; null: none is near.
  const OrdinatesSide* nearest(const OrdinatesGrid& grid, const Vec3d& world_point,
                               const Vec3d& world_normal) const noexcept;

  /// [axis][face]: number of the surface on the lower face of a cell, -1 none; one more than cells along the axis.
  std::array<std::vector<std::int32_t>, 3> faces;
  std::vector<OrdinatesSide> sides;  ///< [surface][side]; side 1 looks up the axis
  std::vector<bool> touched;         ///< cells with an opaque face; empty: none
};

}  // namespace obscura
