// Power through a rectangle: how often a photon's flight crosses it.
#pragma once

#include "photon/world/world.h"

namespace obscura {

/// A rectangle whose passing power is counted. Its normal is along side_u x side_v.
struct FluxRectangle {
  Vec3d center;
  Vec3d side_u, side_v;  ///< full sides, m, at right angles

  bool operator==(const FluxRectangle&) const = default;
};

/// Unit sides of a rectangle with this unit normal: the first is horizontal, or along x where the
/// rectangle lies flat; their cross product is the normal.
inline std::pair<Vec3d, Vec3d> rectangle_sides(const Vec3d& normal) noexcept {
  const Vec3d horizontal = Vec3d(0, 0, 1).cross(normal);
  const Vec3d u = horizontal.length() > 1e-9 ? horizontal.normalized() : Vec3d(1, 0, 0);
  return {u, normal.cross(u)};
}

/// How many times the segment o + t d, 0 < t <= t_end, crosses the rectangle along its normal, less how
/// often against it. In a periodic World every copy of the rectangle counts; its normal must then be at
/// right angles to the period vectors.
inline int crossings(const World& world, const FluxRectangle& rectangle, const Vec3d& o, const Vec3d& d,
                     double t_end) noexcept {
  const Vec3d normal = rectangle.side_u.cross(rectangle.side_v);
  const double along = d.dot(normal);
  if (along == 0) return 0;
  const double t = (rectangle.center - o).dot(normal) / along;
  if (!(t > 0 && t <= t_end) || t == kInfinity) return 0;
  const int sign = along > 0 ? 1 : -1;
  const double uu = rectangle.side_u.length2();
  const double vv = rectangle.side_v.length2();
  Vec3d offset = o + t * d - rectangle.center;
  const auto inside = [&](const Vec3d& p) {
    const double a = p.dot(rectangle.side_u);
    const double b = p.dot(rectangle.side_v);
    return a >= -0.5 * uu && a < 0.5 * uu && b >= -0.5 * vv && b < 0.5 * vv;
  };
  if (!world.periodic()) return inside(offset) ? sign : 0;

  // Into the copy about the centre, then every copy that the rectangle reaches over.
  std::array<int, 2> reach{0, 0};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const Vec3d& period = world.period()[axis];
    const double length2 = period.length2();
    if (length2 == 0) continue;
    offset -= std::round(offset.dot(period) / length2) * period;
    reach[axis] = 1 + static_cast<int>(std::ceil(0.5 * (std::sqrt(uu) + std::sqrt(vv)) / std::sqrt(length2)));
  }
  int count = 0;
  for (int i = -reach[0]; i <= reach[0]; ++i) {
    for (int j = -reach[1]; j <= reach[1]; ++j) {
      count += inside(offset + double(i) * world.period()[0] + double(j) * world.period()[1]);
    }
  }
  return sign * count;
}

}  // namespace obscura
