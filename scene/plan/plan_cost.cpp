#include "scene/plan/plan_cost.h"

#include <algorithm>

#include "photon/limits/bounds.h"

namespace obscura::detail {
namespace {

// Seconds on one core, measured on a 2020s machine of 3 GHz (figures: scene/MEASURED.md, "The plan's work model").
constexpr double kRay = 1.0e-6;        // a camera ray, with its share of the film
constexpr double kMeet = 0.8e-6;       // a surface found or missed
constexpr double kStep = 4e-9;         // a segment of the batched walk
constexpr double kWalk = 25e-9;        // a segment of the walk in double, where emission is followed
constexpr double kPoint = 1e-6;        // a scattering point placed, or a path's next one
constexpr double kShadow = 1e-6;       // a shadow ray beside its segments
constexpr double kCollision = 0.6e-6;  // of a photon, stored
constexpr double kBuild = 0.5e-6;      // a stored photon's part in the tree
constexpr double kLookup = 0.05e-6;    // a photon found by an estimate
constexpr double kSpotRays = 0.25;     // of the rays that a pixel may have, adaptive pixels get this share

/// Collisions or reflections of a photon or a path: a geometric series of chances to go on.
double interactions(const IntervalLimits& limits) {
  // The mean chord of a convex cloud is about half the longest one; forward peaks hardly turn light round.
  const double depth = 0.5 * limits.scattering_seen * (1 - limits.mean_cosine);
  const double met = std::max(1 - std::exp(-0.5 * limits.scattering_seen), limits.lost);
  const double escapes = 1 / (1 + 0.75 * depth);
  const double on = limits.albedo_max * (1 - escapes);
  const double cloudy = met * (1 + on / std::max(1 - on, 1e-3)) / std::max(1 - limits.mean_cosine, 0.1);
  return cloudy + limits.reflectance_max / std::max(1 - limits.reflectance_max, 0.05);
}

}  // namespace

Costs predict_costs(const Description& scene, const MediaSummary& summary, const CostSettings& settings) {
  Costs costs;
  const SensorDescription& sensor = scene.sensor;
  const RenderDescription& render = scene.render;
  const double pixels = static_cast<double>(sensor.resolution[0]) * sensor.resolution[1];
  const double most = sensor.max_oversampling;
  const double rays = pixels * (sensor.antialiasing.adaptive() ? 1 + kSpotRays * (most - 1) : most);
  const bool path = settings.path;
  const auto cost_of = [&costs](std::size_t effect) -> double& { return costs.effects[effect]; };
  double common = 0, photon = 0, paths = 0;

  for (const IntervalLimits& limits : summary.intervals) {
    const double step = kStep * limits.segments;
    const bool scatters = limits.scattering_depth > 0;
    const bool reflects = limits.reflectance_max > 0;
    // Light sources that a point asks by a shadow ray each.
    const double suns = limits.sun > 0, ambient = limits.sky > 0 || limits.air > 0;
    const double faces = limits.surface_max > 0, spheres = limits.sphere_max > 0;
    const double shadow = kShadow + step + (std::isfinite(summary.reach_m) && !scene.objects.empty() ? kMeet : 0.0);

    const double absorption = rays * (kRay + step);
    const double emission = limits.emits ? rays * kWalk * limits.segments : 0.0;
    const double masking = scene.objects.empty() && !spheres ? 0.0 : rays * kMeet;
    const double points = scatters && settings.single ? rays * std::max(limits.lost, 0.0) * 4 : 0.0;
    const double reflecting = reflects ? rays * limits.surfaces_hit : 0.0;
    const double lit = points + reflecting;
    const double single = points * kPoint + points * shadow * (suns + ambient + faces + spheres);
    const double surfaces = reflecting * (kPoint + shadow * (suns + ambient + faces + spheres));
    const double air = limits.air_extinction > 0 ? rays * kWalk * std::max(limits.segments, 4.0) : 0.0;
    const double mirrors = limits.mirror_max > 0 ? reflecting * (kRay + kMeet + step) : 0.0;

    // Photons fly, collide and are sorted; the pass asks the map. Paths do all of it from the sensor.
    const double orders = interactions(limits);
    const double share =
        1.0 / static_cast<double>(summary.intervals.size()) * static_cast<double>(summary.bands.size());
    const double photons = static_cast<double>(render.photons) * share;
    const double traced = photons * (0.5e-6 + step + orders * (kCollision + 0.2 * step + kBuild));
    const double samples = pixels * render.samples *
                           std::max(limits.lost * (scatters && settings.single), reflects ? limits.surfaces_hit : 0.0);
    const double bounce = kPoint + step + kMeet + shadow * (suns + faces + spheres);
    const double asked = settings.gathers ? samples * (2 * bounce + kLookup * render.nearest)
                                          : (points / 4 + reflecting) * kLookup * render.nearest;
    const bool maps = (scatters && settings.multiple) || reflects;
    const double by_photons = maps ? traced + asked : 0.0;
    const double by_paths = maps ? samples * bounce * (1 + std::min(orders, 200.0)) : 0.0;

    common += absorption + emission + masking + air + mirrors;
    photon += by_photons + (settings.gathers && maps ? 0.0 : single + surfaces);
    paths += by_paths + (maps ? 0.0 : single + surfaces);
    const double again = path ? by_paths : by_photons;
    cost_of(0) += absorption;
    cost_of(1) += emission;
    cost_of(2) += single;
    cost_of(3) += scatters ? again : 0.0;
    cost_of(4) += surfaces + (scatters ? 0.0 : again);
    cost_of(5) += mirrors;
    cost_of(6) += suns * lit * shadow;
    cost_of(7) += (limits.sky > 0) * lit * shadow;
    cost_of(8) += air;
    cost_of(11) += masking;
  }
  // Of what several intervals cost, one is needed anyway.
  const double intervals = static_cast<double>(summary.intervals.size()),
               bands = static_cast<double>(summary.bands.size());
  cost_of(10) = intervals > bands ? (common + (path ? paths : photon)) * (1 - bands / intervals) : 0.0;
  costs.photon_s = common + photon;
  costs.path_s = common + paths;
  return costs;
}

}  // namespace obscura::detail
