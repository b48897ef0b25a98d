// The spot's query against dense rays: it must never call simple what rays see as complex.
#include "photon/spot/spot.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <catch2/catch.hpp>

#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/spots.h"
#include "tests/support/voxel_fields.h"

using namespace obscura;
using namespace obscura::test;

namespace {

World world_of(std::vector<Object> objects, int materials = 3) {
  WorldContents contents = empty_contents();
  contents.materials.clear();
  for (int i = 0; i < materials; ++i) contents.materials.push_back(grey_material(0.9));
  contents.objects = std::move(objects);
  return World(std::move(contents));
}

Object plain(std::shared_ptr<const Mesh> mesh, int material = 0, double K = 0) {
  Object object;
  object.mesh = std::move(mesh);
  object.materials = {material};
  object.K = {K};
  return object;
}

/// Hills over [-1, 1]^2 times size as 2 n n triangles.
std::shared_ptr<Mesh> hills(std::uint32_t n, double size, double height, double waves) {
  return sheet_mesh(n, [=](std::uint32_t i, std::uint32_t j) {
    const double x = 2.0 * i / n - 1, y = 2.0 * j / n - 1;
    return Vec3d(size * x, size * y, height * std::sin(waves * x + 1) * std::cos(1.3 * waves * y));
  });
}

std::shared_ptr<Mesh> triangle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {a, b, c};
  mesh->faces = {{0, 1, 2}};
  return mesh;
}

struct Tally {
  int spots = 0, missed = 0, simple = 0, needless = 0, plain = 0;
};

/// Random spots towards `target`; `missed` counts those called simple in which rays see more.
Tally compare(const World& world, const SpotThresholds& thresholds, const Vec3d& target, double size, double distance,
              double widest, int spots, int side, std::uint64_t seed) {
  SpotQuery query(world, thresholds, 0);
  Stream random(seed, 0, 0);
  Tally tally;
  for (int i = 0; i < spots; ++i) {
    const Vec3d aim =
        target + size * Vec3d(2 * random.uniform() - 1, 2 * random.uniform() - 1, 0.2 * random.uniform() - 0.1);
    Vec3d from = random_direction(random);
    from.z = std::abs(from.z);
    const double half = widest * std::pow(10, -3 * random.uniform());
    const bool parallel = i % 4 == 3;
    Spot spot;
    if (parallel) {
      const auto [a, b] = orthonormal_basis(-from);
      spot = parallel_spot(aim + distance * from, -from, distance * half * a, distance * half * random.uniform() * b);
    } else {
      spot = pinhole_spot(aim + distance * from, -from, half, half * (0.1 + 0.9 * random.uniform()), random.uniform());
    }
    const Criterion found = query(spot);
    const Views views = look_through(world, spot, side);
    const bool complex = views.reaches(thresholds);
    ++tally.spots;
    tally.simple += found == Criterion::none;
    tally.plain += !complex;
    tally.missed += found == Criterion::none && complex;
    tally.needless += found != Criterion::none && !complex;
  }
  return tally;
}

}  // namespace

TEST_CASE("one plane fills a spot: simple; its border does not", "[photon][spot]") {
  const World world = world_of({plain(parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}))});
  SpotQuery query(world, {}, 0);
  CHECK(query(pinhole_spot({0, 0, 5}, {0.01, 0.003, -1}, 0.01, 0.01)) == Criterion::none);
  CHECK(query(pinhole_spot({0, 0, 5}, {0, 0, -1}, 0.1, 0.1)) == Criterion::none);
  CHECK(query(pinhole_spot({0, 0, 5}, {0.2, 0, -1}, 0.01, 0.01)) == Criterion::polygons);
  CHECK(query(pinhole_spot({0, 0, 5}, {0.195, 0, -1}, 0.01, 0.01)) == Criterion::polygons);
  CHECK(query(pinhole_spot({0, 0, 5}, {0.5, 0, -1}, 0.01, 0.01)) == Criterion::none);
  CHECK(query(pinhole_spot({0, 0, 5}, {0, 0, 1}, 0.01, 0.01)) == Criterion::none);
  CHECK(query(parallel_spot({0.3, 0.2, 5}, {0, 0, -1}, {0.1, 0, 0}, {0, 0.1, 0})) == Criterion::none);
  CHECK(query(parallel_spot({0.95, 0.2, 5}, {0, 0, -1}, {0.1, 0, 0}, {0, 0.1, 0})) == Criterion::polygons);
  SpotThresholds strict;
  strict.polygons_strict = 2;
  CHECK(SpotQuery(world, strict, 0)(pinhole_spot({0, 0, 5}, {0, 0, -1}, 0.1, 0.1)) == Criterion::polygons);
}

