#include "scene/session.h"

#include <utility>

#include "photon/path_tracer.h"

namespace obscura {
namespace {

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

}  // namespace

Session::Session(Description scene, double time_s, const Progress& progress)
    : scene_(std::move(scene)),
      built_(build_world(scene_, time_s, progress)),
      plan_(make_plan(scene_, built_.world)),
      rectangles_(rectangles_of(scene_)) {}

const Light& Session::light(const Progress& progress) {
  if (!light_) {
    light_ = scene_.render.method == MethodKind::path ? Light{}
                                                      : trace_light(world(), plan_.trace, rectangles_, progress);
  }
  return *light_;
}

void Session::look_from(const SensorDescription& sensor) { set(sensor, scene_.render); }

void Session::set(SensorDescription sensor, const RenderDescription& render) {
  scene_.sensor = std::move(sensor);
  set_render(render);
}

void Session::set_render(const RenderDescription& render) {
  const MethodKind method = scene_.render.method;
  scene_.render = render;
  Plan plan = make_plan(scene_, world());
  if (!same_photons(plan.trace, plan_.trace) || render.method != method) light_.reset();
  plan_ = std::move(plan);
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
