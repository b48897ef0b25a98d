#include "photon/optics/material.h"

#include <algorithm>

namespace obscura {

MaterialOptics::MaterialOptics(const Material& material, int interval)
    : emissivity_(material.emissivity[static_cast<std::size_t>(interval)]),
      specular_(material.specular),
      roughness_(material.roughness),
      permeable_(material.permeable),
      factors_(material.angle_factor) {
  for (const double degrees : material.angle_deg) angles_.push_back(degrees * kPi / 180);
  if (factors_.empty()) {
    mean_reflectance_ = 1 - emissivity_;
    return;
  }
  // Over a cosine-weighted hemisphere the square of the sine is uniform: the midpoint rule.
  constexpr int kSteps = 4096;
  for (int i = 0; i < kSteps; ++i) {
    mean_reflectance_ += reflectance(std::sqrt(1 - (i + 0.5) / kSteps)) / kSteps;
  }
}

double MaterialOptics::emissivity(double cosine) const noexcept {
  if (factors_.empty()) return emissivity_;
  const double angle = std::acos(std::clamp(cosine, 0.0, 1.0));
  const auto above = std::upper_bound(angles_.begin(), angles_.end(), angle);
  const auto i = static_cast<std::size_t>(above - angles_.begin());
  double factor;
  if (i == 0) {
    factor = factors_.front();
  } else if (above == angles_.end()) {
    factor = factors_.back();
  } else {
    factor =
        factors_[i - 1] + (factors_[i] - factors_[i - 1]) * (angle - angles_[i - 1]) / (angles_[i] - angles_[i - 1]);
  }
  return std::clamp(emissivity_ * factor, 0.0, 1.0);
}

Vec3d mirror_direction(const Vec3d& arriving, const Vec3d& normal, double roughness, Stream& stream,
                       bool& exact) noexcept {
  const Vec3d mirrored = (arriving - 2 * arriving.dot(normal) * normal).normalized();
  exact = true;
  if (!(roughness > 0)) return mirrored;
  // Two normal numbers (Box and Muller, 1958) move the direction cosines in the surface's plane.
  const double r = roughness * std::sqrt(-2 * std::log(stream.uniform()));
  const double phi = 2 * kPi * stream.uniform();
  const auto [a, b] = orthonormal_basis(normal);
  const double x = mirrored.dot(a) + r * std::cos(phi);
  const double y = mirrored.dot(b) + r * std::sin(phi);
  const double height2 = 1 - x * x - y * y;
  if (!(height2 > 0)) return mirrored;
  exact = false;
  return (x * a + y * b + std::sqrt(height2) * normal).normalized();
}

double rough_mirror(const Vec3d& arriving, const Vec3d& normal, double roughness, const Vec3d& leaving) noexcept {
  if (!(roughness > 0) || !(leaving.dot(normal) > 0)) return 0;
  const Vec3d moved = leaving - (arriving - 2 * arriving.dot(normal) * normal);
  const double across2 = std::max(0.0, moved.length2() - moved.dot(normal) * moved.dot(normal));
  const double variance = roughness * roughness;
  return std::exp(-0.5 * across2 / variance) / (2 * kPi * variance);
}

}  // namespace obscura