TEST_CASE("what is tiny or thin is found wherever it is in the spot, and not where it is hidden", "[photon][spot]") {
  Stream random(3, 0, 0);
  for (int i = 0; i < 200; ++i) {
    INFO(i);
    const double half = 0.05;
    const double x = 0.9 * (2 * random.uniform() - 1) * half, y = 0.9 * (2 * random.uniform() - 1) * half;
    const double size = 2 * half * 1e-3;  // 1e-6 of the area
    const double z = 0.2 + 0.6 * random.uniform();
    const bool behind = i % 2 == 1;
    const double at = behind ? 1 + z : z;
    const Vec3d p(at * x, at * y, -at);
    std::shared_ptr<Mesh> small =
        i % 4 < 2 ? triangle(p, p + at * Vec3d(size, 0, 0), p + at * Vec3d(0, size, 0))
                  : triangle(p - Vec3d(1, 0.3, 0), p + Vec3d(1, 0.3, 0), p + Vec3d(1, 0.3 + 1e-4 * 2 * half, 0));
    std::vector<Object> objects{plain(parallelogram({-2, -2, -1}, {4, 0, 0}, {0, 4, 0})), plain(small)};
    if (i % 3 == 0) std::swap(objects[0], objects[1]);
    const World world = world_of(std::move(objects));
    SpotThresholds thresholds;
    thresholds.depth.reset();
    SpotQuery query(world, thresholds, 0);
    const Criterion found = query(pinhole_spot({0, 0, 0}, {0, 0, -1}, half, half));
    CHECK(found == (behind ? Criterion::none : Criterion::polygons));
  }
}

