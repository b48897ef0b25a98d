// Points, directions and choices from uniform numbers.
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

/// Chooses one of `count` things in proportion to their weights, whose cumulative sums are given. Afterwards u is a
/// uniform number again, to be used within the chosen thing.
template <class Sums>
std::size_t choose(const Sums& sums, std::size_t count, double& u) noexcept {
  const double target = u * static_cast<double>(sums[count - 1]);
  const auto first = sums.begin();
  std::size_t i = static_cast<std::size_t>(
      std::upper_bound(first, first + static_cast<std::ptrdiff_t>(count), target,
                       [](double value, double sum) { return value < static_cast<double>(sum); }) -
      first);
  i = std::min(i, count - 1);
  const double below = i ? static_cast<double>(sums[i - 1]) : 0.0;
  const double width = static_cast<double>(sums[i]) - below;
  u = width > 0 ? std::clamp((target - below) / width, 0.0, 1.0 - 0x1p-53) : 0.5;
  return i;
}

}  // namespace obscura
