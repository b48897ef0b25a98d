// Photons from beyond: sun and sky over bounds, over a periodic cell and over a small cloud on huge terrain.
#include <catch2/catch.hpp>

#include "photon/trace/emission.h"
#include "tests/photon/trace/emit_many.h"
#include "tests/support/agree.h"
#include "tests/support/chi_square.h"
#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

World empty_world(double sky, std::optional<Sun> sun) {
  CloudWish wish;
  wish.voxels = {8, 16, 8};
  wish.extinction = 1e-9;
  wish.corner_m = {1, 2, 3};
  WorldContents contents = grey_contents(wish, sky);
  contents.sun = sun;
  return World(std::move(contents));
}

/// Where the photon's ray enters the sphere of radius r about the middle: t, or infinity.
double entry(const EmittedPhoton& photon, const Vec3d& middle, double r) {
  const Vec3d o = photon.position - middle;
  const double b = -o.dot(photon.direction);
  const double disc = r * r - (o + b * photon.direction).length2();
  return disc > 0 ? b - std::sqrt(disc) : kInfinity;
}

}  // namespace

TEST_CASE("the sun fills a disc over the bounds with its irradiance", "[photon][emission]") {
  const Vec3d toward = Vec3d(1, -2, 2).normalized();
  const World world = empty_world(0, Sun{toward, {5}, 0.1});
  const PhotonEmitter emitter({world, 0});
  const double radius = 0.5 * std::sqrt(8.0 * 8 + 16 * 16 + 8 * 8);
  CHECK(emitter.power() == Approx(5 * kPi * radius * radius));
  std::vector<double> rings(10), off(10);
  const Vec3d middle(5, 10, 7);
  double inner = 0;
  emit_many(emitter, kPhotons, [&](const EmittedPhoton& photon) {
    const double cosine = -photon.direction.dot(toward);
    const double versine = 2 * std::pow(std::sin(0.025), 2);
    REQUIRE(1 - cosine <= versine * (1 + 1e-9));
    ++off[std::min<std::size_t>(9, static_cast<std::size_t>(10 * (1 - cosine) / versine))];
    // About the middle, at right angles to its own direction.
    const Vec3d o = photon.position - middle;
    const Vec3d across = o - o.dot(photon.direction) * photon.direction;
    ++rings[std::min<std::size_t>(9, static_cast<std::size_t>(10 * across.length2() / (radius * radius)))];
    inner += entry(photon, middle, 0.5 * radius) < kInfinity ? photon.power / kPhotons : 0.0;
    CHECK(photon.in_direct_set);
    CHECK(o.dot(photon.direction) < 0);
  });
  CHECK(chi_square(rings, std::vector<double>(10, kPhotons / 10.0)));
  CHECK(chi_square(off, std::vector<double>(10, kPhotons / 10.0)));
  CHECK(inner == Approx(5 * kPi * 0.25 * radius * radius).epsilon(0.02));
}

TEST_CASE("the sky sends pi L through every surface, at every angle", "[photon][emission]") {
  const World world = empty_world(0.7, {});
  const PhotonEmitter emitter({world, 0});
  const double radius = 0.5 * std::sqrt(8.0 * 8 + 16 * 16 + 8 * 8);
  CHECK(emitter.power() == Approx(4 * kPi * kPi * 0.7 * radius * radius));
  // What enters a smaller sphere, anywhere inside the bounds, is uniform over it and Lambertian.
  const Vec3d middle(6, 9, 8);
  const double r = 3;
  double entered = 0;
  int count = 0;
  std::vector<Vec3d> normals;
  std::vector<double> cosines(10);
  const Moments power = emit_many(emitter, kPhotons, [&](const EmittedPhoton& photon) {
    const double t = entry(photon, middle, r);
    CHECK(photon.in_direct_set);
    if (t == kInfinity) return;
    REQUIRE(t > 0);
    entered += photon.power / kPhotons;
    ++count;
    const Vec3d normal = (photon.position + t * photon.direction - middle) / r;
    normals.push_back(normal);
    const double cosine = -normal.dot(photon.direction);
    ++cosines[std::min<std::size_t>(9, static_cast<std::size_t>(10 * cosine * cosine))];
  });
  CHECK(power.mean() == Approx(emitter.power()));
  CHECK(entered == Approx(kPi * 0.7 * 4 * kPi * r * r).epsilon(0.03));
  CHECK(chi_square(cosines, std::vector<double>(10, count / 10.0)));
  std::size_t next = 0;
  CHECK(chi_square_directions([&] { return normals[next++]; }, [](const Vec3d&) { return 1 / (4 * kPi); }, count));
}

