#include "scene/plan/plan.h"

#include <algorithm>

#include "scene/plan/plan_cost.h"
#include "scene/plan/plan_effects.h"

namespace obscura {

CameraSettings camera_of(const SensorDescription& sensor) {
  CameraSettings camera;
  camera.position_m = sensor.position_m;
  camera.look_at_m = sensor.look_at_m;
  camera.up = sensor.up;
  camera.projection = sensor.projection;
  camera.fov_deg = sensor.fov_deg;
  camera.width_m = sensor.width_m;
  camera.resolution = sensor.resolution;
  return camera;
}

namespace {

/// Final gather pays where light scatters again and again: one bounce hides the map's blur and noise. So it does
/// where surfaces reflect: small ones get few photons, and the map's discs reach over their edges. It is out of
/// the question where a bounce cannot find light (beams without width) or would count scatterings wrongly.
bool gathers(const Description& scene, const MediaSummary& summary) {
  if (scene.render.final_gather) return *scene.render.final_gather > 0;
  if (scene.sensor.scattering_depth) return false;
  for (const BeamDescription& beam : scene.beams) {
    if (!(beam.radius_m > 0)) return false;
  }
  return std::any_of(summary.intervals.begin(), summary.intervals.end(), [](const IntervalLimits& limits) {
    return limits.reflectance_max > 0 || limits.scattering_seen > 1;
  });
}

/// Which method should bring the same error sooner, by rules of thumb: paths waste nothing where light scatters about
/// once, where it is absorbed soon, and where few pixels do not repay a map; photons are shared by all pixels. A target
/// error asks a pilot instead (accuracy.h).
MethodChoice choose_method(const Description& scene, const MediaSummary& summary, const detail::Decisions& effects,
                           const detail::Costs& costs) {
  MethodChoice choice;
  choice.photon_s = costs.photon_s;
  choice.path_s = costs.path_s;
  double depth = 0, order = 0;
  bool sunlit = false, reflects = false, beams = false;
  for (const IntervalLimits& limits : summary.intervals) {
    depth = std::max(depth, limits.scattering_seen);
    order = std::max(order, limits.albedo_max);
    sunlit = sunlit || limits.sun > 0;
    reflects = reflects || limits.reflectance_max > 0;
    beams = beams || limits.beams;
  }
  sunlit = sunlit && effects.on("sun");
  const double pixels = static_cast<double>(scene.sensor.resolution[0]) * scene.sensor.resolution[1];
  const auto is = [&choice](MethodKind cheaper, std::string reason) {
    choice.cheaper = cheaper;
    choice.reason = std::move(reason);
    return choice;
  };
  const bool again = effects.on("multiple scattering");
  if (!again && !reflects) return is(scene.render.method, "nothing is scattered twice: the method does not matter");
  if (std::any_of(scene.beams.begin(), scene.beams.end(),
                  [](const BeamDescription& beam) { return !(beam.radius_m > 0); })) {
    return is(MethodKind::photon, "no path meets a beam without width");
  }
  if (summary.periodic && (!scene.objects.empty() || !scene.sources.empty() || !scene.particles.empty() || beams)) {
    return is(MethodKind::path, "photons do not serve finite things in a periodic scene");
  }
  if (!again) return is(MethodKind::path, "light only goes between surfaces");
  constexpr double kThin = 1, kFewPixels = 4096, kLowAlbedo = 0.6;
  if (depth < kThin) return is(MethodKind::path, "the clouds are thin: light scatters about once");
  if (pixels < kFewPixels) return is(MethodKind::path, "so few pixels do not repay a photon map");
  if (!sunlit && order < kLowAlbedo)
    return is(MethodKind::path, "by their own and the sky's light, clouds that absorb most of it end paths soon");
  return is(MethodKind::photon, sunlit ? "sunlit thick clouds: all pixels share the photons"
                                       : "light scatters many times: all pixels share the photons");
}

/// The rays of a pixel share its samples. What is more than a pass can hold goes into further passes: of paths
/// only, since passes that ask the same map are not independent.
void share_samples(const Description& scene, Plan& plan) {
  const int samples = scene.render.samples;
  // Where all pixels have as many rays, none is without a sample.
  if (!plan.sampling.adaptive) plan.sampling.max_oversampling = std::min(plan.sampling.max_oversampling, samples);
  plan.sampling.samples = samples;
  // For whoever asks along single rays.
  plan.radiance.points =
      std::clamp((samples + plan.sampling.max_oversampling - 1) / plan.sampling.max_oversampling, 1, kMostPoints);
  if (scene.render.method == MethodKind::path) {
    plan.passes = (samples + kMostPoints - 1) / kMostPoints;
    plan.sampling.samples = (samples + plan.passes - 1) / plan.passes;
  }
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

Plan make_plan(const Description& scene, const MediaSummary& summary, double budget) {
  Plan plan;
  detail::Decisions effects = detail::decide(scene, summary, budget);
  const bool single = effects.on("single scattering"), multiple = effects.on("multiple scattering");
  const bool path = scene.render.method == MethodKind::path;
  const bool reflects =
      effects.on("surfaces") && std::any_of(summary.intervals.begin(), summary.intervals.end(),
                                            [](const IntervalLimits& limits) { return limits.reflectance_max > 0; });
  // Surfaces light one another by the map too, unless all that it holds was left out by bound or wish.
  const bool scatters = std::any_of(summary.intervals.begin(), summary.intervals.end(),
                                    [](const IntervalLimits& limits) { return limits.scattering_depth > 0; });
  const auto dropped = [&](const PlanRow& row) {
    return row.effect == "multiple scattering" && !row.on && (row.bound || scene.render.effects.count(row.effect));
  };
  const bool again =
      multiple || (reflects && (!scatters || std::none_of(effects.rows.begin(), effects.rows.end(), dropped)));
  plan.maps = !path && (again || !scene.flux.empty());
  const bool gather = gathers(scene, summary);
  const detail::Costs costs = detail::predict_costs(scene, summary, {gather, single, multiple});
  for (std::size_t e = 0; e < effects.rows.size(); ++e) {
    PlanRow& row = effects.rows[e];
    if ((row.on || row.bound) && costs.effects[e] > 0) row.cost_s = costs.effects[e];
  }
  plan.method = choose_method(scene, summary, effects, costs);
  plan.effects = std::move(effects.rows);
  plan.cuts = std::move(effects.cuts);
  plan.budget = effects.budget;
  plan.warnings = std::move(effects.warnings);
  plan.camera = camera_of(scene.sensor);
  plan.sampling.max_oversampling = scene.sensor.max_oversampling;
  plan.sampling.adaptive = adaptive_of(scene.sensor);
  plan.sampling.seed = scene.render.seed;

  plan.trace.photons = scene.render.photons;
  plan.trace.photon_power_min = scene.render.photon_power_min;
  plan.trace.directions = scene.render.directions;
  plan.trace.scattering_depth = scene.sensor.scattering_depth;
  plan.trace.seed = scene.render.seed;

  plan.radiance.gather.nearest = scene.render.nearest;
  plan.radiance.gather.kernel = scene.render.kernel;
  plan.radiance.specular_depth = scene.sensor.specular_depth;
  plan.radiance.scattering_depth = scene.sensor.scattering_depth;
  plan.radiance.seed = scene.render.seed;
  plan.radiance.footprint_tolerance = scene.render.octree_tolerance;
  if (!single && scatters) plan.trace.scattering_depth = plan.radiance.scattering_depth = 0;
  if (path) {
    // Where nothing goes on after its first scattering, the pass along the camera's rays is all there is.
    plan.radiance.gather_bounces = again ? kAllBounces : 0;
    share_samples(scene, plan);
  } else if (again && gather) {
    plan.radiance.gather_bounces = 1;
    // Many questions, none of which shows by itself: the least points for each denominator do.
    plan.radiance.gather.rounds = 2;
    share_samples(scene, plan);
  }
  return plan;
}

}  // namespace obscura
