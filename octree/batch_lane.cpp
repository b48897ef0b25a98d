#include "octree/batch_lane.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace obscura::detail {

Prepared prepare_lane(const TreeData& tree, const Ray& ray, LaneRay& lane) noexcept {
  const double length = std::sqrt(ray.direction.x * ray.direction.x + ray.direction.y * ray.direction.y +
                                  ray.direction.z * ray.direction.z);
  assert(length > 0 && std::isfinite(length));
  if (!(length > 0 && length < kInfinity)) return Prepared::misses;

  double enter = ray.t_min * length, leave = ray.t_max * length;
  double direction[3];
  const double per_length = 1 / length;
  bool cut = true;
  for (int axis = 0; axis < 3; ++axis) {
    const double o = ray.origin[axis];
    const double d = direction[axis] = ray.direction[axis] * per_length;
    const double low = tree.domain.min[axis], high = tree.domain.max[axis];
    if (std::abs(d) < std::numeric_limits<double>::min()) {
      direction[axis] = 0;
      if (!(o >= low && o < high)) return Prepared::misses;
      continue;
    }
    const double inverse = 1 / d;
    const double to_low = (low - o) * inverse, to_high = (high - o) * inverse;
    enter = std::max(enter, d > 0 ? to_low : to_high);
    const double exit = d > 0 ? to_high : to_low;
    if (exit <= leave) {
      leave = exit;
      cut = false;
    }
  }
  if (!(enter < leave)) return Prepared::misses;

  const std::int32_t whole = static_cast<std::int32_t>(1) << tree.top_level;
  for (int axis = 0; axis < 3; ++axis) {
    const double d = direction[axis];
    const double p = ray.origin[axis] + enter * d;  // of a parallel ray: exactly where it is
    const int low = tree.domain.min[axis], high = tree.domain.max[axis], origin = tree.origin[axis];
    double voxel, fraction;
    if (d < 0) {
      voxel = std::clamp(std::ceil(p) - 1, static_cast<double>(low), static_cast<double>(high - 1));
      fraction = voxel + 1 - p;
      lane.voxel[axis] = whole - 1 - (static_cast<std::int32_t>(voxel) - origin);
      lane.limit[axis] = whole - (low - origin);
      lane.mirror[axis] = -1;
    } else {
      voxel = std::clamp(std::floor(p), static_cast<double>(low), static_cast<double>(high - 1));
      fraction = p - voxel;
      lane.voxel[axis] = static_cast<std::int32_t>(voxel) - origin;
      lane.limit[axis] = high - origin;
      lane.mirror[axis] = 0;
    }
    lane.fraction[axis] = std::clamp(static_cast<float>(fraction), 0.0f, kBelowOne);
    lane.direction[axis] = static_cast<float>(std::abs(d));
    lane.inverse[axis] = static_cast<float>(1 / std::abs(d));
    if (std::abs(d) < kShallow) {
      // All but parallel: it stays in its layer of voxels or is left to the scalar walk.
      if (fraction + std::abs(d) * (leave - enter) * (1 + 1e-12) >= 1) return Prepared::shallow;
      lane.direction[axis] = 0;
      lane.inverse[axis] = kParallel;
    }
  }
  lane.length = leave - enter;
  lane.per_t = length;
  lane.t_enter = enter * per_length;
  lane.cut = cut;
  return Prepared::lane;
}

}  // namespace obscura::detail
