// The sensor pass against numbers known on paper, part by part.
#include "photon/paths/radiance.h"

#include <catch2/catch.hpp>

#include "tests/support/agree.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

/// Wide and 1 m thick along z.
CloudWish slab(double extinction, double albedo, double g = 0) {
  CloudWish wish;
  wish.voxels = {64, 64, 1};
  wish.extinction = extinction;
  wish.albedo = albedo;
  wish.phase = PhaseFunction::henyey_greenstein(g);
  return wish;
}

constexpr RadianceParts kNone{false, true, false, false, false, false, false, false};

RadianceSettings only(bool RadianceParts::*part, int points = 4) {
  RadianceSettings settings;
  settings.parts = kNone;
  settings.parts.*part = true;
  settings.points = points;
  return settings;
}

Incoming one_ray(const World& world, const Ray& ray, const RadianceSettings& settings = {}, int interval = 0) {
  const std::uint64_t history = 1;
  Incoming incoming;
  incoming_radiance({world, interval}, nullptr, settings, {&ray, 1}, {&history, 1}, {&incoming, 1});
  return incoming;
}

RayRadiance many_rays(const World& world, const Ray& ray, int count, const RadianceSettings& settings) {
  return ray_radiance(world, {}, ray, count, settings);
}

const Ray kDown{{32, 32, 5}, {0, 0, -1}, 0, kInfinity};

}  // namespace

TEST_CASE("a box that emits shows source times opacity along every chord", "[photon][radiance]") {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.extinction = 0.3;
  wish.source = 2;
  const World world(grey_contents(wish, 0.5));
  const struct {
    Ray ray;
    double chord;
  } cases[] = {{{{4, 4, 20}, {0, 0, -1}, 0, kInfinity}, 8},
               {{{4, 4, 4}, {1, 0, 0}, 0, kInfinity}, 4},  // from inside
               {{{-4, 4, 4}, Vec3d(1, 1, 0).normalized(), 0, kInfinity}, 0},
               {{{-2, 0.5, 4}, Vec3d(1, 1, 0).normalized(), 0, kInfinity}, 5.5 * std::sqrt(2.0)},
               {{{4, 4, 20}, {0, 0, 1}, 0, kInfinity}, 0}};
  for (const auto& c : cases) {
    const Incoming in = one_ray(world, c.ray);
    const double transmission = std::exp(-0.3 * c.chord);
    CHECK(in.transmission == Approx(transmission).epsilon(1e-5));
    CHECK(in.direct == Approx(2 * (1 - transmission) + 0.5 * transmission).epsilon(1e-5));
    CHECK(in.distance == kInfinity);
    CHECK(one_ray(world, c.ray, only(&RadianceParts::background)).direct == Approx(0.5 * transmission).epsilon(1e-5));
    CHECK(one_ray(world, c.ray, only(&RadianceParts::emission)).direct ==
          Approx(2 * (1 - transmission)).epsilon(1e-5).margin(1e-12));
  }
}

TEST_CASE("emission that varies is integrated segment by segment", "[photon][radiance]") {
  CloudWish near, far;
  near.voxels = far.voxels = Vec3i(8);
  near.extinction = 0.1;
  near.source = 3;
  far.extinction = 0.4;
  far.source = 7;
  far.albedo = 0.25;
  far.corner_m = {0, 0, -4};  // overlaps by half
  WorldContents contents = grey_contents(near);
  contents.clouds.push_back(make_cloud(far));
  const World world(std::move(contents));
  double expected = 0, transmission = 1;
  for (const auto& [emission, extinction] : {std::pair(0.3, 0.1), std::pair(0.3 + 2.1, 0.5), std::pair(2.1, 0.4)}) {
    expected += transmission * emission / extinction * (1 - std::exp(-4 * extinction));
    transmission *= std::exp(-4 * extinction);
  }
  const Incoming in = one_ray(world, {{4, 4, 20}, {0, 0, -1}, 0, kInfinity}, only(&RadianceParts::emission));
  CHECK(in.direct == Approx(expected).epsilon(1e-9));
  CHECK(in.transmission == Approx(transmission).epsilon(1e-5));
}

