// Direct light at points of clouds and surfaces against quadrature, and the light along a ray against a sum
// over small steps.
#include "photon/paths/direct_light.h"

#include <catch2/catch.hpp>

#include "tests/support/agree.h"
#include "tests/support/chi_square.h"
#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;
using namespace obscura::detail;

namespace {

/// What `count` askings of all sources add up to at a point, each on its own.
template <class Scatterer>
Moments asked(const World& world, const Scatterer& at, int count, const RadianceParts& parts = {}) {
  WorkCounts work;
  DirectLight light({world, 0}, parts, work);
  std::vector<Incoming> incoming(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    Stream stream(1, static_cast<std::uint64_t>(i), 1);
    light.add(static_cast<std::uint32_t>(i), 1, at, stream,
              DiscPlaces({1, static_cast<std::uint64_t>(i), Purpose::disc}));
  }
  light.arrive([&](std::uint32_t owner, double radiance) { incoming[owner].direct += radiance; });
  Moments result;
  for (const Incoming& in : incoming) result.add(in.direct);
  return result;
}

/// The side of a surface that a ray from above meets.
SurfacePoint seen(const World& world, const Vec3d& from, const Vec3d& direction) {
  const Ray ray{from, direction.normalized(), 0, kInfinity};
  const SurfaceHit hit = world.surfaces().intersect(ray);
  REQUIRE(hit.exists());
  return SpectralWorld(world, 0).surface_at(ray, hit);
}

constexpr double kHalf = 0.2;  // of the hot square
constexpr double kHot = 7;
constexpr double kEmissivity = 0.6;

/// A hot square facing down at this height over a large dark floor.
WorldContents lit_floor(double height, double half = kHalf) {
  WorldContents contents = empty_contents();
  Material angled = grey_material(kEmissivity);
  angled.angle_deg = {0, 90};
  angled.angle_factor = {1, 0.4};
  contents.materials = {angled, grey_material(0.25), grey_material(1)};
  contents.objects = {grey_object(parallelogram({-half, -half, height}, {0, 2 * half, 0}, {2 * half, 0, 0}), 0, kHot),
                      grey_object(parallelogram({-50, -50, 0}, {100, 0, 0}, {0, 100, 0}), 1, 0)};
  return contents;
}

/// Integral over the square of weight(direction towards it) e(angle) B cos / d^2, by midpoints.
template <class Weight>
double over_square(const Vec3d& from, double height, double half, Weight&& weight) {
  constexpr int kSteps = 400;
  const double side = 2 * half / kSteps;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const Vec3d way = Vec3d(-half + side * (i + 0.5), -half + side * (j + 0.5), height) - from;
      const Vec3d toward = way.normalized();
      const double cosine = toward.z;
      const double emissivity = kEmissivity * (1 - 0.6 * std::acos(cosine) / (0.5 * kPi));
      sum += weight(toward) * emissivity * kHot * cosine / way.length2() * side * side;
    }
  }
  return sum;
}

}  // namespace

TEST_CASE("a floor under a hot square is lit as the integral over the square says, near and far",
          "[photon][direct_light]") {
  const struct {
    double height, half;
    Vec3d at;
  } cases[] = {{3, kHalf, {0.3, 0.4, 0}},
               {0.1, kHalf, {0.05, 0.1, 0}},
               {0.5, 20, {3, 1, 0}},
               {0.02, 20, {-7, 5, 0}},
               {40, kHalf, {5, 0, 0}}};
  for (const auto& c : cases) {
    INFO("height " << c.height << ", half side " << c.half);
    const World world(lit_floor(c.height, c.half));
    const SurfacePoint at = seen(world, c.at + Vec3d(0, 0, 0.5 * c.height), {0, 0, -1});
    REQUIRE(at.id.surface == 1);
    const Moments light = asked(world, SurfaceScatterer(at), 100000);
    // Lambertian, 0.75; very near to the square by its own hemisphere: midpoints would be too coarse.
    const double expected = c.height < 0.05
                                ? 0.75 * kHot * SpectralWorld(world, 0).material({0, 0}).hemispherical_emissivity()
                                : over_square(c.at, c.height, c.half, [](const Vec3d& w) { return 0.75 / kPi * w.z; });
    CHECK(agree(light.mean(), light.standard_error(), expected, {.resolution = 0.02, .comparisons = 5}));
    // Near and huge, neither the face alone nor the cosine alone would be as quiet.
    CHECK(light.standard_error() < 0.002 * expected);
  }
}

