// The error of a photon image tells the truth: over many seeds its interval holds the true value.
#include <catch2/catch.hpp>

#include "tests/support/distributions.h"
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