TEST_CASE("sunlight scattered once in a slab follows the formula, reflected and transmitted", "[photon][radiance]") {
  for (const double tau : {0.05, 1.0, 6.0}) {
    WorldContents contents = grey_contents(slab(tau, 0.7, 0.5));
    const double zenith = 0.6;
    const Vec3d toward(std::sin(zenith), 0, std::cos(zenith));
    contents.sun = Sun{toward, {10}, 1e-6};
    const World world(std::move(contents));
    const PhaseFunction phase = PhaseFunction::henyey_greenstein(0.5);
    const double mu0 = std::cos(zenith), mu = 0.8;
    // Chandrasekhar, Radiative Transfer (1960), ch. IX: w p E mu0 / (mu + mu0) (1 - e^(-tau (1/mu + 1/mu0)))
    // above; below w p E mu0 / (mu0 - mu) (e^(-tau / mu0) - e^(-tau / mu)).
    const Vec3d up(0.6, 0, 0.8), down(0.6, 0, -0.8);
    const double reflected =
        0.7 * phase.value(up.dot(-toward)) * 10 * mu0 / (mu + mu0) * (1 - std::exp(-tau * (1 / mu + 1 / mu0)));
    const double transmitted =
        0.7 * phase.value(down.dot(-toward)) * 10 * mu0 / (mu0 - mu) * (std::exp(-tau / mu0) - std::exp(-tau / mu));
    const AgreeOptions options{.resolution = 0.02, .comparisons = 6};
    const RayRadiance above =
        many_rays(world, {Vec3d(32, 32, 1) + 5.0 * up, -up, 0, kInfinity}, 20000, only(&RadianceParts::sun));
    CHECK(agree(above.mean, above.error, reflected, options));
    AgreeOptions deep = options;  // few points see the sun through a thick slab
    deep.resolution = tau > 5 ? 0.2 : 0.02;
    const RayRadiance below =
        many_rays(world, {Vec3d(32, 32, 0) + 5.0 * down, -down, 0, kInfinity}, 20000, only(&RadianceParts::sun));
    CHECK(agree(below.mean, below.error, transmitted, deep));
    // Another side of the phase function does not fit.
    CHECK(!agree(above.mean, above.error, reflected * phase.value(up.dot(toward)) / phase.value(up.dot(-toward)),
                 options));
    // Nothing where nothing may scatter.
    RadianceSettings no_scattering = only(&RadianceParts::sun);
    no_scattering.scattering_depth = 0;
    CHECK(many_rays(world, {Vec3d(32, 32, 1) + 5.0 * up, -up, 0, kInfinity}, 10, no_scattering).mean == 0);
  }
}

TEST_CASE("skylight scattered once in a thin slab is albedo times depth times sky", "[photon][radiance]") {
  const World world(grey_contents(slab(1e-4, 0.6, 0.8), 3));
  const RayRadiance sky = many_rays(world, kDown, 2000, only(&RadianceParts::sky, 1));
  CHECK(sky.mean == Approx(3 * 0.6 * (1 - std::exp(-1e-4))).epsilon(0.01));
  // Background and scattered sky: what a conservative thin cloud takes it gives back.
  const World white(grey_contents(slab(1e-4, 1, 0.8), 3));
  const double whole = many_rays(white, kDown, 2000, {}).mean;
  CHECK(whole == Approx(3).epsilon(2e-6));
}

TEST_CASE("a hot sphere's light scattered once is its irradiance through the phase function", "[photon][radiance]") {
  // So thin that nothing is lost on the way; the sphere is 10 m to the side of the point that is seen.
  CloudWish wish;
  wish.voxels = Vec3i(1);
  wish.voxel_m = 0.01;
  wish.extinction = 1e-3;
  wish.albedo = 0.5;
  wish.phase = PhaseFunction::henyey_greenstein(0.6);
  WorldContents contents = grey_contents(wish);
  contents.sources.push_back({{10, 0.005, 0.005}, 2, {4}});
  contents.particles.push_back({{0.005, 10, 0.005}, 2, {4}});  // its first scattering comes from the map
  const World world(std::move(contents));
  const Ray ray{{0.005, 0.005, 3}, {0, 0, -1}, 0, kInfinity};
  const RayRadiance found = many_rays(world, ray, 20000, only(&RadianceParts::spheres));
  // The mean of the phase function over the cone, whose solid angle is 2 pi (1 - sqrt(1 - sin^2)).
  const double sine = 2 / 9.995;
  double integral = 0;
  constexpr int kSteps = 200;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const double versine = (1 - std::sqrt(1 - sine * sine)) * (i + 0.5) / kSteps;
      const double phi = 2 * kPi * (j + 0.5) / kSteps;
      const Vec3d toward(1 - versine, std::sqrt(2 * versine - versine * versine) * std::cos(phi),
                         std::sqrt(2 * versine - versine * versine) * std::sin(phi));
      integral += wish.phase.value(-toward.z) / (kSteps * kSteps);
    }
  }
  const double expected = 0.5 * 1e-5 * 4 * 2 * kPi * (1 - std::sqrt(1 - sine * sine)) * integral;
  CHECK(agree(found.mean, found.error, expected, {.resolution = 0.02}));
  // Behind another sphere it is dark.
  WorldContents shaded = grey_contents(wish);
  shaded.sources.push_back({{10, 0.005, 0.005}, 2, {4}});
  shaded.particles.push_back({{5, 0.005, 0.005}, 1.5, {4}});
  CHECK(many_rays(World(std::move(shaded)), ray, 100, only(&RadianceParts::spheres)).mean == 0);
}

