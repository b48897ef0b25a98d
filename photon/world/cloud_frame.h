// Where a cloud stands in the World, how it repeats, and what of a ray lies in each of its cells.
#pragma once

#include <array>
#include <optional>

#include "octree/base/math.h"
#include "photon/world/cloud.h"

namespace obscura {

/// Where a cloud is and how it repeats.
struct CloudFrame {
  Affine world_to_local;
  Affine local_to_index;
  Affine world_to_index;
  Affine map_to_local;
  Affine map_to_index;
  Box3d local_bounds;  ///< of the octree's domain, in the cloud's own metres
  std::array<double, 2> period_m{0, 0};
  double voxel_m = 0;  ///< longest side of a voxel in the world, m

  bool periodic() const noexcept { return period_m[0] > 0 || period_m[1] > 0; }
  /// A point of the cloud's own metres, moved into the first cell.
  Vec3d wrap(Vec3d local) const noexcept;
};

/// The frame of a cloud, without the transforms from the map, which the World knows.
/// @throws InputError where the cloud is not what kernels rely on (singular placement, too many channels, a period
/// smaller than the grid)
CloudFrame make_cloud_frame(const Cloud& cloud);

/// The longest side of a cloud's leaves in the world, of bricks at least, m.
double largest_leaf_m(const Cloud& cloud) noexcept;

/// The ray of one cloud in its own index space, once for a plain cloud and once for every cell that
/// the ray crosses for a periodic one, front to back.
class CellRays {
 public:
  CellRays(const CloudFrame& frame, const Ray& world_ray) noexcept;

  /// The next piece of the ray, or nothing. t keeps its meaning.
  std::optional<Ray> next() noexcept;

 private:
  // A ray inside a periodic layer never leaves it; this many cells are as good as infinity.
  static constexpr int kMaxCells = 1 << 20;

  const CloudFrame* frame_;
  Ray local_;
  double t_ = 0;
  std::array<double, 2> cell_{0, 0};
  int cells_ = 0;
  bool done_ = false;
};

}  // namespace obscura
