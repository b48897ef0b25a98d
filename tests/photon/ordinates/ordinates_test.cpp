// Discrete ordinates: furnaces, conservation, the grid and what is refused.
#include "photon/ordinates/ordinates.h"

#include <oneapi/tbb/global_control.h>

#include <catch2/catch.hpp>

#include "octree/base/error.h"
#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

World cube(const CloudWish& wish, double sky, double sun = 0) {
  WorldContents contents = grey_contents(wish, sky);
  if (sun > 0) contents.sun = Sun{Vec3d(0.3, -0.4, 0.8).normalized(), {sun}, 0};
  return World(std::move(contents));
}

}  // namespace

TEST_CASE("in a furnace everything is black", "[ordinates][furnace]") {
  CloudWish wish = rough_wish(0.6, 0.5, 2.5);
  OrdinatesSettings settings;
  settings.cells = Vec3i(8);
  settings.order = 4;
  const World world = cube(wish, 2.5);
  const OrdinatesSolution solution = solve_ordinates({world, 0}, settings);
  for (std::size_t cell = 0; cell < solution.grid().size(); ++cell) {
    REQUIRE(solution.fluence(cell) == Approx(4 * kPi * 2.5).epsilon(1e-6));
    REQUIRE(solution.flux(cell).length() < 1e-5);
  }
  const Ray ray{Vec3d(-3, 0.4, 0.3), Vec3d(0.9, 0.3, 0.2).normalized(), 0, kInfinity};
  Incoming in;
  solution.radiance({&ray, 1}, {&in, 1});
  CHECK(in.direct == Approx(2.5).epsilon(1e-6));
  // A colder sky is told apart.
  CHECK(solve_ordinates({cube(wish, 2.4), 0}, settings).fluence(0) < 4 * kPi * 2.4999);
}

TEST_CASE("what does not absorb lets all light out again", "[ordinates][furnace]") {
  OrdinatesSettings settings;
  settings.cells = Vec3i(8);
  settings.order = 4;
  const OrdinatesSolution solution = solve_ordinates({cube(rough_wish(1, 0.3), 1, 5), 0}, settings);
  const OrdinatesPowers& powers = solution.powers();
  CHECK(std::abs(powers.residual()) < 1e-6);
  CHECK(std::abs(powers.absorbed) < 1e-9 * powers.entered);
  double out = 0;
  for (const auto& sides : powers.left) out += sides[0] + sides[1];
  CHECK(out == Approx(powers.entered + powers.first_scattered).epsilon(1e-6));
}

TEST_CASE("fluence is positive beside thick and thin, lit from one side", "[ordinates][positive]") {
  CloudWish wish = rough_wish(0.5);
  wish.extinction = 300;
  OrdinatesSettings settings;
  settings.cells = Vec3i(16);
  settings.order = 6;
  settings.quadrature = AngularQuadrature::level_symmetric;
  const OrdinatesSolution solution = solve_ordinates({cube(wish, 0, 1), 0}, settings);
  for (std::size_t cell = 0; cell < solution.grid().size(); ++cell) REQUIRE(solution.fluence(cell) >= 0);
  CHECK(std::abs(solution.powers().residual()) < 1e-6);
}

TEST_CASE("any number of threads gives the same bits", "[ordinates][threads]") {
  const World world = cube(rough_wish(0.9, 0.4, 1), 0.5, 2);
  OrdinatesSettings settings;
  settings.cells = Vec3i(16);
  settings.order = 4;
  const auto run = [&](std::size_t threads) {
    oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism, threads);
    const OrdinatesSolution solution = solve_ordinates({world, 0}, settings);
    std::vector<double> values;
    for (std::size_t cell = 0; cell < solution.grid().size(); ++cell) {
      values.push_back(solution.fluence(cell));
      values.push_back(solution.flux(cell).x);
    }
    return values;
  };
  const std::vector<double> one = run(1);
  CHECK(run(2) == one);
  CHECK(run(3) == one);
}

