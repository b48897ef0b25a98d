// Vectors, boxes, affine maps and rays: names for Imath's types and what Imath lacks.
#pragma once

#include <ImathBox.h>
#include <ImathMatrix.h>
#include <ImathVec.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace obscura {

using Vec3d = Imath::V3d;
using Vec3f = Imath::V3f;
using Vec3i = Imath::V3i;
using Box3d = Imath::Box3d;
using Box3i = Imath::Box3i;

/// An affine map in Imath's row-vector convention: a point p maps to p * M. `A * B` is first A, then B.
using Affine = Imath::M44d;

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kPi = std::numbers::pi;

/// A half-line or segment: origin + t * direction for t in [t_min, t_max]. The direction need not be
/// a unit vector, so that an affine map keeps t: a world ray in metres stays in metres in any index space.
struct Ray {
  Vec3d origin{0, 0, 0};
  Vec3d direction{0, 0, 1};
  double t_min = 0;
  double t_max = kInfinity;

  Vec3d at(double t) const noexcept { return origin + t * direction; }
};

inline Vec3d transform_point(const Affine& map, const Vec3d& point) noexcept {
  Vec3d result;
  map.multVecMatrix(point, result);
  return result;
}

inline Vec3d transform_direction(const Affine& map, const Vec3d& direction) noexcept {
  Vec3d result;
  map.multDirMatrix(direction, result);
  return result;
}

/// The same ray seen through an affine map; t keeps its meaning.
inline Ray transform_ray(const Affine& map, const Ray& ray) noexcept {
  return {transform_point(map, ray.origin), transform_direction(map, ray.direction), ray.t_min, ray.t_max};
}

/// Determinant of the linear part: the volume of one unit cube after the map.
inline double linear_determinant(const Affine& m) noexcept {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/// Two unit vectors that form a right-handed frame with the unit vector n (Duff et al., JCGT 6(1), 2017).
inline std::pair<Vec3d, Vec3d> orthonormal_basis(const Vec3d& n) noexcept {
  const double sign = std::copysign(1.0, n.z);
  const double a = -1.0 / (sign + n.z);
  const double b = n.x * n.y * a;
  return {Vec3d(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3d(b, sign + n.y * n.y * a, -n.y)};
}

/// The map p -> translation + Rz Ry Rx (scale p), right-handed rotations about the axes, radians.
Affine placement(const Vec3d& translation, const Vec3d& rotation, double scale) noexcept;

/// Interval of t in which the ray is inside the box, within the ray's own [t_min, t_max]; empty (first > second)
/// where it misses. A ray that lies in a face counts as inside on the lower side only: the box is [min, max).
std::pair<double, double> clip(const Ray& ray, const Box3d& box) noexcept;

/// The smallest box that holds the image of a box under an affine map.
Box3d transform_box(const Affine& map, const Box3d& box) noexcept;

}  // namespace obscura
