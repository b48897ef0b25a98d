#include "scene/plan/plan.h"

#include <algorithm>

#include "scene/plan/plan_cost.h"
#include "scene/plan/plan_effects.h"

namespace obscura {

namespace {

bool serves(const MediaSummary& summary, const MethodType& type) {
  return std::ranges::find(summary.unfit, &type) == summary.unfit.end();
}

/// Final gather pays where light scatters again and again: one bounce hides the map's blur and noise. So it does
/// where surfaces reflect: small ones get few photons, and the map's discs reach over their edges. It is out of
/// the question where a bounce cannot find light or would count scatterings wrongly.
bool gathers(const Description& scene, const MediaSummary& summary) {
  if (scene.render.final_gather) return *scene.render.final_gather > 0;
  if (scene.sensor.scattering_depth || !serves(summary, kFinalGather)) return false;
  return std::any_of(summary.intervals.begin(), summary.intervals.end(), [](const IntervalLimits& limits) {
    return limits.reflectance_max > 0 || limits.scattering_seen > 1;
  });
}

/// The method of a word; of those that share it, `photon` for photons. None: the plan chooses.
const MethodType* named(const std::string& word, const MethodType& photon) {
  if (word == photon.word) return &photon;
  const auto found = std::ranges::find_if(methods(), [&word](const MethodType* type) { return type->word == word; });
  return found == methods().end() ? nullptr : *found;
}

/// Which method should bring the same error sooner, by rules of thumb: paths waste nothing where light scatters about
/// once, where it is absorbed soon, and where few pixels do not repay a map; photons are shared by all pixels. A target
/// error asks a pilot instead (pilot.h).
MethodChoice choose_method(const Description& scene, const MediaSummary& summary, const detail::Decisions& effects,
                           const detail::Costs& costs, const MethodType& photon) {
  MethodChoice choice;
  choice.photon_s = costs.photon_s;
  choice.path_s = costs.path_s;
  double depth = 0, order = 0;
  bool sunlit = false, reflects = false;
  for (const IntervalLimits& limits : summary.intervals) {
    depth = std::max(depth, limits.scattering_seen);
    order = std::max(order, limits.albedo_max);
    sunlit = sunlit || limits.sun > 0;
    reflects = reflects || limits.reflectance_max > 0;
  }
  sunlit = sunlit && effects.on("sun");
  const double pixels = static_cast<double>(scene.sensor.resolution[0]) * scene.sensor.resolution[1];
  const auto is = [&choice](const MethodType& cheaper, std::string reason) {
    choice.cheaper = &cheaper;
    choice.reason = std::move(reason);
    return choice;
  };
  const bool again = effects.on("multiple scattering");
  if (!again && !reflects) {
    const MethodType* wanted = named(scene.render.method, photon);
    return is(wanted ? *wanted : photon, "nothing is scattered twice: the method does not matter");
  }
  const bool photons = serves(summary, photon), paths = serves(summary, kPathTracer);
  if (!photons && !paths && serves(summary, kOrdinates))
    return is(kOrdinates, "neither photons nor paths can serve the scene");
  if (!paths) return is(photon, "paths cannot serve the scene");
  if (!photons) return is(kPathTracer, "photons cannot serve the scene");
  if (!again) return is(kPathTracer, "light only goes between surfaces");
  constexpr double kThin = 1, kFewPixels = 4096, kLowAlbedo = 0.6;
  if (depth < kThin) return is(kPathTracer, "the clouds are thin: light scatters about once");
  if (pixels < kFewPixels) return is(kPathTracer, "so few pixels do not repay a photon map");
  if (!sunlit && order < kLowAlbedo)
    return is(kPathTracer, "by their own and the sky's light, clouds that absorb most of it end paths soon");
  return is(photon, sunlit ? "sunlit thick clouds: all pixels share the photons"
                           : "light scatters many times: all pixels share the photons");
}

std::vector<FluxRectangle> rectangles_of(const Description& scene) {
  std::vector<FluxRectangle> rectangles;
  for (const FluxDescription& flux : scene.flux) {
    const auto [u, v] = rectangle_sides(flux.normal.normalized());
    rectangles.push_back({flux.center_m, flux.size_m[0] * u, flux.size_m[1] * v});
  }
  return rectangles;
}

/// Nothing where a threshold says that every pixel is to have all its rays.
std::optional<AdaptiveSettings> adaptive_of(const SensorDescription& sensor) {
  const AntialiasingDescription& wish = sensor.antialiasing;
  if (!wish.adaptive()) return std::nullopt;
  AdaptiveSettings settings;
  settings.geometry.polygons = wish.polygons;
  settings.geometry.polygons_strict = wish.polygons_strict;
  settings.geometry.materials = wish.materials;
  settings.geometry.normal = wish.normal_deg * kPi / 180;
  settings.geometry.depth = wish.depth;
  settings.geometry.temperature_K = wish.temperature_K;
  settings.geometry.emissivity = wish.emissivity;
  settings.shadow = wish.shadow;
  settings.transmission = wish.transmission;
  settings.radiance = wish.radiance;
  settings.error = wish.error;
  settings.specular_depth = sensor.specular_depth;
  return settings;
}

}  // namespace

Method method_of(const Description& scene, const MethodType& type) {
  Method method;
  method.type = &type;
  method.photons = scene.render.photons;
  method.photon_power_min = scene.render.photon_power_min;
  method.directions = scene.render.directions;
  method.nearest = scene.render.nearest;
  method.kernel = scene.render.kernel;
  method.samples = scene.render.samples;
  method.specular_depth = scene.sensor.specular_depth;
  method.scattering_depth = scene.sensor.scattering_depth;
  return method;
}

Plan make_plan(const Description& scene, const MediaSummary& summary, double budget) {
  Plan plan;
  detail::Decisions effects = detail::decide(scene, summary, budget);
  const bool single = effects.on("single scattering"), multiple = effects.on("multiple scattering");
  const auto any = [&summary](double IntervalLimits::*limit) {
    return std::ranges::any_of(summary.intervals, [limit](const IntervalLimits& limits) { return limits.*limit > 0; });
  };
  const bool reflects = effects.on("surfaces") && any(&IntervalLimits::reflectance_max);
  // Surfaces light one another by the map too, unless all that it holds was left out by bound or wish.
  const bool scatters = any(&IntervalLimits::scattering_depth);
  const auto dropped = [&](const PlanRow& row) {
    return row.effect == "multiple scattering" && !row.on && (row.bound || scene.render.effects.count(row.effect));
  };
  plan.estimator.again = multiple || (reflects && (!scatters || std::ranges::none_of(effects.rows, dropped)));
  plan.estimator.scattering = single || !scatters;
  plan.estimator.footprint_tolerance = scene.render.octree_tolerance;
  plan.estimator.seed = scene.render.seed;
  plan.estimator.rectangles = rectangles_of(scene);

  const MethodType& photon = gathers(scene, summary) ? kFinalGather : kPhotonMap;
  const MethodType* wanted = named(scene.render.method, photon);
  plan.photon = &photon;
  detail::CostSettings cost_settings{&photon == &kFinalGather, single, multiple};
  detail::Costs costs = detail::predict_costs(scene, summary, cost_settings);
  plan.choice = choose_method(scene, summary, effects, costs, photon);
  plan.method = method_of(scene, wanted ? *wanted : *plan.choice.cheaper);
  if (plan.method.type == &kPathTracer) {
    cost_settings.path = true;
    costs = detail::predict_costs(scene, summary, cost_settings);
  }
  for (std::size_t e = 0; e < effects.rows.size(); ++e) {
    PlanRow& row = effects.rows[e];
    if ((row.on || row.bound) && costs.effects[e] > 0) row.cost_s = costs.effects[e];
  }
  plan.effects = std::move(effects.rows);
  plan.cuts = std::move(effects.cuts);
  plan.budget = effects.budget;
  plan.left_out = std::move(effects.left_out);
  plan.warnings = std::move(effects.warnings);
  plan.camera = scene.sensor;
  plan.sampling.max_oversampling = scene.sensor.max_oversampling;
  plan.sampling.adaptive = adaptive_of(scene.sensor);
  plan.sampling.seed = scene.render.seed;
  return plan;
}

}  // namespace obscura