TEST_CASE("spheres and the sun's disc are seen through the cloud, spheres at their distance", "[photon][radiance]") {
  WorldContents contents = grey_contents(slab(0.5, 0), 0.25);
  contents.sun = Sun{{0, 0, 1}, {2}, 0.01};
  contents.sources.push_back({{32, 32, -4}, 1, {9}});
  const World world(std::move(contents));
  const Incoming sphere = one_ray(world, kDown);
  CHECK(sphere.distance == Approx(8));
  CHECK(sphere.transmission == Approx(std::exp(-0.5)).epsilon(1e-5));
  CHECK(sphere.direct == Approx(9 * std::exp(-0.5)).epsilon(1e-5));
  const Ray up{{40, 40, -2}, {0, 0, 1}, 0, kInfinity};
  CHECK(one_ray(world, up).direct == Approx(std::exp(-0.5) * (0.25 + world.suns()[0].radiance(0))).epsilon(1e-5));
  RadianceSettings no_disc;
  no_disc.parts.sun_disc = false;
  CHECK(one_ray(world, up, no_disc).direct == Approx(std::exp(-0.5) * 0.25).epsilon(1e-5));
  // A cloud behind the sphere is not there.
  const Ray from_below{{32, 32, -10}, {0, 0, 1}, 0, kInfinity};
  CHECK(one_ray(world, from_below).transmission == 1);
  CHECK(one_ray(world, from_below).direct == 9);
}

TEST_CASE("a cloud without extinction changes no bit of what is behind it", "[photon][radiance]") {
  const double sky = 0.1 + 0.2;
  CloudWish wish;
  wish.voxels = Vec3i(8);
  for (const bool empty : {false, true}) {
    wish.extinction = empty ? 1 : 0;
    wish.albedo = 0.5;
    wish.source = 5;
    if (empty) wish.density = [](const Vec3i&) { return 0.0; };
    WorldContents contents = grey_contents(wish, sky);
    contents.sun = Sun{{0, 0, 1}, {1.0 / 3}, 0.01};
    const World world(std::move(contents));
    Stream random(1, 0, 0);
    for (int i = 0; i < 100; ++i) {
      const Vec3d d = random_direction(random);
      const Incoming in = one_ray(world, {{4, 4, 4}, d, 0, kInfinity});
      CHECK(in.direct == SpectralWorld(world, 0).background(d));
      CHECK(in.transmission == 1);
    }
  }
}

TEST_CASE("the map's part is the in-scattered light of its photons", "[photon][radiance]") {
  // In a large medium of albedo w that emits B everywhere, J = B: the map holds what has collided, so
  // emission alone gives (1 - w) B and the map the other w B.
  CloudWish wish;
  wish.voxels = Vec3i(32);
  wish.extinction = 1.5;
  wish.albedo = 0.6;
  wish.source = 2;
  const World world(grey_contents(wish, 2));
  TraceSettings trace;
  trace.photons = 400000;
  const Light light = trace_light(world, trace);
  const Ray ray{{16, 16, 16}, Vec3d(1, 0.3, 0.2).normalized(), 0, kInfinity};
  RadianceSettings settings;
  settings.parts = kNone;
  settings.parts.emission = true;
  CHECK(ray_radiance(world, light, ray, 1, settings).mean == Approx(0.4 * 2).epsilon(1e-5));
  settings = only(&RadianceParts::map);
  settings.gather.nearest = 200;
  // At places so far apart that they share few photons.
  Moments map;
  for (int i = 0; i < 64; ++i) {
    const Vec3d place(10 + 4 * (i & 3), 10 + 4 * ((i >> 2) & 3), 10 + 4 * (i >> 4));
    map.add(ray_radiance(world, light, {place, ray.direction, 0, kInfinity}, 8, settings).mean);
  }
  CHECK(agree(map.mean(), map.standard_error(), 0.6 * 2, {.resolution = 0.15, .degrees_of_freedom = 63}));
  // Sixteen batches, none of them alike, whose mean is the value.
  Incoming in;
  const std::uint64_t history = 7;
  const RadianceCounts counts =
      incoming_radiance({world, 0}, &light.maps[0], settings, {&ray, 1}, {&history, 1}, {&in, 1});
  CHECK(in.direct == 0);
  CHECK(*std::min_element(in.map.begin(), in.map.end()) < *std::max_element(in.map.begin(), in.map.end()));
  CHECK(counts.rays == 1);
  CHECK(counts.work[Work::scattering] > 0);
  for (const Work towards : {Work::sun, Work::sky, Work::faces, Work::spheres, Work::beams})
    CHECK(counts.work[towards] == 0);
  CHECK(counts.anomalies == 0);
}