TEST_CASE("smoke near a hot square scatters its light by its phase function", "[photon][direct_light]") {
  for (const double height : {0.15, 2.0}) {
    WorldContents contents = lit_floor(height);
    CloudWish smoke;
    smoke.voxels = Vec3i(8);
    smoke.voxel_m = 0.01;
    smoke.corner_m = {0.16, -0.04, 0};
    smoke.extinction = 1e-6;  // hides nothing
    smoke.albedo = 1;
    smoke.phase = PhaseFunction::henyey_greenstein(0.6);
    contents.objects.pop_back();
    contents.clouds.push_back(make_cloud(smoke));
    const World world(contents);
    const Ray ray{{0.2, 0, 1}, Vec3d(0.01, 0, -1).normalized(), 0, kInfinity};
    const double t = 0.96;
    const Moments light = asked(world, CloudScatterer({world, 0}, ray, t), 200000);
    const double expected = over_square(ray.at(t), height, kHalf, [&](const Vec3d& toward) {
      return PhaseFunction::henyey_greenstein(0.6).value(toward.dot(ray.direction));
    });
    CHECK(agree(light.mean(), light.standard_error(), expected, {.resolution = 0.03, .comparisons = 2}));
  }
}

TEST_CASE("what stands in the way of a hot square takes its share", "[photon][direct_light]") {
  // A black sheet half way hides x < 0 of a square twice its size.
  WorldContents contents = lit_floor(2);
  contents.objects.push_back(grey_object(parallelogram({-9, -9, 1}, {9, 0, 0}, {0, 18, 0}), 2, 0));
  const World world(contents);
  const SurfacePoint at = seen(world, {0, 0.05, 0.5}, {0, 0, -1});
  const Moments light = asked(world, SurfaceScatterer(at), 100000);
  const double half =
      over_square({0, 0.05, 0}, 2, kHalf, [](const Vec3d& w) { return w.x > 0 ? 0.75 / kPi * w.z : 0.0; });
  CHECK(agree(light.mean(), light.standard_error(), half, {.resolution = 0.03}));
  // Wholly hidden there is nothing at all.
  contents.objects.push_back(grey_object(parallelogram({-0.5, -9, 0.9}, {9, 0, 0}, {0, 18, 0}), 2, 0));
  const World dark(contents);
  CHECK(asked(dark, SurfaceScatterer(seen(dark, {0, 0.05, 0.5}, {0, 0, -1})), 10000).mean() == 0);
  // From behind the square is cold.
  WorldContents turned = lit_floor(2);
  turned.objects[0].mesh = parallelogram({-kHalf, -kHalf, 2}, {2 * kHalf, 0, 0}, {0, 2 * kHalf, 0});
  const World cold(turned);
  CHECK(asked(cold, SurfaceScatterer(seen(cold, {0, 0.05, 0.5}, {0, 0, -1})), 10000).mean() == 0);
}

TEST_CASE("a cloud and the air between dim direct light, and the air adds its own", "[photon][direct_light]") {
  WorldContents contents = lit_floor(2, 0.02);
  CloudWish smoke;
  smoke.voxels = Vec3i(32, 32, 8);
  smoke.voxel_m = 0.125;
  smoke.corner_m = {-2, -2, 0.5};
  smoke.extinction = 0.9;
  contents.clouds.push_back(make_cloud(smoke));
  contents.atmosphere = Atmosphere{{0.3}, {0}};
  const World world(contents);
  const SurfacePoint at = seen(world, {0, 0, 0.2}, {0, 0, -1});
  const Moments light = asked(world, SurfaceScatterer(at), 20000);
  // Nearly straight up: 1 m of cloud, 2 m of air.
  const double clear = over_square({0, 0, 0}, 2, 0.02, [](const Vec3d& w) { return 0.75 / kPi * w.z; });
  CHECK(agree(light.mean(), light.standard_error(), clear * std::exp(-0.9 - 0.6), {.resolution = 0.01}));
  WorldContents open = empty_contents();
  open.materials = {grey_material(0.25)};
  open.objects = {grey_object(parallelogram({-50, -50, 0}, {100, 0, 0}, {0, 100, 0}), 0, 0)};
  open.atmosphere = Atmosphere{{0.3}, {4}};
  const World air(open);
  // The sky is given as it arrives, with the air before it: open air adds nothing.
  CHECK(asked(air, SurfaceScatterer(seen(air, {0, 0, 1}, {0, 0, -1})), 1000).mean() == 0);
  // Under a black cold lid at 2 m it glows by 1 - 2 E3(0.6), E3 the exponential integral.
  open.objects.push_back(grey_object(parallelogram({-900, -900, 2}, {0, 1800, 0}, {1800, 0, 0}), 0, 0));
  const World lid(open);
  const Moments glow = asked(lid, SurfaceScatterer(seen(lid, {0, 0, 1}, {0, 0, -1})), 100000);
  double e3 = 0;
  constexpr int kSteps = 100000;
  for (int i = 0; i < kSteps; ++i) {
    const double mu = (i + 0.5) / kSteps;
    e3 += mu * std::exp(-0.6 / mu) / kSteps;
  }
  CHECK(agree(glow.mean(), glow.standard_error(), 0.75 * 4 * (1 - 2 * e3), {.resolution = 0.01}));
}

