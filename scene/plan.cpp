#include "scene/plan.h"

namespace obscura {
namespace {

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

std::vector<PlanRow> effects_of(const Description& scene, const World& world) {
  bool absorbs = false, emits = false, scatters = false, sky = false, sun = false;
  for (int i = 0; i < world.interval_count(); ++i) {
    for (int c = 0; c < world.cloud_count(); ++c) {
      for (const CloudOptics::Part& part : world.optics(c, i).parts()) {
        absorbs = absorbs || part.extinction > part.scattering;
      }
    }
    emits = emits || world.emits(i);
    scatters = scatters || world.scatters(i);
    sky = sky || world.sky(i) > 0;
    for (const Sun& disc : world.suns()) sun = sun || disc.irradiance[static_cast<std::size_t>(i)] > 0;
  }
  const int depth = scene.sensor.scattering_depth.value_or(1 << 30);
  const bool masks = !world.spheres().empty();
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
  row("surfaces", false, "", "the scene has no objects");
  row("specular", false, "", "the scene has no objects");
  row("sun", sun, "the scene has a sun", "the scene has no sun");
  row("sky", sky, "the sky is bright", "the sky is dark");
  row("atmosphere", false, "", "the scene has no atmosphere");
  row("time", false, "", "nothing in the scene changes with time");
  row("spectral sampling", sampled, "a band has several intervals", "every band is one interval");
  row("masking", masks, "hot spheres hide what is behind them", "nothing opaque is in the scene");
  return rows;
}

}  // namespace

Plan make_plan(const Description& scene, const World& world) {
  Plan plan;
  plan.effects = effects_of(scene, world);
  plan.camera = camera_of(scene.sensor);
  plan.sampling.max_oversampling = scene.sensor.max_oversampling;
  plan.sampling.seed = scene.render.seed;

  plan.trace.photons = scene.render.photons;
  plan.trace.photon_power_min = scene.render.photon_power_min;
  plan.trace.directions = scene.render.directions;
  plan.trace.scattering_depth = scene.sensor.scattering_depth;
  plan.trace.seed = scene.render.seed;

  plan.radiance.gather.nearest = scene.render.nearest;
  plan.radiance.gather.kernel = scene.render.kernel;
  plan.radiance.scattering_depth = scene.sensor.scattering_depth;
  plan.radiance.seed = scene.render.seed;
  return plan;
}

}  // namespace obscura
