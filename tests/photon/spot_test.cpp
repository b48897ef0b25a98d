// The spot's query against dense rays: it must never call simple what rays see as complex.
#include "photon/spot.h"

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
  auto mesh = std::make_shared<Mesh>();
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i) {
      const double x = 2.0 * i / n - 1, y = 2.0 * j / n - 1;
      mesh->vertices.push_back({size * x, size * y, height * std::sin(waves * x + 1) * std::cos(1.3 * waves * y)});
    }
  }
  const auto at = [n](std::uint32_t i, std::uint32_t j) { return j * (n + 1) + i; };
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      mesh->faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh->faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
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
Tally compare(const World& world, const SpotThresholds& thresholds, const Vec3d& target, double size, double distance, double widest,
              int spots, int side, std::uint64_t seed) {
  SpotQuery query(world, thresholds, 0);
  Stream random(seed, 0, 0);
  Tally tally;
  for (int i = 0; i < spots; ++i) {
    const Vec3d aim = target + size * Vec3d(2 * random.uniform() - 1, 2 * random.uniform() - 1, 0.2 * random.uniform() - 0.1);
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
    std::shared_ptr<Mesh> small = i % 4 < 2 ? triangle(p, p + at * Vec3d(size, 0, 0), p + at * Vec3d(0, size, 0))
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

TEST_CASE("no spot that rays see as complex is called simple: hills", "[photon][spot]") {
  const World world = world_of({plain(hills(60, 1, 0.1, 7), 0, 300), plain(box_mesh({-0.2, -0.2, 0}, {0.1, 0.1, 0.4}, false), 1, 300)});
  const Tally tally = compare(world, {}, {0, 0, 0}, 1, 3, 0.1, 1500, 24, 7);
  CHECK(tally.missed == 0);
  CAPTURE(tally.simple, tally.plain, tally.needless);
  CHECK(tally.simple > 100);
  WARN("simple " << tally.simple << " plain " << tally.plain << " needless " << tally.needless);
}