TEST_CASE("inside a hot double-sided sphere every point is lit by all of it", "[photon][direct_light]") {
  WorldContents contents = empty_contents();
  contents.materials = {grey_material(0.4)};
  Object ball = grey_sphere({1, 2, 3}, 2, 0, 5);
  ball.double_sided = true;
  contents.objects = {ball};
  const World world(contents);
  const SurfacePoint at = seen(world, {1.5, 2, 3}, {0.3, 0.2, -1});
  CHECK(at.normal.dot(Vec3d(1, 2, 3) - at.position) > 0);
  const Moments light = asked(world, SurfaceScatterer(at), 20000);
  CHECK(agree(light.mean(), light.standard_error(), 0.6 * 0.4 * 5, {.resolution = 0.02}));
  // Outside it does not light itself.
  CHECK(asked(world, SurfaceScatterer(seen(world, {1, 2, 9}, {0, 0, -1})), 1000).mean() == 0);
}

TEST_CASE("parts that are off give nothing", "[photon][direct_light]") {
  const World world(lit_floor(2));
  RadianceParts parts;
  parts.surfaces = false;
  WorkCounts work;
  CHECK(DirectLight({world, 0}, parts, work).empty());
  CHECK_FALSE(DirectLight({world, 0}, RadianceParts{}, work).empty());
  CHECK(asked(world, SurfaceScatterer(seen(world, {0, 0, 1}, {0, 0, -1})), 100, parts).mean() == 0);
}

TEST_CASE("places on a disc are even, pair by pair opposite", "[photon][direct_light]") {
  const Sun sun{Vec3d(0.2, -0.5, 0.6).normalized(), {1}, 0.4};
  const auto [a, b] = orthonormal_basis(sun.toward);
  const double versine = 2 * std::pow(std::sin(0.1), 2);
  constexpr int kRings = 8, kSectors = 12, kSamples = 100000;
  std::vector<double> cells(kRings * kSectors), even(cells.size(), double(kSamples) / (kRings * kSectors));
  double worst = 0, widest = 0;
  Vec3d first(0);
  for (int i = 0; i < kSamples; ++i) {
    DiscPlaces places({5, static_cast<std::uint64_t>(i), Purpose::disc});
    const Vec3d w = places.toward(sun);
    const double ring = (1 - w.dot(sun.toward)) / versine;
    const double turn = std::atan2(w.dot(b), w.dot(a)) / (2 * kPi) + 0.5;
    widest = std::max(widest, ring);
    ++cells[static_cast<std::size_t>(std::min(static_cast<int>(ring * kRings), kRings - 1) +
                                     kRings * std::min(static_cast<int>(turn * kSectors), kSectors - 1))];
    const Vec3d across = w - w.dot(sun.toward) * sun.toward;
    if (i % 2) worst = std::max(worst, (across + first).length());
    first = across;
  }
  CHECK(chi_square(cells, even));
  CHECK(widest <= 1 + 1e-9);
  CHECK(worst < 1e-9);
}

TEST_CASE("light along a ray through clouds and air is that of many small steps", "[photon][direct_light]") {
  CloudWish a;
  a.voxels = Vec3i(16);
  a.voxel_m = 0.25;
  a.density = [](const Vec3i& v) { return voxel_noise(3, v, 1) < 0.3 ? 0.0 : voxel_noise(3, v, 2); };
  a.extinction = 0.8;
  a.albedo = 0.3;
  a.source = 2;
  CloudWish b = a;
  b.corner_m = {2, 1, 0.5};
  b.extinction = 2;
  b.albedo = 0;
  b.source = 5;
  WorldContents contents = grey_contents(a);
  contents.clouds.push_back(make_cloud(b));
  contents.atmosphere = Atmosphere{{0.2}, {3}};
  const World world(contents);
  const Ray ray{{-1, 0.31, 0.42}, Vec3d(1, 0.41, 0.33).normalized(), 0, 7.5};
  const double k_air = 0.2, B = 3;
  double both = 0, depth = 0;
  constexpr int kSteps = 1500000;
  const double step = 7.5 / kSteps;
  for (int i = 0; i < kSteps; ++i) {
    const double s = (i + 0.5) * step;
    const LocalOptics local = SpectralWorld(world, 0).at(ray.at(s));
    const double T = std::exp(-depth - 0.5 * local.extinction * step);
    const double glow = B * (1 - std::exp(-k_air * s));
    both += T * (local.extinction * glow + std::exp(-k_air * s) * local.emission) * step;
    depth += local.extinction * step;
  }
  CHECK(depth > 1);
  CHECK(light_along({world, 0}, ray) == Approx(both).epsilon(1e-4));
}
