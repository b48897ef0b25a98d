// Discrete ordinates among surfaces: furnaces, floors under a sun and warm plates.
#include <catch2/catch.hpp>

#include "photon/ordinates/ordinates.h"
#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

TEST_CASE("in a furnace surfaces are black too, whatever they reflect", "[ordinates][surfaces]") {
  WorldContents contents = grey_contents(rough_wish(0.6, 0.4, 2), 2);
  contents.materials.push_back(grey_material(0.3));
  contents.objects.push_back(grey_object(box_mesh(Vec3d(0.8, 0.8, 1.2), Vec3d(2.0, 1.6, 2.0), false), 0, 2));
  contents.objects.push_back(grey_object(parallelogram(Vec3d(-1, -1, 0), Vec3d(6, 0, 0), Vec3d(0, 6, 0)), 0, 2));
  contents.objects.back().double_sided = true;
  const World world(std::move(contents));
  OrdinatesSettings settings;
  settings.cells = Vec3i(8);
  settings.order = 4;
  const OrdinatesSolution solution = solve_ordinates({world, 0}, settings);
  for (const Ray& ray :
       {Ray{Vec3d(-3, 0.4, 0.3), Vec3d(0.9, 0.3, 0.2).normalized()}, Ray{Vec3d(1.5, 1.4, 5), Vec3d(0, 0, -1)},
        Ray{Vec3d(0.2, 0.2, 5), Vec3d(0.1, 0, -1).normalized()}}) {
    Incoming in;
    solution.radiance({&ray, 1}, {&in, 1});
    CHECK(in.direct == Approx(2).epsilon(1e-5));
  }
  CHECK(std::abs(solution.powers().residual()) < 1e-6);
  CHECK(solution.fluence_at(Vec3d(0.3, 0.3, 2.9)).value == Approx(8 * kPi).epsilon(1e-5));
}

TEST_CASE("a chalky floor under a sun reflects what it should, and darkens behind a box", "[ordinates][surfaces]") {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.extinction = 1e-9;
  wish.albedo = 0.5;
  WorldContents contents = grey_contents(wish);
  contents.sun = Sun{Vec3d(0.6, 0, 0.8), {10}, 0};
  contents.materials.push_back(grey_material(0.25));
  contents.objects.push_back(grey_object(parallelogram(Vec3d(-2, -2, 0), Vec3d(12, 0, 0), Vec3d(0, 12, 0)), 0, 0));
  contents.objects.push_back(grey_object(box_mesh(Vec3d(3, 3, 1), Vec3d(5, 5, 3), false), 0, 0));
  const World world(std::move(contents));
  OrdinatesSettings settings;
  settings.cells = Vec3i(8);
  const OrdinatesSolution solution = solve_ordinates({world, 0}, settings);
  const auto look_down = [&](double x, double y) {
    const Ray ray{Vec3d(x, y, 0.5), Vec3d(0, 0, -1)};
    Incoming in;
    solution.radiance({&ray, 1}, {&in, 1});
    CHECK(in.distance == Approx(0.5));
    return in.direct;
  };
  // Far from the box hardly anything but the sun; in its shadow only what the box and the floor exchange.
  CHECK(look_down(-1, -1) == Approx(0.75 * 8 / kPi).epsilon(0.02));
  CHECK(look_down(2.5, 4) < 0.3 * 0.75 * 8 / kPi);
  CHECK(std::abs(solution.powers().residual()) < 1e-3);
}

TEST_CASE("a floor gives back its share of the sun's power", "[ordinates][surfaces]") {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.extinction = 1e-9;
  WorldContents contents = grey_contents(wish);
  contents.sun = Sun{Vec3d(0.6, 0, 0.8), {10}, 0};
  contents.materials.push_back(grey_material(0.25));
  contents.objects.push_back(grey_object(parallelogram(Vec3d(0, 0, 0), Vec3d(8, 0, 0), Vec3d(0, 8, 0)), 0, 0));
  const World world(std::move(contents));
  OrdinatesSettings settings;
  settings.cells = Vec3i(4);
  const OrdinatesPowers powers = solve_ordinates({world, 0}, settings).powers();
  CHECK(powers.surfaces == Approx(0.75 * 8 * 64).epsilon(1e-6));
  double out = 0;
  for (const auto& sides : powers.left) out += sides[0] + sides[1];
  CHECK(out == Approx(0.75 * 8 * 64).epsilon(1e-6));
}

TEST_CASE("a warm plate in a cloud gives its power off to cloud and faces", "[ordinates][surfaces]") {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.extinction = 0.3;
  wish.albedo = 0.5;
  WorldContents contents = grey_contents(wish);
  contents.materials.push_back(grey_material(1));
  contents.objects.push_back(grey_object(parallelogram(Vec3d(2, 2, 4), Vec3d(4, 0, 0), Vec3d(0, 4, 0)), 0, 1));
  const World world(std::move(contents));
  OrdinatesSettings settings;
  settings.cells = Vec3i(8);
  const OrdinatesSolution solution = solve_ordinates({world, 0}, settings);
  const OrdinatesPowers& powers = solution.powers();
  double out = powers.absorbed;
  for (const auto& sides : powers.left) out += sides[0] + sides[1];
  CHECK(out == Approx(powers.surfaces).epsilon(1e-6));
  // Of pi times 16 m2 some comes back.
  CHECK(powers.surfaces < 16 * kPi);
  CHECK(powers.surfaces > 0.8 * 16 * kPi);
  // The front looks up: more leaves there.
  CHECK(powers.left[2][1] > 5 * powers.left[2][0]);
  Ray ray{Vec3d(4, 4, 10), Vec3d(0, 0, -1)};
  Incoming in;
  solution.radiance({&ray, 1}, {&in, 1});
  CHECK(in.transmission == Approx(std::exp(-0.3 * 4)));
  CHECK(in.direct > std::exp(-1.2));
  CHECK(in.direct < 1);
}
