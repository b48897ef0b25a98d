// Bounds behind decisions: what leaving an effect out may change at most. Formulas:
// photon/METHODS.md, "Bounds and the builder's measure".
#pragma once

#include "photon/limits/media_summary.h"

namespace obscura {

/// Largest share of the light along a ray that its clouds can scatter into it, relative to the brightest light about:
/// q = albedo_max (1 - exp(-depth)), at most the scattering depth. The norm of one scattering (Davison, Neutron
/// Transport Theory, 1957, ch. 4: the Neumann series of the integral equation converges at least as fast as its
/// powers).
double scattering_norm(const IntervalLimits& limits) noexcept;

/// The same for one scattering or one reflection behind the clouds: the largest of albedo_max (1 - T) + R T over the
/// transmissions T that there can be.
double interaction_norm(const IntervalLimits& limits) noexcept;

/// Most by which the radiance of any ray can change where one effect is left out, W/m2/sr; infinite: no bound.
struct EffectBounds {
  double emission = 0;           ///< of clouds
  double single_scattering = 0;  ///< all that clouds scatter
  /// What a pass without a map leaves out: light after two interactions or more, and clouds' emission after one.
  double multiple_scattering = 0;
  double sun = 0;  ///< with moon
  double sky = 0;
  double specular = 0;    ///< mirrors taken for Lambertian
  double air_share = 0;   ///< most that air takes of a ray's radiance, as a share of it,
  double air_lost = 0;    ///< and most that it takes besides, of light before that scatters
  double air_gained = 0;  ///< most that air adds

  /// Of another interval of the band.
  EffectBounds& operator+=(const EffectBounds& other) noexcept;
};

/// @param reach_m largest distance in the scene
/// @param disc_in_view a camera ray may end on the sun's disc
EffectBounds effect_bounds(const IntervalLimits& limits, double reach_m, bool disc_in_view) noexcept;

}  // namespace obscura
