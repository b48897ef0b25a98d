#include "scene/session/session.h"

#include <algorithm>
#include <utility>

#include "octree/base/error.h"
#include "photon/paths/path_tracer.h"
#include "sensor/capture/view.h"

namespace obscura {
namespace {

/// Enough to tell where power goes to some tenths of a per cent.
constexpr std::uint64_t kBalancePhotons = 65536;

std::vector<FluxRectangle> rectangles_of(const Description& scene) {
  std::vector<FluxRectangle> rectangles;
  for (const FluxDescription& flux : scene.flux) {
    const Vec3d normal = flux.normal.normalized();
    const auto [u, v] = rectangle_sides(normal);
    rectangles.push_back({flux.center_m, flux.size_m[0] * u, flux.size_m[1] * v});
  }
  return rectangles;
}

bool same_photons(const TraceSettings& a, const TraceSettings& b) {
  return a.photons == b.photons && a.photon_power_min == b.photon_power_min && a.directions == b.directions &&
         a.scattering_depth == b.scattering_depth && a.seed == b.seed;
}

bool same_view(const SensorDescription& a, const SensorDescription& b) {
  return a.position_m == b.position_m && a.look_at_m == b.look_at_m && a.up == b.up && a.projection == b.projection &&
         a.fov_deg == b.fov_deg && a.width_m == b.width_m && a.resolution == b.resolution;
}

}  // namespace

Session::Session(Description scene, double time_s, const Progress& progress, std::optional<double> budget)
    : scene_(std::move(scene)),
      budget_(budget),
      built_(build_world(with_fewest_intervals(scene_), time_s, progress)),
      has_atmosphere_(built_.world.atmosphere().has_value()),
      rectangles_(rectangles_of(scene_)) {
  summary_ = summarize(built_.world, view_of(Camera(camera_of(scene_.sensor))));
  make_plan();
}

void Session::make_plan() {
  Plan plan =
      obscura::make_plan(scene_, summary_, budget_.value_or(scene_.render.target_error.value_or(kDefaultBudget)));
  if (plan.cuts != plan_.cuts) {
    // Octrees and meshes are shared; what finds surfaces exists once at a time.
    if (!whole_) whole_ = world().contents();
    built_.world = World({});
    built_.world = World(plan.cuts.any() ? reduced(*whole_, plan.cuts) : *whole_);
    if (!plan.cuts.any()) whole_.reset();
    light_.reset();
  }
  plan_ = std::move(plan);
}

const Light& Session::light(const Progress& progress) {
  if (!light_) {
    light_ = plan_.maps ? trace_light(world(), plan_.trace, rectangles_, progress) : balance(progress);
  }
  return *light_;
}

Light Session::balance(const Progress& progress) const {
  if (scene_.render.method == MethodKind::path) return {};
  TraceSettings few = plan_.trace;
  few.photons = std::min(few.photons, kBalancePhotons);
  few.store = false;
  try {
    Light light = trace_light(world(), few, {}, progress);
    light.maps.clear();
    return light;
  } catch (const NumericalError&) {
    // Photons do not serve the World, and the image does not need them.
    return {};
  }
}

void Session::look_from(const SensorDescription& sensor) { set(sensor, scene_.render); }

void Session::set(SensorDescription sensor, const RenderDescription& render) {
  const bool looks = !same_view(sensor, scene_.sensor);
  scene_.sensor = std::move(sensor);
  if (looks) {
    // Another view may call for what this one did without.
    const CameraView view = view_of(Camera(camera_of(scene_.sensor)));
    summary_ = whole_ ? summarize(World(*whole_), view) : summarize(world(), view);
  }
  set_render(render);
}

void Session::set_render(const RenderDescription& render) {
  const TraceSettings traced = plan_.trace;
  const bool maps = plan_.maps;
  scene_.render = render;
  make_plan();
  if (!same_photons(plan_.trace, traced) || plan_.maps != maps) light_.reset();
}

Rendered Session::render(const Progress& progress, std::vector<int> tiles) {
  if (plan_.radiance.gather_bounces > 0) refuse_unfit_paths(world());
  const Light& traced = light(progress);
  const auto pass = [&](int number) {
    SamplerSettings sampling = plan_.sampling;
    sampling.pass = static_cast<std::uint32_t>(number);
    sampling.tiles = tiles;
    return obscura::render(world(), traced.maps, Camera(plan_.camera), sampling, plan_.radiance, progress);
  };
  Rendered image = pass(0);
  for (int number = 1; number < plan_.passes && !progress.cancelled(); ++number) {
    const Rendered more = pass(number);
    image.film.merge(more.film);
    image.counts += more.counts;
    image.rays += more.rays;
  }
  return image;
}

}  // namespace obscura
