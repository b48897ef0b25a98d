// Photon map against brute force on a cloud with voids, thin beside thick, and a grazed edge.
#include <catch2/catch.hpp>

#include "sensor/capture/render.h"
#include "tests/support/agree.h"
#include "tests/support/analogue.h"
#include "tests/support/rendered.h"
#include "tests/support/rough_cloud.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

constexpr double kVoxel = 0.1;
constexpr double kExtinction = 3;

struct Setting {
  const char* name;
  double albedo, g, source, sky, sun;
};

World make_world(const Setting& setting) {
  const CloudWish wish = rough_wish(setting.albedo, setting.g, setting.source);
  WorldContents contents = grey_contents(wish, setting.sky);
  if (setting.sun > 0) contents.sun = Sun{Vec3d(0.3, -0.5, 0.8).normalized(), {setting.sun}, 1e-6};
  return World(std::move(contents));
}

AnalogueScene make_reference(const Setting& setting) {
  AnalogueScene scene;
  scene.box = Box3d(Vec3d(0), Vec3d(kRoughSide * kVoxel));
  scene.medium = [setting](const Vec3d& x) {
    const Vec3i voxel(static_cast<int>(std::floor(x.x / kVoxel)), static_cast<int>(std::floor(x.y / kVoxel)),
                      static_cast<int>(std::floor(x.z / kVoxel)));
    return AnalogueMedium{kExtinction * rough_density(voxel), setting.albedo, setting.source};
  };
  scene.majorant = kExtinction * 4.1;
  scene.g = setting.g;
  scene.sky = setting.sky;
  scene.sun = setting.sun;
  scene.toward_sun = Vec3d(0.3, -0.5, 0.8).normalized();
  return scene;
}

// From outside, along the slab's upper face at a grazing angle, and from inside.
struct View {
  const char* name;
  Vec3d from, to;
  double fov_deg;
};
const View kViews[] = {{"outside", {1.6, -5, 2.5}, {1.6, 1.6, 1.4}, 45},
                       {"grazing", {-3, 1.3, 0.95}, {1.6, 1.6, 0.8}, 30},
                       {"inside", {1.63, 1.57, 1.61}, {3, 1.6, 1.2}, 80}};

}  // namespace

TEST_CASE("photon map and brute force agree on a rough cloud", "[physics][agreement]") {
  const Setting settings[] = {
      {"thermal", 0.6, 0.3, 2.0, 0.3, 0}, {"sky", 0.9, 0.6, 0, 1.0, 0}, {"sun", 0.9, 0.6, 0, 0.0, 3.0}};
  for (const Setting& setting : settings) {
    const World world = make_world(setting);
    TraceSettings trace;
    trace.photons = 1000000;
    const Light light = trace_light(world, trace);
    Analogue analogue(make_reference(setting), 11);
    for (const View& view : kViews) {
      CameraSettings settings_of_view;
      settings_of_view.position_m = view.from;
      settings_of_view.look_at_m = view.to;
      settings_of_view.fov_deg = view.fov_deg;
      settings_of_view.resolution = {24, 16};
      const Camera camera(settings_of_view);
      const Rendered rendered = test::render_pass(world, light.maps, camera, {.max_oversampling = 16, .seed = 1}, {});

      // The same pixels by brute force, each with its own error.
      Moments reference;
      double z2 = 0;
      double bias = 0;
      Stream jitter(3, 0, 0);
      const auto radiance = rendered.film.values(0, Film::Value::radiance);
      const auto errors = rendered.film.values(0, Film::Value::error);
      const auto biases = rendered.film.values(0, Film::Value::bias);
      for (std::size_t p = 0; p < radiance.size(); ++p) {
        Moments pixel;
        for (int i = 0; i < 400; ++i) {
          const double px = static_cast<double>(p % 24) + jitter.uniform();
          const Ray ray = *camera.ray(px, static_cast<double>(p / 24) + jitter.uniform());
          pixel.add(analogue.history(ray.origin, ray.direction));
        }
        reference.merge(pixel);
        const double error = std::hypot(static_cast<double>(errors[p]), pixel.standard_error());
        const double z = (static_cast<double>(radiance[p]) - pixel.mean()) / error;
        if (error > 0) z2 += z * z / static_cast<double>(radiance.size());
        bias += static_cast<double>(biases[p]) / static_cast<double>(radiance.size());
      }
      const ImageMean mean = rendered.film.mean(0);
      const double error = std::hypot(mean.standard_error, reference.standard_error());
      INFO(setting.name << ", " << view.name << ": map " << mean.mean << " +- " << mean.standard_error << " (bias "
                        << bias << "), brute force " << reference.mean() << " +- " << reference.standard_error()
                        << ", pixel z " << std::sqrt(z2));
      // In the mean the kernel's bias is below 1 %.
      CHECK(std::abs(mean.mean - reference.mean()) < 3 * error + 0.01 * reference.mean());
      CHECK(error < 0.02 * reference.mean());
      // The picture's voxels bend it inside a pixel, which counts as noise of its stratified rays, and edges lend
      // their errors to their neighbours: much in a picture of so few pixels.
      CHECK(std::sqrt(z2) > 0.75);
      CHECK(std::sqrt(z2) < 1.3);
    }
  }
}
