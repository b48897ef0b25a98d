// The batched walk against the scalar one, on every SIMD path that this machine can run.
#include "octree/tree/batch_walk.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "octree/build/build.h"
#include "tests/support/voxel_fields.h"

using namespace obscura;
using namespace obscura::test;

namespace {

struct ForcedTarget {
  explicit ForcedTarget(std::string_view name) { REQUIRE(force_batch_target(name)); }
  ~ForcedTarget() { force_batch_target(""); }
};

Octree tree_of(double tolerance, int channels, const Box3i& domain) {
  BuildSettings settings;
  settings.tolerance = tolerance;
  std::vector<std::string> names;
  for (int c = 0; c < channels; ++c) {
    names.push_back("c" + std::to_string(c));
    settings.measure.optical_weight.push_back(0.05 / (c + 1));
  }
  return build_octree(field_stream(domain, names, patchwork(41)), settings).first;
}

}  // namespace

TEST_CASE("every SIMD path gives the scalar walk's optical depths", "[octree][batch_walk][imitated]") {
  const Box3i domain(Vec3i(-13, -45, 5), Vec3i(61, 20, 76));
  const double tolerance = GENERATE(0.0, 1e-3);
  const int channels = GENERATE(1, 2, 3);
  const Octree tree = tree_of(tolerance, channels, domain);
  const std::vector<double> weights = std::vector<double>{0.7, 0.02, 0.3};
  const std::span<const double> used(weights.data(), static_cast<std::size_t>(channels));
  std::vector<Ray> rays;
  for (std::uint64_t i = 0; i < 30000; ++i) rays.push_back(awkward_ray(domain, 43, i));
  std::vector<double> expected;
  for (const Ray& ray : rays) expected.push_back(optical_depth(tree, ray, used));
  for (const std::string_view target : batch_targets()) {
    const ForcedTarget forced(target);
    REQUIRE(batch_target() == target);
    std::vector<double> depths(rays.size(), -1);
    optical_depths(tree, rays, used, depths);
    double worst = 0;
    int bad = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      // What t means scales with the direction.
      const double unit = 1 / rays[i].direction.length();
      const double error = std::abs(depths[i] - expected[i]) / std::max(1e-5 * expected[i], 2e-6 * unit);
      if (!(error <= 1)) {
        INFO(target << ", ray " << i << " from " << rays[i].origin << " along " << rays[i].direction << ": "
                    << depths[i] << " instead of " << expected[i]);
        if (++bad < 5) CHECK(error <= 1);
      }
      worst = std::max(worst, error);
    }
    INFO(target << ", worst " << worst);
    CHECK(bad == 0);
  }
}

TEST_CASE("every SIMD path ends flights where the scalar walk does", "[octree][batch_walk][imitated]") {
  const Box3i domain(Vec3i(-13, -45, 5), Vec3i(61, 20, 76));
  const double tolerance = GENERATE(0.0, 1e-3);
  const int channels = GENERATE(1, 2, 3);
  const Octree tree = tree_of(tolerance, channels, domain);
  const double weights[] = {0.2, 0.1, 0.05};
  const std::span<const double> used(weights, static_cast<std::size_t>(channels));
  std::vector<Flight> flights;
  for (std::uint64_t i = 0; i < 20000; ++i) {
    Stream random(47, i, 0);
    flights.push_back({awkward_ray(domain, 45, i), -std::log(random.uniform())});
  }
  for (const std::string_view target : batch_targets()) {
    const ForcedTarget forced(target);
    std::vector<FreePath> ends(flights.size());
    free_paths(tree, flights, used, ends);
    int collided = 0, differ = 0;
    for (std::size_t i = 0; i < flights.size(); ++i) {
      const Ray& ray = flights[i].ray;
      const FreePath expected = free_path(tree, ray, used, flights[i].target_depth);
      const double unit = 1 / ray.direction.length();
      // A collision is kept 2e-5 of its leaf away from the leaf's planes.
      const double tolerance_depth = std::max(1e-5 * flights[i].target_depth, 2e-5);
      collided += ends[i].collided;
      if (ends[i].collided != expected.collided) {
        ++differ;  // only where the whole depth is all but the target
        CHECK(std::abs(optical_depth(tree, ray, used) - flights[i].target_depth) <
              tolerance_depth * std::max(1.0, unit));
        continue;
      }
      CHECK(std::abs(ends[i].depth - expected.depth) <= tolerance_depth * std::max(1.0, unit));
      if (ends[i].collided) {
        Ray cut = ray;
        cut.t_max = ends[i].t;
        INFO(target << " ray " << i << " from " << ray.origin << " along " << ray.direction);
        CHECK(std::abs(optical_depth(tree, cut, used) - flights[i].target_depth) <=
              tolerance_depth * std::max(1.0, unit));
      } else {
        CHECK(ends[i].t == Approx(expected.t).epsilon(1e-5).margin(1e-4 * unit));
      }
    }
    CHECK(collided > 5000);
    CHECK(differ < 5);
  }
}

TEST_CASE("a ray's result does not depend on its batch", "[octree][batch_walk]") {
  const Box3i domain(Vec3i(0), Vec3i(64, 48, 56));
  const Octree tree = tree_of(1e-3, 1, domain);
  const double weights[] = {0.3};
  std::vector<Ray> rays;
  for (std::uint64_t i = 0; i < 997; ++i) rays.push_back(awkward_ray(domain, 53, i));
  std::vector<double> together(rays.size()), alone(rays.size()), reversed(rays.size());
  optical_depths(tree, rays, weights, together);
  for (std::size_t i = 0; i < rays.size(); ++i) optical_depths(tree, {&rays[i], 1}, weights, {&alone[i], 1});
  std::vector<Ray> backwards(rays.rbegin(), rays.rend());
  optical_depths(tree, backwards, weights, reversed);
  std::reverse(reversed.begin(), reversed.end());
  CHECK(together == alone);
  CHECK(together == reversed);
}

TEST_CASE("batches of nothing and of rays that miss are answered", "[octree][batch_walk]") {
  const Octree tree = tree_of(0, 1, Box3i(Vec3i(0), Vec3i(16)));
  const double weights[] = {1.0};
  optical_depths(tree, {}, weights, {});
  const Ray rays[] = {Ray{{-1, 20, 4}, {1, 0, 0}}, Ray{{-1, 4, 4}, {-1, 0, 0}}, Ray{{-1, 4, 4}, {1, 0, 0}, 30, 40},
                      Ray{{-1, 16, 4}, {1, 0, 0}}};
  double depths[4] = {1, 1, 1, 1};
  optical_depths(tree, rays, weights, depths);
  for (const double depth : depths) CHECK(depth == 0);
  const double none[] = {0.0};
  optical_depths(tree, {rays, 1}, none, {depths, 1});
  CHECK(depths[0] == 0);
  CHECK_FALSE(force_batch_target("no such target"));
}
