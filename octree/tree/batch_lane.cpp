#include "octree/tree/batch_lane.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace obscura::detail {

Prepared prepare_lane(const TreeData& tree, const Ray& ray, LaneRay& lane) noexcept {
  const double length = std::sqrt(ray.direction.x * ray.direction.x + ray.direction.y * ray.direction.y +
                                  ray.direction.z * ray.direction.z);
  assert(length > 0 && std::isfinite(length));
  if (!(length > 0 && length < kInfinity)) return Prepared::misses;

  // Mirrored so that no direction is negative: a face that the ray starts in is then always the lower one.
  double enter = ray.t_min * length, leave = ray.t_max * length;
  const double per_length = 1 / length, t_end = leave;
  double origin[3], direction[3], inverse[3], high[3], low[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double d = std::abs(ray.direction[axis]) * per_length;
    const bool mirrored = ray.direction[axis] < 0 && d >= std::numeric_limits<double>::min();
    const double sign = mirrored ? -1.0 : 1.0;
    origin[axis] = sign * ray.origin[axis];
    direction[axis] = d;
    low[axis] = mirrored ? -tree.domain.max[axis] : tree.domain.min[axis];
    high[axis] = mirrored ? -tree.domain.min[axis] : tree.domain.max[axis];
    if (d < std::numeric_limits<double>::min()) {
      direction[axis] = 0;
      inverse[axis] = kInfinity;
      if (!(origin[axis] >= low[axis] && origin[axis] < high[axis])) return Prepared::misses;
      continue;
    }
    inverse[axis] = 1 / d;
    enter = std::max(enter, (low[axis] - origin[axis]) * inverse[axis]);
    leave = std::min(leave, (high[axis] - origin[axis]) * inverse[axis]);
  }
  if (!(enter < leave)) return Prepared::misses;

  const std::int32_t whole = std::int32_t{1} << tree.top_level;
  for (int axis = 0; axis < 3; ++axis) {
    const bool mirrored = ray.direction[axis] < 0 && direction[axis] > 0;
    const double d = direction[axis];
    const double p = origin[axis] + enter * d;  // where the ray is parallel to the axis: its origin, without rounding
    const double voxel = std::min(std::max(std::floor(p), low[axis]), high[axis] - 1);
    const double fraction = p - voxel;
    const std::int32_t shift = mirrored ? whole + tree.origin[axis] : -tree.origin[axis];
    lane.voxel[axis] = static_cast<std::int32_t>(voxel) + shift;
    lane.limit[axis] = static_cast<std::int32_t>(high[axis]) + shift;
    lane.mirror[axis] = mirrored ? -1 : 0;
    lane.fraction[axis] = std::min(std::max(static_cast<float>(fraction), 0.0f), kBelowOne);
    lane.direction[axis] = static_cast<float>(d);
    lane.inverse[axis] = static_cast<float>(std::min(inverse[axis], static_cast<double>(kParallel)));
    if (d < kShallow) {
      // Nearly parallel: if it crosses no plane it stays in its layer of voxels, whatever rounding does to its place.
      // Else the scalar walk takes it, which compares the planes' times.
      const double doubt =
          d > 0 ? 4 * std::numeric_limits<double>::epsilon() * (std::abs(origin[axis]) + std::abs(p)) : 0.0;
      if (fraction < doubt || fraction + d * (leave - enter) * (1 + 1e-12) + doubt >= 1) return Prepared::shallow;
      lane.direction[axis] = 0;
      lane.inverse[axis] = kParallel;
    }
  }
  lane.length = leave - enter;
  lane.per_t = length;
  lane.t_enter = enter * per_length;
  lane.cut = leave == t_end;
  return Prepared::lane;
}

}  // namespace obscura::detail
