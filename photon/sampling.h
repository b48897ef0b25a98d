// Points and directions from uniform numbers.
#pragma once

#include <algorithm>

#include "octree/base/math.h"

namespace obscura {

/// Uniform over the unit sphere.
inline Vec3d uniform_direction(double u, double v) noexcept {
  const double z = 1 - 2 * u;
  const double s = std::sqrt(std::max(0.0, 1 - z * z));
  return {s * std::cos(2 * kPi * v), s * std::sin(2 * kPi * v), z};
}

/// Uniform over the unit disc, area-preserving and continuous (Shirley and Chiu, JGT 2(3), 1997).
inline std::pair<double, double> uniform_disc(double u, double v) noexcept {
  const double a = 2 * u - 1;
  const double b = 2 * v - 1;
  if (a == 0 && b == 0) return {0, 0};
  double r, phi;
  if (a * a > b * b) {
    r = a;
    phi = kPi / 4 * (b / a);
  } else {
    r = b;
    phi = kPi / 2 - kPi / 4 * (a / b);
  }
  return {r * std::cos(phi), r * std::sin(phi)};
}

/// A direction at the given cosine from a unit vector, turned about it by the angle phi.
inline Vec3d direction_about(const Vec3d& axis, double cosine, double phi) noexcept {
  const auto [a, b] = orthonormal_basis(axis);
  const double sine = std::sqrt(std::max(0.0, (1 - cosine) * (1 + cosine)));
  return (cosine * axis + sine * (std::cos(phi) * a + std::sin(phi) * b)).normalized();
}

/// Cosine-weighted about a normal (Malley's method).
inline Vec3d cosine_direction(const Vec3d& normal, double u, double v) noexcept {
  const auto [x, y] = uniform_disc(u, v);
  const auto [a, b] = orthonormal_basis(normal);
  return (x * a + y * b + std::sqrt(std::max(0.0, 1 - x * x - y * y)) * normal).normalized();
}

/// Uniform in the cone about an axis whose half angle has the given sine; no cancellation in
/// narrow cones. Also returns the solid angle, sr.
inline std::pair<Vec3d, double> cone_direction(const Vec3d& axis, double sine, double u, double v) noexcept {
  const double versine = sine * sine / (1 + std::sqrt(std::max(0.0, 1 - sine * sine)));  // 1 - cosine
  return {direction_about(axis, 1 - u * versine, 2 * kPi * v), 2 * kPi * versine};
}

}  // namespace obscura
