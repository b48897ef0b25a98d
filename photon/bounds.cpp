#include "photon/bounds.h"

#include <algorithm>
#include <string>

#include "octree/base/error.h"
#include "octree/base/random.h"
#include "photon/purpose.h"
#include "photon/sampling.h"
#include "photon/transfer.h"

namespace obscura {
namespace {

struct LargestScattering {
  double albedo = 0;
  double mean_cosine = -1;
};

LargestScattering largest_scattering(const World& world, int interval) {
  LargestScattering largest;
  for (int c = 0; c < world.cloud_count(); ++c) {
    for (const CloudOptics::Part& part : world.optics(c, interval).parts()) {
      if (!(part.scattering > 0)) continue;
      largest.albedo = std::max(largest.albedo, part.scattering / part.extinction);
      largest.mean_cosine = std::max(largest.mean_cosine, part.phase->mean_cosine());
    }
  }
  return largest;
}

}  // namespace

double largest_optical_depth(const World& world, int interval, int chords) {
  if (world.bounds().isEmpty()) return 0;
  const double radius = 0.5 * world.bounds().size().length();
  std::vector<Ray> rays;
  Stream stream(0, 0, purpose_id(Purpose::chord, interval));
  for (int i = 0; i < chords; ++i) {
    // Through a random point of the bounds; the first three along the axes through the middle.
    Vec3d through = world.bounds().center();
    Vec3d direction(i == 0, i == 1, i == 2);
    if (i >= 3) {
      for (int axis = 0; axis < 3; ++axis) through[axis] += (stream.uniform() - 0.5) * world.bounds().size()[axis];
      const double u = stream.uniform();
      direction = uniform_direction(u, stream.uniform());
    }
    rays.push_back({through - 2 * radius * direction, direction, 0, 4 * radius});
  }
  std::vector<double> depths(rays.size());
  world.optical_depths(interval, rays, depths);
  return *std::max_element(depths.begin(), depths.end());
}

double largest_scattering_depth(const World& world, int interval, int chords) {
  const double albedo = largest_scattering(world, interval).albedo;
  return albedo > 0 ? albedo * largest_optical_depth(world, interval, chords) : 0.0;
}

double largest_mean_cosine(const World& world, int interval) {
  return std::max(0.0, largest_scattering(world, interval).mean_cosine);
}

namespace {

/// 0 where either is: nothing of something without a bound is nothing.
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

void refuse_endless_histories(const World& world, int interval, std::string_view method) {
  const auto [albedo, forward] = largest_scattering(world, interval);
  if (albedo == 0) return;
  const double depth = largest_optical_depth(world, interval);
  if (depth * (1 - forward) > 1e4 && 1 - albedo < 1 / depth) {
    throw NumericalError("method \"" + std::string(method) + "\"",
                         "an optical depth of " + std::to_string(depth) + " with an albedo of " +
                             std::to_string(albedo) + " keeps light inside for longer than it can be followed",
                         "lower the extinction or the albedo, or use discrete ordinates");
  }
}

}  // namespace obscura
