// Materials of surfaces by Kirchhoff's law: what is not emitted is reflected, in part like a mirror, in
// part like chalk. Formulas: photon/METHODS.md, "Surfaces".
#pragma once

#include <vector>

#include "octree/base/math.h"
#include "octree/base/random.h"

namespace obscura {

/// What a surface is made of.
struct Material {
  std::vector<double> emissivity;  ///< one value per interval of the World, [0, 1]
  double specular = 0;             ///< share of the reflectance that is mirror-like, [0, 1]
  /// Standard deviation of a mirror's direction cosines, per axis; 0: a perfect mirror.
  double roughness = 0;
  /// Share of the light that passes straight through (a net); the rest meets the surface. [0, 1]
  double permeable = 0;
  /// The emissivity's factor at angles from the normal, linear in between, 0 .. 90 degrees, increasing.
  /// Empty: the same at all angles. The product is cut at 1.
  std::vector<double> angle_deg, angle_factor;
};

/// A material at one interval. Cosines are of the angle to the normal, (0, 1].
class MaterialOptics {
 public:
  MaterialOptics(const Material& material, int interval);

  double emissivity(double cosine) const noexcept;
  double reflectance(double cosine) const noexcept { return 1 - emissivity(cosine); }
  /// Emitted flux over a black body's.
  double hemispherical_emissivity() const noexcept { return 1 - mean_reflectance_; }
  bool reflects() const noexcept { return mean_reflectance_ > 0; }
  double specular() const noexcept { return specular_; }
  double roughness() const noexcept { return roughness_; }
  double permeable() const noexcept { return permeable_; }

  /// BRDF of the Lambertian part as if it were the whole reflectance, 1/sr: reciprocal, and reflects
  /// reflectance(cosine) of what comes at that angle (Shirley et al., Pacific Graphics 1997).
  double diffuse(double cosine_in, double cosine_out) const noexcept {
    return reflectance(cosine_in) * reflectance(cosine_out) / (kPi * mean_reflectance_);
  }

 private:
  double emissivity_;
  double specular_, roughness_, permeable_;
  double mean_reflectance_ = 0;           // over a cosine-weighted hemisphere
  std::vector<double> angles_, factors_;  // radians
};

/// Where a mirror sends what comes from `arriving` (the way it travels), normal towards it. A rough
/// mirror scatters alike in direction cosines (Harvey and Shack's shift invariance); what would leave the
/// hemisphere stays in the mirror's own direction, so that the kernel is symmetric and loses nothing.
/// @param exact set to whether it is the mirror's own direction
Vec3d mirror_direction(const Vec3d& arriving, const Vec3d& normal, double roughness, Stream& stream,
                       bool& exact) noexcept;

/// Density of that scattering per projected solid angle, 1/sr: 0 where roughness is 0.
double rough_mirror(const Vec3d& arriving, const Vec3d& normal, double roughness, const Vec3d& leaving) noexcept;

}  // namespace obscura
