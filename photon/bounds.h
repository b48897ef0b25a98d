// Bounds behind decisions: how thick a World is, whether photons can finish in it, and what leaving an effect out may
// change at most. Formulas: METHODS.md, "Bounds".
#pragma once

#include "photon/media_summary.h"
#include "photon/world.h"

namespace obscura {

/// Largest optical depth of the World at one interval over seeded chords through its bounds: an
/// estimate from below that the thickest direction exceeds by little where clouds are not needles.
double largest_optical_depth(const World& world, int interval, int chords = 256);

/// The same for scattering alone, taken from the largest albedo: an estimate from above where it varies.
double largest_scattering_depth(const World& world, int interval, int chords = 256);

/// Mean cosine of the most forward phase function of what scatters; 0 where nothing does.
double largest_mean_cosine(const World& world, int interval);

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
  double multiple_scattering =
      0;           ///< what a pass without a map leaves out: two interactions or more, and one of clouds' emission
  double sun = 0;  ///< with moon
  double sky = 0;
  double specular = 0;   ///< mirrors taken for Lambertian
  double air_share = 0;  ///< of the radiance itself, and beside
  double air_lost = 0;
  double air_gained = 0;
};

/// @param reach_m largest distance in the scene
/// @param disc_in_view a camera ray may end on the sun's disc
EffectBounds effect_bounds(const IntervalLimits& limits, double reach_m, bool disc_in_view) noexcept;

/// Throws where a photon's history would practically never end: depth times (1 - g) above 1e4 while
/// less than one collision in `depth` absorbs.
/// @throws NumericalError that names the method and points to another one.
void refuse_endless_histories(const World& world, int interval, std::string_view method);

}  // namespace obscura
