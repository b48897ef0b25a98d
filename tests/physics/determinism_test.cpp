// The same bits for any number of threads, and another image for another seed.
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <catch2/catch.hpp>

#include "sensor/capture/render.h"
#include "tests/support/rendered.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

struct Outcome {
  std::vector<float> radiance, error, bias;
  std::vector<Photon> photons;
  EnergyTally energy;
};

Outcome run(int threads, std::uint64_t seed) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  Outcome outcome;
  arena.execute([&] {
    WorldContents contents = grey_contents(rough_wish(0.8, 0, 2), 0.7);
    contents.sun = Sun{Vec3d(0.3, -0.5, 0.8).normalized(), {5}, 0.01};
    const World world(std::move(contents));
    TraceSettings trace;
    trace.photons = 30000;
    trace.seed = seed;
    const Light light = trace_light(world, trace);
    outcome.photons.assign(light.maps[0].volume.photons().begin(), light.maps[0].volume.photons().end());
    outcome.energy = light.bands[0].energy;
    CameraSettings camera;
    camera.position_m = {1.6, -6, 2};
    camera.look_at_m = {1.6, 1.6, 1.6};
    camera.resolution = {40, 30};
    RadianceSettings radiance;
    radiance.seed = seed;
    const Film film =
        test::render_pass(world, light.maps, Camera(camera), {.max_oversampling = 4, .seed = seed}, radiance).film;
    const auto copy = [&](Film::Value value) {
      const auto values = film.values(0, value);
      return std::vector<float>(values.begin(), values.end());
    };
    outcome.radiance = copy(Film::Value::radiance);
    outcome.error = copy(Film::Value::error);
    outcome.bias = copy(Film::Value::bias);
  });
  return outcome;
}

}  // namespace

TEST_CASE("image, photons and tallies are the same bits with 1, 2 and 7 threads", "[physics][threads]") {
  const Outcome one = run(1, 1);
  for (const int threads : {2, 7}) {
    const Outcome many = run(threads, 1);
    CHECK(many.radiance == one.radiance);
    CHECK(many.error == one.error);
    CHECK(many.bias == one.bias);
    CHECK(many.energy.absorbed == one.energy.absorbed);
    CHECK(many.energy.escaped == one.energy.escaped);
    REQUIRE(many.photons.size() == one.photons.size());
    CHECK(
        std::equal(one.photons.begin(), one.photons.end(), many.photons.begin(), [](const Photon& a, const Photon& b) {
          return a.position == b.position && a.direction == b.direction && a.power == b.power && a.batch == b.batch &&
                 a.collisions == b.collisions;
        }));
  }
  CHECK(run(2, 2).radiance != one.radiance);
}