TEST_CASE("a periodic cell is lit through its upper and lower faces alone", "[photon][emission]") {
  CloudWish wish;
  wish.voxels = {8, 8, 4};
  wish.extinction = 1e-3;
  wish.period_m = {10, 12};
  WorldContents contents = grey_contents(wish, 0.7);
  const Affine place = placement({3, 1, 2}, {0, 0, 0.5}, 2);
  contents.clouds[0].local_to_world = place;
  const double zenith = 0.8;
  contents.sun = Sun{Vec3d(std::sin(zenith), 0, std::cos(zenith)), {5}, 0.05};
  const World world(std::move(contents));
  SourceSelection only_sun;
  only_sun.sky = false;
  const PhotonEmitter sun({world, 0}, only_sun);
  CHECK(sun.power() == Approx(5 * std::cos(zenith) * 20 * 24));
  std::vector<double> cells(8 * 8);
  const auto place_in_face = [&](const EmittedPhoton& photon) {
    const Vec3d local = transform_point(world.frame(0).world_to_local, photon.position);
    REQUIRE((local.x >= 0 && local.x <= 10 && local.y >= 0 && local.y <= 12));
    ++cells[std::min<std::size_t>(7, static_cast<std::size_t>(local.x * 0.8)) +
            8 * std::min<std::size_t>(7, static_cast<std::size_t>(local.y * 8 / 12))];
    return local.z;
  };
  Moments power = emit_many(sun, kPhotons, [&](const EmittedPhoton& photon) {
    CHECK(place_in_face(photon) == Approx(4));
    CHECK(photon.direction.z < 0);
  });
  CHECK(chi_square(cells, std::vector<double>(64, kPhotons / 64.0)));
  CHECK(power.mean() == Approx(sun.power()).epsilon(1e-3));  // the disc is as bright as its middle
  SourceSelection only_sky;
  only_sky.sun = false;
  const PhotonEmitter sky({world, 0}, only_sky);
  CHECK(sky.power() == Approx(kPi * 0.7 * 2 * 20 * 24));
  cells.assign(64, 0);
  double upper = 0;
  std::vector<double> cosines(10);
  power = emit_many(sky, kPhotons, [&](const EmittedPhoton& photon) {
    const bool top = place_in_face(photon) > 2;
    upper += top ? 1 : 0;
    CHECK((photon.direction.z < 0) == top);
    ++cosines[std::min<std::size_t>(9, static_cast<std::size_t>(10 * photon.direction.z * photon.direction.z))];
  });
  CHECK(chi_square({upper, kPhotons - upper}, {kPhotons / 2.0, kPhotons / 2.0}));
  CHECK(chi_square(cosines, std::vector<double>(10, kPhotons / 10.0)));
  CHECK(chi_square(cells, std::vector<double>(64, kPhotons / 64.0)));
  CHECK(power.mean() == Approx(sky.power()));
}

TEST_CASE("a small cloud over huge terrain gets what the plain disc would send it", "[photon][emission][surfaces]") {
  CloudWish puff;
  puff.voxels = Vec3i(8);
  puff.voxel_m = 0.25;
  puff.corner_m = {10, 5, 2};
  WorldContents contents = grey_contents(puff, 0.7);
  contents.materials = {grey_material(1)};
  contents.objects = {grey_object(parallelogram({-50, -50, 0}, {100, 0, 0}, {0, 100, 0}), 0, 0)};
  const Vec3d toward = Vec3d(1, -2, 2).normalized();
  contents.sun = Sun{toward, {5}, 0.1};
  const World world(contents);
  const double radius = 0.5 * world.bounds().size().length();
  REQUIRE(radius > 70);
  struct Ball {
    Vec3d middle;
    double r;
    double resolution;
  };
  constexpr int kMany = 2000000;
  // The puff, something that the narrow disc only cuts, and something far from it.
  const Ball balls[] = {{{11, 6, 3}, 1, 0.03}, {{15, 6, 3}, 10, 0.1}, {{-20, 10, 3}, 15, 0.1}};
  for (const bool sun : {true, false}) {
    SourceSelection one{};
    one.sun = sun;
    one.sky = !sun;
    const PhotonEmitter emitter({world, 0}, one);
    const double whole = sun ? 5 * kPi * radius * radius : 4 * kPi * kPi * 0.7 * radius * radius;
    CHECK(emitter.power() == Approx(whole).epsilon(1e-9));
    std::array<Moments, 3> into;
    int near = 0, beyond = 0;
    const Moments power = emit_many(emitter, kMany, [&](const EmittedPhoton& photon) {
      for (std::size_t b = 0; b < 3; ++b) {
        const double t = entry(photon, balls[b].middle, balls[b].r);
        into[b].add(t < kInfinity ? photon.power : 0.0);
        near += b == 0 && t < kInfinity;
      }
      // It starts outside of everything.
      beyond += (photon.position - world.bounds().center()).length() >= radius * (1 - 1e-9) && photon.from_beyond;
    });
    CHECK(beyond == kMany);
    CHECK(agree(power.mean(), power.standard_error(), whole, {.resolution = 0.05, .comparisons = 8}));
    for (std::size_t b = 0; b < 3; ++b) {
      INFO((sun ? "sun" : "sky") << ", ball " << b);
      const double expected = (sun ? 5 : 4 * kPi * 0.7) * kPi * balls[b].r * balls[b].r;
      CHECK(agree(into[b].mean(), into[b].standard_error(), expected,
                  {.resolution = balls[b].resolution, .comparisons = 8}));
    }
    // The plain disc would have sent it one in five thousand.
    CHECK(near > kMany / 20);
  }
}