TEST_CASE("a nearly white thick cloud converges in tens of sweeps", "[ordinates][iterations]") {
  CloudWish wish;
  wish.voxels = Vec3i(16);
  wish.extinction = 100.0 / 16;
  wish.albedo = 0.9999;
  OrdinatesSettings settings;
  settings.cells = Vec3i(16);
  settings.order = 4;
  const OrdinatesSolution solution = solve_ordinates({cube(wish, 1, 1), 0}, settings);
  CHECK(solution.iterations() <= 30);
  CHECK(std::abs(solution.powers().residual()) < 1e-6);
}

TEST_CASE("an empty cloud changes nothing, and a World without clouds has its sky", "[ordinates]") {
  CloudWish wish;
  wish.density = [](const Vec3i&) { return 0.0; };
  OrdinatesSettings settings;
  settings.order = 2;
  for (const bool cloud : {true, false}) {
    WorldContents contents = grey_contents(wish, 3);
    if (!cloud) contents.clouds.clear();
    const World world(std::move(contents));
    const OrdinatesSolution solution = solve_ordinates({world, 0}, settings);
    const Ray ray{Vec3d(8, -5, 8), Vec3d(0, 1, 0)};
    Incoming in;
    solution.radiance({&ray, 1}, {&in, 1});
    CHECK(in.direct == 3);
    CHECK(in.transmission == 1);
    CHECK(solution.fluence_at(Vec3d(1, 2, 3)).value == Approx(12 * kPi).epsilon(1e-12));
  }
}

TEST_CASE("the grid has whole voxels in its cells where it can, and reproduces them", "[ordinates][grid]") {
  CloudWish wish;
  wish.voxels = Vec3i(40, 20, 10);
  wish.extinction = 2;
  wish.albedo = 0.25;
  wish.source = 3;
  wish.density = [](const Vec3i& v) { return voxel_noise(3, Vec3i(v.x / 2, v.y / 2, v.z / 2)); };
  const World world = cube(wish, 0);
  const OrdinatesGrid grid({world, 0}, Vec3i(0), std::nullopt);
  CHECK(grid.cells() == Vec3i(20, 10, 5));
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    const double extinction = 2 * static_cast<double>(static_cast<float>(voxel_noise(3, grid.cell_at(cell))));
    REQUIRE(grid.extinction[cell] == Approx(extinction).epsilon(1e-12));
    REQUIRE(grid.scattering[cell] == Approx(0.25 * extinction).epsilon(1e-12));
    REQUIRE(grid.emission[cell] == Approx(0.75 * 3 * extinction).epsilon(1e-12));
  }
}

TEST_CASE("too much memory and what cannot be solved are refused by name", "[ordinates][errors]") {
  CloudWish wish;
  OrdinatesSettings settings;
  settings.cells = Vec3i(64);
  settings.memory_MiB = 10;
  CHECK_THROWS_AS(solve_ordinates({cube(wish, 1), 0}, settings), ResourceError);
  settings = {};
  settings.order = 5;
  CHECK_THROWS_AS(solve_ordinates({cube(wish, 1), 0}, settings), InputError);
  WorldContents contents = grey_contents(wish, 1);
  contents.sources.push_back({Vec3d(30, 0, 0), 1, {1.0}});
  const World world(std::move(contents));
  CHECK_THROWS_AS(solve_ordinates({world, 0}, {}), NumericalError);
  for (const double emissivity : {1.0, 0.5}) {
    WorldContents lit = grey_contents(wish, 1);
    lit.beams.push_back({Vec3d(8, 8, 20), Vec3d(0, 0, -1), 1, {1.0}});
    lit.materials.emplace_back().emissivity = {emissivity};
    lit.objects.push_back(grey_object(parallelogram(Vec3d(0, 0, 8), Vec3d(16, 0, 0), Vec3d(0, 16, 0)), 0, 0));
    const World on_plate(std::move(lit));
    settings = {};
    settings.cells = Vec3i(4);
    if (emissivity < 1) {
      CHECK_THROWS_AS(solve_ordinates({on_plate, 0}, settings), NumericalError);
    } else {
      CHECK_NOTHROW(solve_ordinates({on_plate, 0}, settings));
    }
  }
}
