// The error of a photon image tells the truth: over many seeds its interval holds the true value.
#include <catch2/catch.hpp>

#include "photon/paths/path_tracer.h"
#include "sensor/capture/render.h"
#include "tests/support/distributions.h"
#include "tests/support/rendered.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

TEST_CASE("over 200 seeds the batch error's interval holds the mean in 90 to 98 per cent", "[physics][coverage]") {
  const World world(grey_contents(rough_wish(0.7, 0, 2), 1));
  const Ray rays[] = {{{1.6, -3, 1.7}, Vec3d(0.02, 1, 0.03).normalized(), 0, kInfinity},
                      {{-1, 1.3, 0.86}, Vec3d(1, 0.05, -0.02).normalized(), 0, kInfinity},
                      {{1.63, 1.57, 1.61}, Vec3d(-0.4, 0.3, 0.8).normalized(), 0, kInfinity}};
  constexpr int kSeeds = 200;
  int inside = 0, halved_inside = 0, total = 0;
  std::vector<std::array<RayRadiance, 3>> runs;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    TraceSettings trace;
    trace.photons = 20000;
    trace.seed = static_cast<std::uint64_t>(seed);
    const Light light = trace_light(world, trace);
    RadianceSettings settings;
    settings.seed = trace.seed;
    auto& run = runs.emplace_back();
    for (std::size_t r = 0; r < 3; ++r) run[r] = ray_radiance(world, light, rays[r], 16, settings);
  }
  for (std::size_t r = 0; r < 3; ++r) {
    // The map's own expectation: its bias is another matter.
    double truth = 0;
    for (const auto& run : runs) truth += run[r].mean / kSeeds;
    for (const auto& run : runs) {
      // 1.96 would be for a known variance; 15 degrees of freedom take 2.13.
      inside += std::abs(run[r].mean - truth) < 2.13 * run[r].error;
      halved_inside += std::abs(run[r].mean - truth) < 0.5 * 2.13 * run[r].error;
      ++total;
    }
  }
  const double share = static_cast<double>(inside) / total;
  INFO("inside: " << share << ", with half the error: " << static_cast<double>(halved_inside) / total);
  CHECK(share > 0.90);
  CHECK(share < 0.985);
  // An error of half the size would be found out.
  CHECK(static_cast<double>(halved_inside) / total < 0.90);
}

TEST_CASE("over 200 seeds the pixels' intervals hold the path tracer's values in 90 to 98 per cent",
          "[physics][coverage][path]") {
  WorldContents contents = grey_contents(rough_wish(0.9, 0.6), 0.3);
  contents.sun = Sun{Vec3d(0.3, -0.5, 0.8).normalized(), {3}, 0.01};
  const World world(std::move(contents));
  CameraSettings settings_of_view;
  settings_of_view.position_m = {1.6, -6, 3};
  settings_of_view.look_at_m = {1.6, 1.6, 1.5};
  settings_of_view.fov_deg = 34;
  settings_of_view.resolution = {16, 12};
  const Camera camera(settings_of_view);
  const auto paths = [&](int count, int rays, std::uint64_t seed) {
    PathSettings settings;
    settings.paths = count;
    settings.seed = seed;
    return render(world,
                  [&](int interval, const RayShare&, std::span<const Ray> all, std::span<const std::uint64_t> histories,
                      std::span<Incoming> incoming) {
                    return path_radiance({world, interval}, settings, all, histories, incoming);
                  },
                  camera, {.max_oversampling = rays, .seed = seed})
        .film;
  };
  const Film reference = paths(64, 256, 9999);
  const auto truth = reference.values(0, Film::Value::radiance);
  const auto truth_error = reference.values(0, Film::Value::error);

  struct Count {
    int inside = 0, halved_inside = 0, total = 0;
    void add(const Film& film, std::span<const float> truth, std::span<const float> truth_error) {
      const auto radiance = film.values(0, Film::Value::radiance);
      const auto error = film.values(0, Film::Value::error);
      const auto bias = film.values(0, Film::Value::bias);
      for (std::size_t p = 0; p < truth.size(); ++p) {
        if (!(error[p] > 0)) continue;
        const auto within = [&](double share) {
          return std::abs(double(radiance[p]) - double(truth[p])) <
                 1.96 * std::hypot(share * std::hypot(double(error[p]), double(bias[p])), double(truth_error[p]));
        };
        inside += within(1);
        halved_inside += within(0.5);
        ++total;
      }
    }
  };
  Count by_map, by_gather, by_paths, by_adaptive;
  std::uint64_t adaptive_rays = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    TraceSettings trace;
    trace.photons = 40000;
    trace.seed = seed;
    const Light light = trace_light(world, trace);
    RadianceSettings radiance;
    radiance.seed = seed;
    by_map.add(test::render_pass(world, light.maps, camera, {.max_oversampling = 8, .seed = seed}, radiance).film,
               truth, truth_error);
    radiance.gather_bounces = 1;
    radiance.gather.rounds = 2;
    by_gather.add(test::render_pass(world, light.maps, camera, {.max_oversampling = 8, .seed = seed}, radiance).film,
                  truth, truth_error);
    by_paths.add(paths(4, 8, seed), truth, truth_error);
    SamplerSettings adaptive;
    adaptive.max_oversampling = 16;
    adaptive.adaptive.emplace();
    adaptive.samples = 32;
    adaptive.seed = seed;
    const Rendered rendered = test::render_pass(world, light.maps, camera, adaptive, radiance);
    by_adaptive.add(rendered.film, truth, truth_error);
    adaptive_rays += rendered.film.rays();
  }
  for (const auto& [name, count] : {std::pair{"map", by_map}, std::pair{"final gather", by_gather},
                                    std::pair{"paths", by_paths}, std::pair{"adaptive", by_adaptive}}) {
    const double share = double(count.inside) / count.total;
    INFO(name << ": inside " << share << ", with half the error " << double(count.halved_inside) / count.total);
    CHECK(share > 0.90);
    CHECK(share < 0.98);
    CHECK(double(count.halved_inside) / count.total < 0.90);
  }
  CHECK(adaptive_rays < 12 * 200 * 16 * 12);
}
