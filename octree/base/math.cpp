#include "octree/base/math.h"

#include <algorithm>

namespace obscura {

std::pair<double, double> clip(const Ray& ray, const Box3d& box) noexcept {
  double enter = ray.t_min;
  double leave = ray.t_max;
  for (int axis = 0; axis < 3; ++axis) {
    const double o = ray.origin[axis];
    const double d = ray.direction[axis];
    if (d == 0) {
      if (o < box.min[axis] || o >= box.max[axis]) return {kInfinity, -kInfinity};
      continue;
    }
    const double to_min = (box.min[axis] - o) / d;
    const double to_max = (box.max[axis] - o) / d;
    enter = std::max(enter, std::min(to_min, to_max));
    leave = std::min(leave, std::max(to_min, to_max));
  }
  return {enter, leave};
}

Affine placement(const Vec3d& translation, const Vec3d& rotation, double scale) noexcept {
  Affine result;
  result.makeIdentity();
  for (int axis = 0; axis < 3; ++axis) {
    const int a = (axis + 1) % 3;
    const int b = (axis + 2) % 3;
    Affine turn;
    turn.makeIdentity();
    turn[a][a] = turn[b][b] = std::cos(rotation[axis]);
    turn[a][b] = std::sin(rotation[axis]);
    turn[b][a] = -std::sin(rotation[axis]);
    result = result * turn;
  }
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) result[row][column] *= scale;
  }
  for (int column = 0; column < 3; ++column) result[3][column] = translation[column];
  return result;
}

Box3d transform_box(const Affine& map, const Box3d& box) noexcept {
  Box3d result;
  if (box.isEmpty()) return result;
  for (int corner = 0; corner < 8; ++corner) {
    result.extendBy(transform_point(map, Vec3d(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                                               corner & 4 ? box.max.z : box.min.z)));
  }
  return result;
}

}  // namespace obscura
