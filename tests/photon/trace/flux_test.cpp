// Crossings of a rectangle, counted with their sign, once or in every periodic copy.
#include "photon/trace/flux.h"

#include <catch2/catch.hpp>

#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

World plain() { return World(grey_contents({})); }

World periodic() {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.period_m = {10, 12};
  WorldContents contents = grey_contents(wish);
  contents.clouds[0].local_to_world = placement({3, 1, 2}, {0, 0, 0.5}, 1);
  return World(std::move(contents));
}

}  // namespace

TEST_CASE("sides of a rectangle are at right angles to its normal and turn about it", "[photon][flux]") {
  for (const Vec3d& normal : {Vec3d(0, 0, 1), Vec3d(0, 0, -1), Vec3d(1, 0, 0), Vec3d(1, -2, 3).normalized()}) {
    const auto [u, v] = rectangle_sides(normal);
    CHECK(u.length() == Approx(1));
    CHECK(v.length() == Approx(1));
    CHECK(u.z == Approx(0).margin(1e-15));
    CHECK((u.cross(v) - normal).length() < 1e-14);
  }
  CHECK(rectangle_sides({0, 0, 1}).first == Vec3d(1, 0, 0));
}

TEST_CASE("a flight counts along the normal as one, against it as minus one", "[photon][flux]") {
  const World world = plain();
  const FluxRectangle r{{1, 2, 3}, {2, 0, 0}, {0, 4, 0}};  // normal +z
  CHECK(crossings(world, r, {1.9, 3.9, 0}, {0, 0, 1}, kInfinity) == 1);
  CHECK(crossings(world, r, {1.9, 3.9, 6}, {0, 0, -1}, kInfinity) == -1);
  CHECK(crossings(world, r, {2.1, 3.9, 0}, {0, 0, 1}, kInfinity) == 0);
  CHECK(crossings(world, r, {1.9, 4.1, 0}, {0, 0, 1}, kInfinity) == 0);
  CHECK(crossings(world, r, {1, 2, 0}, {0, 0, -1}, kInfinity) == 0);  // away from it
  CHECK(crossings(world, r, {1, 2, 0}, {0, 0, 1}, 2.99) == 0);        // ends before
  CHECK(crossings(world, r, {1, 2, 0}, {0, 0, 1}, 3) == 1);           // ends on it: passed
  CHECK(crossings(world, r, {1, 2, 3}, {0, 0, 1}, 5) == 0);           // starts on it: had passed
  CHECK(crossings(world, r, {0, 2, 3}, {1, 0, 0}, kInfinity) == 0);   // in its plane
}

TEST_CASE("rectangles that share a side count a flight through it once", "[photon][flux]") {
  const World world = plain();
  int sum = 0;
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      sum += crossings(world, {{0.5 + i, 0.5 + j, 0}, {1, 0, 0}, {0, 1, 0}}, {1, 1, -1}, {0, 0, 1}, kInfinity);
    }
  }
  CHECK(sum == 1);
}

TEST_CASE("in a periodic World every copy of the rectangle counts", "[photon][flux]") {
  const World world = periodic();
  Stream random(1, 0, 0);
  const Vec3d u = world.period()[0].normalized(), v = world.period()[1].normalized();
  const FluxRectangle cell{{50, -20, 12}, world.period()[0], world.period()[1]};
  const FluxRectangle double_cell{{50, -20, 12}, 2.0 * world.period()[0], world.period()[1]};
  const FluxRectangle part{{50, -20, 12}, 4.0 * u, 7.0 * v};
  const FluxRectangle large{{50, -20, 12}, 23.0 * u, 15.0 * v};
  double in_part = 0, in_large = 0;
  constexpr int kFlights = 20000;
  for (int i = 0; i < kFlights; ++i) {
    const Vec3d o(100 * random.uniform() - 50, 100 * random.uniform() - 50, 0);
    Vec3d d = random_direction(random);
    d.z = std::abs(d.z) + 0.01;
    CHECK(crossings(world, cell, o, d, kInfinity) == 1);
    CHECK(crossings(world, double_cell, o, d, kInfinity) == 2);
    CHECK(crossings(world, cell, {o.x, o.y, 24}, -d, kInfinity) == -1);
    in_part += crossings(world, part, o, d, kInfinity);
    in_large += crossings(world, large, o, d, kInfinity);
  }
  CHECK(in_part / kFlights == Approx(28.0 / 120).epsilon(0.06));
  CHECK(in_large / kFlights == Approx(345.0 / 120).epsilon(0.02));
}
