// The World's batched depths and flights against the scalar walk: far away, periodic, and where rounding matters.
#include <catch2/catch.hpp>

#include "photon/world/world.h"
#include "tests/photon/world/noisy_worlds.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

/// The batched depths and flights of these rays, each against the scalar walk.
void check_batched(const World& world, const std::vector<Ray>& rays) {
  std::vector<double> depths(rays.size());
  SpectralWorld(world, 0).optical_depths(rays, depths);
  std::vector<Flight> flights;
  Stream random(4, 0, 0);
  for (const Ray& ray : rays) flights.push_back({ray, -std::log(random.uniform())});
  std::vector<FreePath> ends(rays.size());
  SpectralWorld(world, 0).reach_depths(flights, ends);
  int collided = 0, crossed = 0;
  double worst_depth = 0, worst_target = 0;
  bool agreed = true, found_medium = true;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const double depth = scalar_depth(world, rays[i]);
    crossed += depth > 0;
    worst_depth = std::max(worst_depth, std::abs(depths[i] - depth) / std::max(depth, 0.1));
    const double target = flights[i].target_depth;
    if (std::abs(target - depth) > 1e-4 * depth) agreed = agreed && ends[i].collided == (depth > target);
    if (!ends[i].collided) continue;
    ++collided;
    Ray part = rays[i];
    part.t_max = ends[i].t;
    worst_target = std::max(worst_target, std::abs(scalar_depth(world, part) - target) / std::max(target, 0.1));
    FreePath end = ends[i];
    found_medium = found_medium && SpectralWorld(world, 0).at_collision(flights[i], end).extinction > 0;
  }
  CHECK(worst_depth < 2e-5);
  CHECK(worst_target < 5e-5);
  CHECK(agreed);
  CHECK(found_medium);
  CHECK(collided > static_cast<int>(rays.size()) / 10);
  CHECK(crossed > static_cast<int>(rays.size()) / 3);
}

}  // namespace

TEST_CASE("a cloud 1e7 m from the origin is as exact as one beside it", "[photon][world]") {
  CloudWish wish = noisy();
  const World near = world_of({make_cloud(wish)});
  wish.corner_m = {1e7, -1e7, 2e7};
  const World far = world_of({make_cloud(wish)});
  for (Ray ray : rays_about(near, 300)) {
    // Multiples of 2^-20 are moved without rounding.
    for (int axis = 0; axis < 3; ++axis) ray.origin[axis] = std::round(ray.origin[axis] * 0x1p20) * 0x1p-20;
    Ray moved = ray;
    moved.origin += wish.corner_m;
    const double depth = scalar_depth(near, ray);
    CHECK(std::abs(scalar_depth(far, moved) - depth) < 2e-7);
    double batched = 0;
    SpectralWorld(far, 0).optical_depths({&moved, 1}, {&batched, 1});
    CHECK(std::abs(batched - depth) < 1e-5 * depth + 1e-6);
  }
}

TEST_CASE("batched depths and flights agree with the scalar walk: one cloud and three", "[photon][world]") {
  Cloud a = make_cloud(noisy(0.8));
  a.local_to_world = placement({1, 2, 3}, {0.2, 0.4, 0.6}, 1);
  const World one = world_of({a});
  check_batched(one, rays_about(one, 600));
  Cloud b = make_cloud(noisy(0.3));
  b.local_to_world = placement({2, 1, 4}, {-1, 0.1, 0.3}, 1.3);
  CloudWish wish;
  wish.corner_m = {-3, -2, 1};
  wish.voxel_m = 0.5;
  wish.extinction = 0.05;
  const World three = world_of({a, b, make_cloud(wish)});
  check_batched(three, rays_about(three, 600));
}

TEST_CASE("batched depths and flights agree with the scalar walk in periodic clouds", "[photon][world]") {
  CloudWish wish = noisy(0.3);
  wish.period_m = {6, 4.5};  // a gap along x, none along y
  Cloud cloud = make_cloud(wish);
  cloud.local_to_world = placement({1, 2, 3}, {0.2, -0.1, 0.6}, 1.1);
  const World world = world_of({cloud});
  check_batched(world, rays_about(world, 600, 60));
  const World two = world_of({cloud, cloud});
  check_batched(two, rays_about(two, 300, 60));
}

TEST_CASE("a ray along a periodic layer goes through cell after cell", "[photon][world]") {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.density = [](const Vec3i& v) { return v.x < 4 ? 1.0 : 3.0; };
  wish.extinction = 0.01;
  wish.period_m = {10, 8};
  const World world = world_of({make_cloud(wish)});
  const double cell = 0.01 * (4 * 1 + 4 * 3);
  for (const double sign : {1.0, -1.0}) {
    const Ray ray{{0, 4, 4}, {sign, 0, 0}, 0, 1000};
    double depth = 0;
    SpectralWorld(world, 0).optical_depths({&ray, 1}, {&depth, 1});
    CHECK(depth == Approx(100 * cell).epsilon(1e-5));
    CHECK(scalar_depth(world, ray) == Approx(100 * cell).epsilon(1e-12));
    // Endless: nothing of the light is left, and a flight ends where it should.
    const Ray endless{{0, 4, 4}, {sign, 0, 0}, 0, kInfinity};
    SpectralWorld(world, 0).optical_depths({&endless, 1}, {&depth, 1});
    CHECK(depth > 700);
    const Flight flight{endless, 50.5 * cell};
    FreePath end;
    SpectralWorld(world, 0).reach_depths({&flight, 1}, {&end, 1});
    CHECK(end.collided);
    // Half a cell's depth: 4 m of 1, then 4/3 m of 3; the other way from the back, after the gap.
    CHECK(end.t == Approx(500 + (sign > 0 ? 4 + 4.0 / 3 : 2 + 8.0 / 3)).epsilon(1e-5));
  }
}

TEST_CASE("a collision that rounding has carried out of the cloud is put right", "[photon][world]") {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  const World world = world_of({make_cloud(wish)});
  const Flight flight{{{4, 4, -2}, {0, 0, 1}, 0, kInfinity}, 8 - 1e-7};
  FreePath end{10 + 1e-6, flight.target_depth, true};
  CHECK(SpectralWorld(world, 0).at(flight.ray.at(end.t)).extinction == 0);
  CHECK(SpectralWorld(world, 0).at_collision(flight, end).extinction == 1);
  CHECK(end.collided);
  CHECK(end.t < 10);
  CHECK(end.t > 10 - 1e-4);
  // More than there is: no collision after all.
  const Flight beyond{flight.ray, 8 + 1e-7};
  end = {10 + 1e-6, beyond.target_depth, true};
  CHECK(SpectralWorld(world, 0).at_collision(beyond, end).extinction == 0);
  CHECK(!end.collided);
}
