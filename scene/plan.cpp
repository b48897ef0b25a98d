#include "scene/plan.h"

#include <algorithm>

#include "photon/bounds.h"
#include "scene/per_interval.h"

namespace obscura {
namespace {

bool positive(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double value) { return value > 0; });
}

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

/// Whether any surface has a share of reflectance that is mirror-like, in any interval.
bool has_mirror(const Description& scene, const std::vector<Band>& bands) {
  const auto mirrors = [&](const std::string& name) {
    if (name.empty()) return false;
    const MaterialDescription& material = scene.materials.at(name);
    if (!(material.specular > 0)) return false;
    if (!material.angle_factor.empty()) return true;
    const std::vector<double> emissivity = detail::optical(bands, material.emissivity);
    return *std::min_element(emissivity.begin(), emissivity.end()) < 1;
  };
  return std::any_of(scene.objects.begin(), scene.objects.end(), [&](const ObjectDescription& object) {
    return mirrors(object.material) || std::any_of(object.groups.begin(), object.groups.end(), [&](const auto& group) {
             return group.second.material && mirrors(*group.second.material);
           });
  });
}

std::vector<PlanRow> effects_of(const Description& scene, const World& world) {
  bool absorbs = false, emits = false, scatters = false, sky = false;
  for (int i = 0; i < world.interval_count(); ++i) {
    for (int c = 0; c < world.cloud_count(); ++c) {
      for (const CloudOptics::Part& part : world.optics(c, i).parts()) {
        absorbs = absorbs || part.extinction > part.scattering;
      }
    }
    emits = emits || world.emits(i);
    scatters = scatters || world.scatters(i);
    sky = sky || world.sky(i) > 0;
  }
  const int depth = scene.sensor.scattering_depth.value_or(1 << 30);
  const bool sun = scene.sun && positive(detail::integrated(world.bands(), scene.sun->irradiance));
  const bool moon = scene.moon && positive(detail::integrated(world.bands(), scene.moon->irradiance));
  const bool surfaces = !scene.objects.empty();
  const bool mirrors = surfaces && has_mirror(scene, world.bands());
  const bool spheres = !world.spheres().empty();
  bool sampled = false;
  for (const Band& band : world.bands()) sampled = sampled || band.interval_count() > 1;

  std::vector<PlanRow> rows;
  const auto row = [&rows](const char* effect, bool on, const char* present, const char* absent) {
    rows.push_back({effect, on, on ? present : absent, std::nullopt});
  };
  row("absorption", absorbs, "a cloud absorbs", "no cloud absorbs");
  row("emission", emits, "a cloud emits", "no cloud has a temperature, source or emission");
  row("single scattering", scatters && depth >= 1, "a cloud scatters",
      scatters ? "scattering_depth is 0" : "no cloud scatters");
  row("multiple scattering", scatters && depth >= 1, "a cloud scatters: the photon map holds what has scattered before",
      scatters ? "scattering_depth is 0" : "no cloud scatters");
  row("surfaces", surfaces, "the scene has objects", "the scene has no objects");
  row("specular", mirrors && scene.sensor.specular_depth > 0, "a material is mirror-like",
      !surfaces ? "the scene has no objects" : mirrors ? "specular_depth is 0" : "no object's material is mirror-like");
  row("sun", sun || moon, sun && moon ? "the scene has a sun and a moon" : sun ? "the scene has a sun" : "the scene has a moon",
      "the scene has no sun and no moon");
  row("sky", sky, "the sky is bright", "the sky is dark");
  row("atmosphere", world.atmosphere().has_value(), "the air absorbs",
      scene.atmosphere ? "the air's extinction is 0" : "the scene has no atmosphere");
  row("time", false, "", "nothing in the scene changes with time");
  row("spectral sampling", sampled, "a band has several intervals", "every band is one interval");
  row("masking", surfaces || spheres,
      surfaces && spheres ? "objects and hot spheres hide what is behind them"
      : surfaces          ? "objects hide what is behind them"
                          : "hot spheres hide what is behind them",
      "nothing opaque is in the scene");
  return rows;
}

}  // namespace

namespace {

/// Final gather pays where light scatters again and again: one bounce hides the map's blur and noise. So it does
/// where surfaces reflect: small ones get few photons, and the map's discs reach over their edges. It is out of
/// the question where a bounce cannot find light (beams without width) or would count scatterings wrongly.
bool gathers(const Description& scene, const World& world) {
  if (scene.render.final_gather) return *scene.render.final_gather > 0;
  if (scene.sensor.scattering_depth) return false;
  for (const BeamDescription& beam : scene.beams) {
    if (!(beam.radius_m > 0)) return false;
  }
  for (int i = 0; i < world.interval_count(); ++i) {
    if (world.surfaces_reflect(i) || largest_scattering_depth(world, i) > 1) return true;
  }
  return false;
}

/// The rays of a pixel share its samples. What is more than a pass can hold goes into further passes: of paths
/// only, since passes that ask the same map are not independent.
void share_samples(const Description& scene, Plan& plan) {
  const int samples = scene.render.samples;
  // Where all pixels have as many rays, none is without a sample.
  if (!plan.sampling.adaptive) plan.sampling.max_oversampling = std::min(plan.sampling.max_oversampling, samples);
  plan.sampling.samples = samples;
  // For whoever asks along single rays.
  plan.radiance.points = std::clamp((samples + plan.sampling.max_oversampling - 1) / plan.sampling.max_oversampling, 1, kMostPoints);
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

Plan make_plan(const Description& scene, const World& world) {
  Plan plan;
  plan.effects = effects_of(scene, world);
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
  if (scene.render.method == MethodKind::path) {
    plan.radiance.gather_bounces = kAllBounces;
    share_samples(scene, plan);
  } else if (gathers(scene, world)) {
    plan.radiance.gather_bounces = 1;
    // Many questions, none of which shows by itself: the least points for each denominator do.
    plan.radiance.gather.rounds = 2;
    share_samples(scene, plan);
  }
  return plan;
}

}  // namespace obscura
