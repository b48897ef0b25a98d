// The furnace: where everything has one temperature, so has the image, whatever scatters.
#include <catch2/catch.hpp>

#include "sensor/capture/render.h"
#include "tests/support/agree.h"
#include "tests/support/rendered.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

constexpr double kRadiance = 3.7;

Film photograph(const World& world, std::uint64_t photons, int rays = 4) {
  CameraSettings camera;
  camera.position_m = {1.6, -6, 2};
  camera.look_at_m = {1.6, 1.6, 1.6};
  camera.fov_deg = 40;
  camera.resolution = {32, 24};
  TraceSettings trace;
  trace.photons = photons;
  const Light light = trace_light(world, trace);
  CHECK(light.anomalies == 0);
  Rendered rendered = test::render_pass(world, light.maps, Camera(camera), {.max_oversampling = rays, .seed = 1}, {});
  CHECK(rendered.counts.anomalies == 0);
  return std::move(rendered.film);
}

}  // namespace

TEST_CASE("without scattering every pixel of the furnace has its radiance", "[physics][furnace]") {
  const World world(grey_contents(rough_wish(0, 0, kRadiance), kRadiance));
  const Film film = photograph(world, 1000);
  for (const float value : film.values(0, Film::Value::radiance)) {
    CHECK(std::abs(static_cast<double>(value) - kRadiance) < 1e-6 * kRadiance);
  }
}

TEST_CASE("with scattering the furnace's image has its radiance in the mean", "[physics][furnace]") {
  struct Case {
    double albedo, g;
  };
  for (const Case c : {Case{0.5, 0}, Case{0.9, 0.7}, Case{0.95, -0.3}}) {
    const World world(grey_contents(rough_wish(c.albedo, c.g, kRadiance), kRadiance));
    const Film film = photograph(world, 600000, 48);
    const ImageMean mean = film.mean(0);
    // Each pixel knows its error: sixteen batches are Student's t, and neighbours share photons.
    const auto radiance = film.values(0, Film::Value::radiance);
    const auto error = film.values(0, Film::Value::error);
    double z2 = 0;
    int scattered = 0;
    for (std::size_t p = 0; p < radiance.size(); ++p) {
      if (!(double(error[p]) > 1e-6 * kRadiance)) continue;
      const double z = (double(radiance[p]) - kRadiance) / double(error[p]);
      z2 += z * z;
      ++scattered;
    }
    const double z = std::sqrt(z2 / scattered);
    INFO("albedo " << c.albedo << ", g " << c.g << ": mean " << mean.mean << " +- " << mean.standard_error
                   << ", pixel z " << z);
    CHECK(scattered > 200);
    CHECK(z > 0.9);
    CHECK(z < 1.3);
    CHECK(std::abs(mean.mean - kRadiance) < 3 * mean.standard_error);
    CHECK(mean.standard_error < 0.003 * kRadiance);
  }
}

TEST_CASE("a furnace whose sky is colder is seen to be none", "[physics][furnace]") {
  const World world(grey_contents(rough_wish(0.5, 0, kRadiance), 0.95 * kRadiance));
  const ImageMean mean = photograph(world, 400000, 48).mean(0);
  CHECK(std::abs(mean.mean - kRadiance) > 3 * mean.standard_error);
}