TEST_CASE("no spot that rays see as complex is called simple", "[photon][spot]") {
  SECTION("hills and a box") {
    const World world = world_of(
        {plain(hills(60, 1, 0.1, 7), 0, 300), plain(box_mesh({-0.2, -0.2, 0}, {0.1, 0.1, 0.4}, false), 1, 300)});
    const Tally tally = compare(world, {}, {0, 0, 0}, 1, 3, 0.1, 1200, 16, 7);
    CHECK(tally.missed == 0);
    CHECK(tally.simple > 300);
    CHECK(tally.needless < 0.02 * tally.plain);
  }
  SECTION("the same, each threshold for itself") {
    const auto mesh = hills(60, 1, 0.1, 7);
    for (std::size_t i = 0; i < mesh->vertices.size(); ++i)
      mesh->vertex_K.push_back(static_cast<float>(300 + 4 * mesh->vertices[i].x));
    const World world =
        world_of({plain(mesh, 0, 300), plain(box_mesh({-0.2, -0.2, 0}, {0.1, 0.1, 0.4}, false), 1, 301)});
    for (int which = 0; which < 5; ++which) {
      SpotThresholds only{std::nullopt, std::nullopt, std::nullopt, std::nullopt,
                          std::nullopt, std::nullopt, std::nullopt};
      if (which == 0) only.polygons = 3;
      if (which == 1) only.materials = 3;
      if (which == 2) only.normal = 0.3;
      if (which == 3) only.depth = 0.02;
      if (which == 4) only.temperature_K = 0.25;
      const Tally tally = compare(world, only, {0, 0, 0}, 1, 3, 0.1, 300, 16, 8 + static_cast<std::uint64_t>(which));
      CAPTURE(which, tally.simple, tally.plain, tally.needless);
      CHECK(tally.missed == 0);
      CHECK(tally.simple > 75);
      CHECK(tally.needless < 0.2 * tally.plain);
    }
  }
  SECTION("loose triangles of all sizes") {
    Stream random(11, 0, 0);
    auto mesh = std::make_shared<Mesh>();
    for (std::uint32_t i = 0; i < 300; ++i) {
      const double size = std::pow(10, -3 * random.uniform());
      const Vec3d at(2 * random.uniform() - 1, 2 * random.uniform() - 1, random.uniform());
      for (int c = 0; c < 3; ++c) mesh->vertices.push_back(at + size * random_direction(random));
      mesh->faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    Object turned = plain(mesh, 1, 300);
    turned.local_to_world = placement({0.1, 0.2, 0.3}, {0.5, 1.1, 2}, 0.7);
    const World world =
        world_of({plain(mesh, 0, 300), turned, plain(parallelogram({-9, -9, -1}, {18, 0, 0}, {0, 18, 0}), 2, 300)});
    const Tally tally = compare(world, {}, {0, 0, 0}, 1, 3, 0.03, 1500, 16, 12);
    CHECK(tally.missed == 0);
    CHECK(tally.simple > 100);
    CHECK(tally.needless < 0.05 * tally.plain);
  }
  SECTION("spheres, hot ones among them") {
    Stream random(13, 0, 0);
    WorldContents contents = empty_contents();
    contents.materials = {grey_material(0.9), grey_material(0.5)};
    for (int i = 0; i < 30; ++i) {
      const Vec3d at(2 * random.uniform() - 1, 2 * random.uniform() - 1, random.uniform());
      const double radius = 0.5 * std::pow(10, -2 * random.uniform());
      if (i % 2)
        contents.sources.push_back({at, radius, {1}});
      else
        contents.objects.push_back(grey_sphere(at, radius, i % 4 / 2, 1));
    }
    const World world(std::move(contents));
    SpotThresholds thresholds;
    thresholds.normal = 0.5;
    thresholds.depth = 0.2;
    thresholds.temperature_K.reset();
    const Tally tally = compare(world, thresholds, {0, 0, 0}, 1, 3, 0.1, 1500, 16, 14);
    CHECK(tally.missed == 0);
    CHECK(tally.simple > 300);
    CHECK(tally.needless < 0.08 * tally.plain);
  }
  SECTION("ten thousand kilometres from the origin") {
    const Vec3d there(1e7, -2e7, 3e6);
    Object ground = plain(hills(40, 1, 0.1, 7), 0, 300),
           box = plain(box_mesh({-0.2, -0.2, 0}, {0.1, 0.1, 0.4}, false), 1, 300);
    ground.local_to_world = placement(there, {0, 0, 0.3}, 100);
    box.local_to_world = placement(there, {0.1, 0.2, 0.3}, 100);
    const World world = world_of({ground, box});
    const Tally tally = compare(world, {}, there, 100, 300, 0.1, 800, 16, 15);
    CHECK(tally.missed == 0);
    CHECK(tally.simple > 200);
    CHECK(tally.needless < 0.02 * tally.plain);
  }
}

TEST_CASE("a vehicle behind a hill is not counted, nor is what a sphere hides", "[photon][spot]") {
  const auto wall = parallelogram({-1, 0, -1}, {2, 0, 0}, {0, 0, 2});
  const auto car = box_mesh({-0.1, 0.5, -0.1}, {0.1, 0.7, 0.1}, false);
  const World world = world_of({plain(car, 1), plain(wall, 0)});
  SpotQuery query(world, {}, 0);
  CHECK(query(pinhole_spot({0, -5, 0}, {0, 1, 0}, 0.05, 0.05)) == Criterion::none);
  CHECK(query(pinhole_spot({0, 5, 0}, {0, -1, 0}, 0.05, 0.05)) != Criterion::none);
  // Beside it in depth, but buried: the ground reaches from 10 to 60 m, the object lies between.
  const World buried = world_of({plain(box_mesh({-1, 30, -0.2}, {1, 32, -0.1}, false), 1),
                                 plain(parallelogram({-99, 0, 0}, {200, 0, 0}, {0, 300, 0}))});
  SpotThresholds far;
  far.depth.reset();
  CHECK(SpotQuery(buried, far, 0)(pinhole_spot({0, 0, 1}, {0, 31, -1}, 0.01, 0.012)) == Criterion::none);
  const World lying = world_of({plain(box_mesh({-1, 30, -0.2}, {1, 32, 0.001}, false), 1),
                                plain(parallelogram({-99, 0, 0}, {200, 0, 0}, {0, 300, 0}))});
  CHECK(SpotQuery(lying, far, 0)(pinhole_spot({0, 0, 1}, {0, 31, -1}, 0.01, 0.012)) != Criterion::none);

  // Under one slope of a valley, higher than its bottom.
  auto valley = std::make_shared<Mesh>();
  valley->vertices = {{-9, -9, 4.5}, {0, -9, 0}, {9, -9, 4.5}, {-9, 9, 4.5}, {0, 9, 0}, {9, 9, 4.5}};
  valley->faces = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
  for (const double z : {0.25, 0.55}) {
    const World world_below = world_of({plain(valley), plain(triangle({-1, 0.1, z}, {-0.9, 0.1, z}, {-1, 0.2, z}), 1)});
    SpotThresholds steep = far;
    steep.normal.reset();
    CHECK(SpotQuery(world_below, steep, 0)(pinhole_spot({0.01, 0.02, 10}, {0, 0, -1}, 0.2, 0.2)) ==
          (z < 0.5 ? Criterion::none : Criterion::polygons));
  }

  WorldContents contents = empty_contents();
  contents.materials = {grey_material(0.9)};
  contents.objects = {grey_sphere({0, 0, 0}, 1, 0, 1), grey_sphere({0, 3, 0}, 0.2, 0, 1)};
  const World spheres(std::move(contents));
  SpotThresholds round;
  round.normal = 0.5;
  SpotQuery ask(spheres, round, 0);
  CHECK(ask(pinhole_spot({0, -5, 0}, {0, 1, 0}, 0.01, 0.01)) == Criterion::none);
  CHECK(ask(pinhole_spot({0, -5, 0}, {0, 1, 0}, 0.1, 0.1)) == Criterion::normal);
  CHECK(ask(pinhole_spot({0, -5, 0}, {0.204, 1, 0}, 0.01, 0.01)) != Criterion::none);
  CHECK(ask(pinhole_spot({0, 8, 0}, {0, -1, 0}, 0.001, 0.001)) == Criterion::none);
}

TEST_CASE("mirrors are looked into, each bounce up to the specular depth", "[photon][spot]") {
  WorldContents contents = empty_contents();
  contents.materials = {grey_material(0.1, 1), grey_material(0.9), grey_material(0.1, 1, 0.1)};
  // A mirror on the ground, a wire in front of the sky above it; a wall of mirror beyond.
  contents.objects = {plain(parallelogram({-5, -5, 0}, {10, 0, 0}, {0, 10, 0}), 0),
                      plain(triangle({-3, 2, 1}, {3, 2, 1}, {3, 2, 1.0001}), 1)};
  const auto ask = [&](const Vec3d& eye, const Vec3d& toward, int depth) {
    const World world(contents);
    return SpotQuery(world, {}, depth)(pinhole_spot(eye, toward, 0.02, 0.002));
  };
  const Vec3d eye(0, -2, 1), image(0, 2, -1);
  CHECK(ask(eye, image - eye, 0) == Criterion::none);
  CHECK(ask(eye, image - eye, 1) == Criterion::reflection);
  CHECK(ask(eye, image + Vec3d(0, 0, 0.05) - eye, 1) == Criterion::none);
  contents.objects[0].materials = {2};  // rough
  CHECK(ask(eye, image - eye, 1) == Criterion::none);
  contents.objects[0].materials = {0};

  // The second bounce, at a wall that faces the eye: seen through both.
  contents.objects.push_back(plain(parallelogram({-5, 4, 0}, {10, 0, 0}, {0, 0, 9}), 0));
  contents.objects[1].mesh = triangle({-3, -3, 3.5}, {3, -3, 3.5}, {3, -3, 3.5001});
  // From the eye to the ground at y = 0, up to the wall at (4, 2), back to y = -3 at z = 5.5 / 2 ...
  const Vec3d from(0, -2, 1), at(0, 0, 0);
  const double z = 4 * 0.5 + 7 * 0.5;
  contents.objects[1].mesh = triangle({-3, -3, z}, {3, -3, z}, {3, -3, z + 1e-4});
  CHECK(ask(from, at - from, 1) == Criterion::none);
  CHECK(ask(from, at - from, 2) == Criterion::reflection);

  // A ball of mirror: what stands beside the eye is seen in it.
  contents.objects = {grey_sphere({0, 0, 0}, 1, 0, 1),
                      plain(triangle({0.3, -6, 1}, {0.32, -6, 1}, {0.3, -6, 1.02}), 1)};
  SpotThresholds wide;
  wide.normal = 0.3;
  const World round(contents);
  int found = 0;
  for (int i = 0; i < 400; ++i) {
    // Spots over the face of the ball; only the one whose reflections meet the triangle is refined.
    const Vec3d toward(0.002 * (i % 20), 5, 0.01 * (i / 20));
    const Spot spot = pinhole_spot({0, -5, 0}, toward, 0.0002, 0.001);
    const Criterion answer = SpotQuery(round, wide, 1)(spot);
    bool seen = false;
    for (int k = 0; k < 256; ++k) {
      const Ray ray = ray_in(spot, (k % 16) / 15.0, (k / 16) / 15.0);
      const SurfaceHit hit = round.surfaces().intersect(ray);
      if (hit.id.surface != 0) continue;
      const Vec3d n = round.surfaces().normal(hit.id, ray.at(hit.t));
      seen =
          seen || round.surfaces()
                      .intersect({ray.at(hit.t), ray.direction - 2 * ray.direction.dot(n) * n, 1e-9, kInfinity}, hit.id)
                      .exists();
    }
    if (seen) CHECK(answer == Criterion::reflection);
    found += answer == Criterion::reflection;
  }
  CHECK(found > 0);
  CHECK(found < 40);
}

TEST_CASE("unwelded meshes cover; folds, gaps, nets and backs count", "[photon][spot]") {
  // Every triangle with vertices of its own.
  const auto welded = hills(20, 1, 0.0, 1);
  auto loose = std::make_shared<Mesh>();
  for (const auto& face : welded->faces) {
    const auto first = static_cast<std::uint32_t>(loose->vertices.size());
    for (const std::uint32_t v : face) loose->vertices.push_back(welded->vertices[v]);
    loose->faces.push_back({first, first + 1, first + 2});
  }
  const Spot spot = pinhole_spot({0.01, 0.02, 2}, {0, 0, -1}, 0.2, 0.2);
  CHECK(SpotQuery(world_of({plain(loose)}), {}, 0)(spot) == Criterion::none);
  auto torn = std::make_shared<Mesh>(*loose);
  torn->vertices[3 * 421].z += 1e-4;
  CHECK(SpotQuery(world_of({plain(torn)}), {}, 0)(spot) == Criterion::polygons);

  WorldContents contents = empty_contents();
  contents.materials = {grey_material(0.9), grey_material(0.9)};
  contents.materials[1].permeable = 0.5;
  contents.objects = {plain(loose), plain(parallelogram({-9, -9, 1}, {18, 0, 0}, {0, 18, 0}), 1)};
  CHECK(SpotQuery(World(contents), {}, 0)(spot) == Criterion::polygons);
  // One face of the net in front of all of the spot.
  contents.objects[1].mesh = triangle({-99, -99, 1}, {99, -99, 1}, {0, 99, 1});
  CHECK(SpotQuery(World(contents), {}, 0)(spot) == Criterion::polygons);
  contents.objects[1].local_to_world = placement({0, 0, -2}, Vec3d(0), 1);
  CHECK(SpotQuery(World(contents), {}, 0)(spot) == Criterion::none);

  // From below: its back, alone. Half of the faces turned: two sides.
  CHECK(SpotQuery(world_of({plain(loose)}), {}, 0)(pinhole_spot({0, 0, -2}, {0, 0, 1}, 0.2, 0.2)) == Criterion::none);
  auto turned = std::make_shared<Mesh>(*loose);
  std::swap(turned->faces[421][0], turned->faces[421][1]);
  CHECK(SpotQuery(world_of({plain(turned)}), {}, 0)(spot) == Criterion::polygons);
  Object both = plain(turned);
  both.double_sided = true;
  CHECK(SpotQuery(world_of({both}), {}, 0)(spot) == Criterion::none);
}

TEST_CASE("thresholds of none and one, emissivities and discs", "[photon][spot]") {
  const World empty = world_of({});
  const Spot up = pinhole_spot({0, 0, 2}, {0, 0, 1}, 0.02, 0.02),
             down = pinhole_spot({0, 0, 2}, {0, 0, -1}, 0.02, 0.02);
  const World world = world_of({plain(parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}))});
  SpotThresholds thresholds;
  CHECK(SpotQuery(empty, thresholds, 4)(up) == Criterion::none);
  thresholds.polygons = 0;
  CHECK(SpotQuery(empty, thresholds, 0)(up) == Criterion::polygons);
  thresholds.polygons = 1;
  CHECK(SpotQuery(world, thresholds, 0)(up) == Criterion::none);
  CHECK(SpotQuery(world, thresholds, 0)(down) == Criterion::polygons);
  thresholds.polygons.reset();
  thresholds.materials = 1;
  CHECK(SpotQuery(world, thresholds, 0)(down) == Criterion::materials);

  WorldContents contents = empty_contents();
  contents.materials = {grey_material(0.9)};
  contents.materials[0].angle_deg = {0, 60, 90};
  contents.materials[0].angle_factor = {1, 0.8, 0.1};
  contents.objects = {plain(parallelogram({-9, -9, 0}, {18, 0, 0}, {0, 18, 0}))};
  contents.sun = Sun{Vec3d(0, 0, 1), {1000}, 0.009};
  SpotThresholds angles;
  angles.depth.reset();
  CHECK(SpotQuery(World(contents), angles, 0)(pinhole_spot({0, 0, 2}, {0, 0, -1}, 0.02, 0.02)) == Criterion::none);
  CHECK(SpotQuery(World(contents), angles, 0)(pinhole_spot({0, 0, 2}, {0, 3, -1}, 0.05, 0.05)) ==
        Criterion::emissivity);
  CHECK(SpotQuery(World(contents), {}, 0)(up) == Criterion::polygons);  // the sun's disc
  CHECK(SpotQuery(World(contents), {}, 0)(pinhole_spot({0, 0, 2}, {0, 0, 1}, 0.001, 0.001)) == Criterion::none);
  CHECK(SpotQuery(World(contents), {}, 0)(pinhole_spot({0, 0, 2}, {0.1, 0, 1}, 0.02, 0.02)) == Criterion::none);
}

TEST_CASE("any number of threads gives the same answers", "[photon][spot]") {
  const World world = world_of(
      {plain(hills(200, 1, 0.1, 7), 0, 300), plain(box_mesh({-0.2, -0.2, 0}, {0.1, 0.1, 0.4}, false), 1, 300)});
  constexpr std::size_t kSpots = 64 * 64;
  const auto spot = [](std::size_t i) {
    return pinhole_spot(
        {0, -3, 1.5}, {0.02 * (static_cast<double>(i % 64) - 32), 3, -1.5 + 0.02 * (static_cast<double>(i / 64) - 32)},
        0.003, 0.003);
  };
  std::vector<Criterion> one(kSpots), several(kSpots);
  // The index, too, is made by whoever comes first.
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, kSpots, 64), [&](const auto& range) {
    SpotQuery query(world, {}, 0);
    for (std::size_t i = range.begin(); i != range.end(); ++i) several[i] = query(spot(i));
  });
  SpotQuery query(world, {}, 0);
  for (std::size_t i = 0; i < kSpots; ++i) one[i] = query(spot(i));
  CHECK(one == several);
  CHECK(std::count(one.begin(), one.end(), Criterion::none) > 100);
}
