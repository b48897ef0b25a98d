// Ray integrals through the octree against the exact solutions a2, a6 and a9, where voxels hold the field exactly.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/physics/ray_tables.h"
#include "tests/support/csv.h"
#include "tests/support/ray_radiance.h"
#include "tests/support/verified.h"

using namespace obscura;
using namespace obscura::test;

TEST_CASE("a2: a box is exact along any ray", "[physics][ray]") {
  const Csv csv = table("a2_box_rays.csv");
  const auto box = [](const Vec3i& voxels) {
    return lossless(field_stream(
        Box3i(Vec3i(0, 0, 0), voxels), {"density"}, [](int, const Vec3i&) { return 1.0f; }, scaled(Vec3d(0.5))));
  };
  const Octree tree = box({4, 2, 1});
  const Octree wrong = box({4, 2, 2});
  int wrong_rows = 0;
  Verified verified =
      verified_walk("a2_box_rays.csv",
                    "depth and radiance of every ray but one in an upper face (outside: boxes are half open)", "1e-12");
  for (std::size_t i = 0; i < csv.size(); ++i) {
    const Ray ray = row_ray(csv, i);
    INFO("row " << i);
    const auto k = [](const Walk& w) { return 1.3 * w.value(0); };
    const Gathered g = gather(tree, ray, k, constant(kSource));
    wrong_rows += std::abs(depth_along(wrong, ray, 1.3) - csv.number(i, "tau")) > 1e-12;
    // A ray in an upper face is outside: the box is [lower, upper).
    const bool in_upper_face = ray.origin.y == 1 && ray.origin.z == 0.5;
    const double tau = in_upper_face ? 0 : csv.number(i, "tau");
    CHECK(depth_along(tree, ray, 1.3) == Approx(tau).epsilon(1e-12));
    if (!in_upper_face) verified.within(g.radiance + g.transmission() * kBackground, csv.number(i, "I"), 1e-12);
    CHECK(g.depth == Approx(tau).epsilon(1e-12));
    CHECK(g.radiance + g.transmission() * kBackground ==
          Approx(in_upper_face ? kBackground : csv.number(i, "I")).epsilon(1e-12));
  }
  CHECK(wrong_rows >= 2);  // a box twice as high is noticed by rays that go up
}

TEST_CASE("a6: layers are exact", "[physics][ray]") {
  const Csv csv = table("a6_layers.csv");
  Verified verified = verified_walk("a6_layers.csv", "transmission and radiance of every stack", "1e-12");
  for (std::size_t i = 0; i < csv.size(); ++i) {
    INFO("row " << i);
    const std::vector<double> tau = csv.numbers(i, "tau_list"), source = csv.numbers(i, "B_list");
    const int n = static_cast<int>(tau.size());
    // The layer's number, from which depth and source are looked up in double: exact.
    const Octree numbered = column(n, n, {"layer"}, [n](int, double share) { return std::floor(share * n) + 1; });
    const auto layer = [](const Walk& w) { return static_cast<std::size_t>(w.value(0)); };
    const auto k = [&](const Walk& w) { return layer(w) ? tau[layer(w) - 1] : 0.0; };
    const auto b = [&](const Walk& w) { return layer(w) ? source[layer(w) - 1] : 0.0; };
    const Gathered g = gather(numbered, kUp, k, b);
    CHECK(g.transmission() == Approx(csv.number(i, "T_total")).epsilon(1e-12));
    verified.within(g.transmission(), csv.number(i, "T_total"), 1e-12);
    verified.within(g.radiance, csv.number(i, "I_noback"), 1e-12);
    CHECK(g.radiance == Approx(csv.number(i, "I_noback")).epsilon(1e-12));
    CHECK(g.radiance + g.transmission() * kBackground == Approx(csv.number(i, "I")).epsilon(1e-12));

    // Extinction and source themselves in the voxels: float.
    const Octree stored = column(n, n, {"k", "B"}, [&](int c, double share) {
      return (c == 0 ? tau : source)[static_cast<std::size_t>(share * n)];
    });
    const Gathered s = gather(stored, kUp, channel(0), channel(1));
    CHECK(s.radiance == Approx(csv.number(i, "I_noback")).epsilon(1e-6));
    CHECK(s.depth == Approx(g.depth).epsilon(1e-6));

    // From behind, the layers are in the wrong order: the test sees it where it matters.
    const Gathered back = gather(numbered, line(Vec3d(0.5, 0.5, n + 1.0), Vec3d(0, 0, -1)), k, b);
    CHECK(back.depth == Approx(g.depth).epsilon(1e-12));
    if (i != 3) CHECK(relative(back.radiance, g.radiance) > 1e-6);
  }
}

TEST_CASE("a9: the walk gives the voxel field's exact integral", "[physics][ray]") {
  const Csv csv = table("a9_voxel_step_field.csv");
  Verified verified = verified_walk("a9_voxel_step_field.csv", "depth and radiance of every ray", "1e-11");
  const auto number = [](const Vec3i& v) { return static_cast<float>((7 * v.x + 13 * v.y + 29 * v.z) % 11); };
  const auto source = [](const Vec3i& v) { return static_cast<float>(1 + (v.x + 2 * v.y + 3 * v.z) % 5); };
  const Octree tree = lossless(field_stream(Box3i(Vec3i(0, 0, 0), Vec3i(8, 8, 8)), {"k10", "B"},
                                            [&](int c, const Vec3i& v) { return c == 0 ? number(v) : source(v); }));
  REQUIRE(csv.size() == 10);
  for (std::size_t i = 0; i < csv.size(); ++i) {
    INFO("ray " << i);
    const Ray ray = row_ray(csv, i);
    const double tau = csv.number(i, "tau");
    CHECK(relative(depth_along(tree, ray, 0.1), tau) < 1e-11);
    const Gathered g = gather(
        tree, ray, [](const Walk& w) { return 0.1 * w.value(0); }, channel(1));
    CHECK(relative(g.length, csv.number(i, "path_in_grid")) < 1e-11);
    CHECK(relative(g.depth, tau) < 1e-11);
    verified.within(g.depth, tau, 1e-11);
    verified.within(g.radiance, csv.number(i, "I"), 1e-11);
    CHECK(relative(g.radiance, csv.number(i, "I")) < 1e-11);
    CHECK(relative(g.radiance + g.transmission() * kBackground, csv.number(i, "I_back")) < 1e-11);

    // The free path's inverse: the depth up to its end is the depth that was asked for.
    const std::vector<double> weights{0.1, 0};
    const Ray index_ray = transform_ray(tree.local_to_index(), ray);
    for (const double share : {1e-6, 0.25, 0.7, 1 - 1e-9}) {
      const FreePath path = free_path(tree, index_ray, weights, share * tau);
      REQUIRE(path.collided);
      Ray up_to = index_ray;
      up_to.t_max = path.t;
      CHECK(relative(optical_depth(tree, up_to, weights), share * tau) < 1e-9);
    }
    CHECK_FALSE(free_path(tree, index_ray, weights, tau * (1 + 1e-9)).collided);

    // A lattice that is off by a voxel is another field.
    Ray off = ray;
    off.origin += Vec3d(0, 1, 1);
    CHECK(relative(depth_along(tree, off, 0.1), tau) > 1e-3);
  }
}
