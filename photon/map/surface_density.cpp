#include "photon/map/surface_density.h"

#include <algorithm>

namespace obscura::detail {
namespace {

// A photon counts where the surface is turned by less than 45 degrees and is no farther from the tangent
// plane than this share of the radius.
constexpr double kAlike = 0.7;
constexpr double kThin = 0.3;
// Less cover than this cannot be told from none by the points that are asked.
constexpr double kLeastCover = 0.02;

/// Share of the kernel within u = (distance / radius)^2.
double mass_within(Kernel kernel, double u) noexcept {
  switch (kernel) {
    case Kernel::constant:
      return u;
    case Kernel::epanechnikov:
      return u * (2 - u);
    case Kernel::cone:
      return u * (3 - 2 * std::sqrt(u));
    case Kernel::gaussian:
      return std::expm1(-kGaussianExponent * u) / std::expm1(-kGaussianExponent);
  }
  return 0;
}

using Points = std::array<DiscPoint, kRoundPoints>;

Points make_points(Kernel kernel) noexcept {
  // Rings of equal mass, a golden angle apart.
  constexpr double kGoldenAngle = 2.399963229728653;
  Points points;
  for (int i = 0; i < kRoundPoints; ++i) {
    const double mass = (i + 0.5) / kRoundPoints;
    double low = 0, high = 1;
    for (int step = 0; step < 50; ++step) {
      const double middle = 0.5 * (low + high);
      (mass_within(kernel, middle) < mass ? low : high) = middle;
    }
    const double rho = std::sqrt(0.5 * (low + high));
    points[static_cast<std::size_t>(i)] = {rho * std::cos(kGoldenAngle * i), rho * std::sin(kGoldenAngle * i)};
  }
  return points;
}

}  // namespace

double disc_kernel(Kernel kernel, double u) noexcept {
  const double shape = u < 1 ? kernel_shape(kernel, u) : 0.0;
  switch (kernel) {
    case Kernel::constant:
      return shape / kPi;
    case Kernel::epanechnikov:
      return 2 * shape / kPi;
    case Kernel::cone:
      return 3 * shape / kPi;
    case Kernel::gaussian:
      return shape * -2 / (kPi * std::expm1(-kGaussianExponent));
  }
  return 0;
}

std::span<const DiscPoint, kRoundPoints> disc_points(Kernel kernel) noexcept {
  static const std::array<Points, 4> tables = {make_points(Kernel::constant), make_points(Kernel::epanechnikov),
                                               make_points(Kernel::cone), make_points(Kernel::gaussian)};
  return tables[static_cast<std::size_t>(kernel)];
}

bool same_side(const SurfacePoint& at, double radius, const Vec3d& place, const Vec3d& normal) noexcept {
  return normal.dot(at.normal) >= kAlike && std::abs((place - at.position).dot(at.normal)) <= kThin * radius;
}

bool in_sight(const Surfaces& surfaces, const SurfacePoint& at, const Vec3d& place, const Vec3d& normal) noexcept {
  // A little above the surface, which hides no part of itself: what is round rises above a chord of length d
  // between normals an angle a apart by a d / 8. Photons know their normal to a degree.
  const double turned = std::sqrt(std::max(0.0, 1 - normal.dot(at.normal)));  // a / sqrt 2
  const double lift = (3e-3 + 0.2 * turned) * (place - at.position).length() + surfaces.clearance();
  const Vec3d from = at.position + lift * at.normal;
  const Vec3d way = place + lift * normal - from;
  const double distance = way.length();
  return !(distance > 0) || !surfaces.occluded({from, way / distance, 0, distance});
}

DiscCover disc_cover(SpectralWorld world, const SurfacePoint& at, double radius, Kernel kernel, bool flat,
                     const Vec3d& key) noexcept {
  const Rotation turn = rotation_at(key, 0);
  const double angle = std::atan2(turn.x.y, turn.x.x);
  const auto [a, b] = orthonormal_basis(at.normal);
  const Vec3d side_u = radius * (std::cos(angle) * a + std::sin(angle) * b);
  const Vec3d side_v = at.normal.cross(side_u);
  DiscCover cover;
  double inner_weight = 0;
  for (const DiscPoint& point : disc_points(kernel)) {
    // From above the tangent plane to the first surface below, which has to be like the point's own.
    const double u0 = point.x * point.x + point.y * point.y;
    const double density = disc_kernel(kernel, u0);
    const double inner0 = 2 * u0 < 1 ? 2 * disc_kernel(kernel, 2 * u0) / density : 0.0;
    inner_weight += inner0;
    const Vec3d above = at.position + point.x * side_u + point.y * side_v + kThin * radius * at.normal;
    const Ray ray{above, -at.normal, 0, 2 * kThin * radius};
    const SurfaceHit hit = world->surfaces().intersect(ray);
    if (!hit.exists()) continue;
    const SurfacePoint there = world.surface_at(ray, hit);
    if (!there.reflects() || !same_side(at, radius, there.position, there.normal) ||
        (!flat && !in_sight(world->surfaces(), at, there.position, there.normal))) {
      continue;
    }
    const double u = (there.position - at.position).length2() / (radius * radius);
    const double stretch = 1 / (there.cosine * density);
    cover.whole += stretch * disc_kernel(kernel, u) / kRoundPoints;
    if (2 * u < 1) cover.inner += 2 * stretch * disc_kernel(kernel, 2 * u);
  }
  cover.whole = std::max(cover.whole, kLeastCover);
  cover.inner = std::max(cover.inner / inner_weight, kLeastCover);
  return cover;
}

}  // namespace obscura::detail
