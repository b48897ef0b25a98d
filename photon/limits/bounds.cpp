#include "photon/limits/bounds.h"

#include <algorithm>

#include "photon/optics/transfer.h"

namespace obscura {
namespace {

/// The product; 0 where either factor is 0, even if the other is infinite (has no bound).
double times(double a, double b) noexcept { return a == 0 || b == 0 ? 0.0 : a * b; }

/// a / (1 - q): the sum of a geometric series; infinite where that does not converge.
double series(double a, double q) noexcept {
  if (a == 0) return 0;
  return q < 1 ? a / (1 - q) : kInfinity;
}

}  // namespace

double scattering_norm(const IntervalLimits& limits) noexcept {
  return std::min(limits.albedo_max * one_minus_exp(limits.depth), limits.scattering_depth);
}

double interaction_norm(const IntervalLimits& limits) noexcept {
  return std::max(limits.reflectance_max, scattering_norm(limits) + limits.reflectance_max * std::exp(-limits.depth));
}

EffectBounds& EffectBounds::operator+=(const EffectBounds& other) noexcept {
  emission += other.emission;
  single_scattering += other.single_scattering;
  multiple_scattering += other.multiple_scattering;
  sun += other.sun;
  sky += other.sky;
  specular += other.specular;
  air_share = std::max(air_share, other.air_share);
  air_lost += other.air_lost;
  air_gained += other.air_gained;
  return *this;
}

EffectBounds effect_bounds(const IntervalLimits& limits, double reach_m, bool disc_in_view) noexcept {
  const double q = scattering_norm(limits);
  const double norm = interaction_norm(limits);

  // Maximum principle: light of sources that are nowhere brighter than this is nowhere brighter itself.
  const double given = std::max({limits.sky, limits.surface_max, limits.sphere_max});
  const double direct = std::max(given, limits.air);
  const double emitted = times(limits.source_max, one_minus_exp(limits.absorption_depth));
  const double from_clouds =
      limits.source_max < kInfinity ? std::min(limits.source_max, series(emitted, norm)) : kInfinity;
  const double diffuse = std::max(direct, limits.source_max);

  // The sun's light after its first scattering or reflection, and all that follows from it.
  const double scattered = times(times(q, limits.phase_max), limits.sun);
  const double first =
      std::max(limits.brdf_max * limits.sun, scattered + std::exp(-limits.depth) * limits.brdf_max * limits.sun) +
      times(limits.mirror_max, limits.disc);
  const double sunlight = series(first, norm);
  const double beams = limits.beams ? kInfinity : 0.0;

  EffectBounds bounds;
  bounds.emission = from_clouds;
  bounds.sky = limits.sky;
  bounds.sun = sunlight + (disc_in_view ? limits.disc : 0.0);
  bounds.single_scattering = series(times(q, diffuse + sunlight + beams) + scattered, limits.reflectance_max);
  bounds.multiple_scattering = times(norm * norm, direct) + times(norm, from_clouds + sunlight + beams);
  bounds.specular =
      series(times(limits.mirror_max, diffuse + sunlight + limits.disc + limits.brdf_max * limits.sun + beams), norm);
  if (limits.air_extinction > 0) {
    const double share = one_minus_exp(limits.air_extinction * reach_m);
    bounds.air_share = share;
    bounds.air_lost = share * series(times(norm, std::max(given, limits.source_max) + sunlight + beams), norm);
    bounds.air_gained = std::min(limits.air, series(share * limits.air, norm));
  }
  return bounds;
}

}  // namespace obscura