TEST_CASE("an estimate without a denominator counts as an anomaly", "[photon][radiance]") {
  // A map whose photons lie far from all medium: it belongs to another World.
  CloudWish wish;
  wish.voxels = Vec3i(1);
  wish.albedo = 0.5;
  const World world(grey_contents(wish));
  std::vector<Photon> photons;
  for (int i = 0; i < 1000; ++i) {
    Photon photon;
    photon.position =
        Vec3f(static_cast<float>(voxel_noise(1, Vec3i(i, 0, 0))), static_cast<float>(voxel_noise(1, Vec3i(i, 1, 0))),
              1000.0f + static_cast<float>(voxel_noise(1, Vec3i(i, 2, 0))));
    photon.direction = encode_direction({0, 0, 1});
    photon.power = 1;
    photons.push_back(photon);
  }
  const PhotonMaps map{PhotonMap(std::move(photons)), {}};
  const std::vector<Ray> rays(20, Ray{{0.5, 0.5, 5}, {0, 0, -1}, 0, kInfinity});
  std::vector<std::uint64_t> histories(20);
  for (std::size_t i = 0; i < histories.size(); ++i) histories[i] = i;
  std::vector<Incoming> incoming(20);
  const RadianceCounts counts =
      incoming_radiance({world, 0}, &map, only(&RadianceParts::map), rays, histories, incoming);
  CHECK(counts.anomalies == 20);
  for (const Incoming& in : incoming) CHECK(in.total() == 0);
}

TEST_CASE("each interval has its own optics, and a ray's result does not depend on the others", "[photon][radiance]") {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  WorldContents contents;
  contents.bands.emplace_back("ir", 8.0, 12.0, 2);
  Cloud cloud = make_cloud(wish);
  cloud.media[0].extinction = {0.1, 0.3};
  cloud.media[0].albedo = {0.5, 0.2};
  cloud.temperature.constant_K = 320;
  contents.clouds.push_back(cloud);
  contents.sky = {1.5, 2.5};
  const World world(std::move(contents));
  const Ray ray{{4, 4, 20}, {0, 0, -1}, 0, kInfinity};
  for (int i = 0; i < 2; ++i) {
    RadianceSettings settings;
    settings.scattering_depth = 0;
    const double k = i ? 0.3 : 0.1, w = i ? 0.2 : 0.5, sky = i ? 2.5 : 1.5;
    const double expected = (1 - w) * world.bands()[0].planck(i, 320) * (1 - std::exp(-8 * k)) + sky * std::exp(-8 * k);
    CHECK(one_ray(world, ray, settings, i).direct == Approx(expected).epsilon(1e-5));
  }
  std::vector<Ray> rays;
  std::vector<std::uint64_t> histories;
  Stream random(2, 0, 0);
  for (int i = 0; i < 50; ++i) {
    rays.push_back({{4, 4, 4}, random_direction(random), 0, kInfinity});
    histories.push_back(static_cast<std::uint64_t>(1000 + i));
  }
  std::vector<Incoming> together(50);
  incoming_radiance({world, 1}, nullptr, {}, rays, histories, together);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Incoming alone;
    incoming_radiance({world, 1}, nullptr, {}, {&rays[i], 1}, {&histories[i], 1}, {&alone, 1});
    CHECK(alone.direct == together[i].direct);
  }
}
