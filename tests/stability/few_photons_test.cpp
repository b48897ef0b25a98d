// Photon maps of too few photons, or of all in one place.
#include <catch2/catch.hpp>

#include "tests/stability/limits.h"
#include "tests/support/agree.h"
#include "tests/support/estimators.h"

using namespace obscura;
using namespace obscura::test;

TEST_CASE("no photons leave direct light alone, one photon is all the power there is", "[stability][few]") {
  CloudWish wish = rough_wish(0.7, 0.3);
  WorldContents contents = grey_contents(wish);
  contents.sun = Sun{{0, 0, 1}, {3}, 0};
  const World world(contents);
  const Ray ray{{1.6, -2, 1.7}, {0, 1, 0}, 0, kInfinity};
  RadianceSettings direct;
  direct.parts.map = false;
  const Light none = photons_of(world, 0);
  CHECK(none.emitted == 0);
  CHECK(none.stored == 0);
  const Seen without = seen(world, none, kPhotonMap, {&ray, 1}, 20);
  CHECK(without.mean == seen(world, {}, kPhotonMap, {&ray, 1}, 20, direct).mean);
  CHECK(without.mean > 0);
  CHECK(without.anomalies == 0);
  CHECK(seen(world, none, kFinalGather, {&ray, 1}, 20).anomalies == 0);

  const double power = 3 * kPi * world.bounds().size().length2() / 4;
  double worst = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Light one = photons_of(world, 1, seed);
    const EnergyTally& energy = one.bands[0].energy;
    CHECK(one.emitted == 1);
    CHECK(total(energy.emitted) == Approx(power).epsilon(1e-6));
    CHECK(total(energy.absorbed) + total(energy.escaped) == Approx(power).epsilon(1e-6));
    const Seen with = seen(world, one, kPhotonMap, {&ray, 1}, 1);
    CHECK(with.anomalies == 0);
    worst = std::max(worst, std::abs(with.mean - without.mean));
  }
  CHECK(std::isfinite(worst));
}

TEST_CASE("with fewer photons than neighbours the furnace is black in the mean", "[stability][few]") {
  CloudWish wish;
  wish.voxels = Vec3i(4);
  wish.voxel_m = 0.25;
  wish.extinction = 1;
  wish.albedo = 0.5;
  wish.source = kB;
  const World world(grey_contents(wish, kB));
  const Ray ray{{-1, 0.4, 0.6}, {1, 0, 0}, 0, kInfinity};
  Moments maps;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const Light light = photons_of(world, 150, seed);
    CHECK(light.stored < 64);
    RadianceSettings settings;
    settings.seed = seed;
    maps.add(seen(world, light, kPhotonMap, {&ray, 1}, 4, settings).mean);
  }
  INFO(maps.mean() << " +- " << maps.standard_error());
  CHECK(std::abs(maps.mean() - kB) <= 5 * maps.standard_error() + 0.03 * kB);
  CHECK(maps.standard_error() < 0.02 * kB);
}

TEST_CASE("all photons in one place have no density, and are absorbed and escape as they should", "[stability][few]") {
  // A beam without width on 1e9 a metre, beside the middle: the map's floats are farther apart than the light gets.
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.voxel_m = 128;
  wish.extinction = 1e9;
  wish.albedo = 0.3;
  const World world([&] {
    WorldContents contents = grey_contents(wish);
    contents.beams.push_back({{612, 412, 2000}, {0, 0, -1}, 0, {5}});
    return contents;
  }());
  TraceSettings trace;
  trace.photons = 5000;
  const TraceResult traced = trace_photons({world, 0}, trace);
  const BatchMean escaped = per_area(traced.energy.escaped, 5);
  // d4: a half space of albedo 0.3 reflects this much of a normal beam.
  CHECK(agree(escaped.mean, escaped.standard_error, 0.05721435060125, {.resolution = 1, .degrees_of_freedom = 15}));
  CHECK(total(traced.energy.absorbed) + total(traced.energy.escaped) == Approx(5).epsilon(1e-9));
  CHECK(traced.photons.size() > 5000);
  for (const Photon& photon : traced.photons) CHECK(photon.position == traced.photons.front().position);
  const Light light = photons_of(world, 5000);
  const Ray onto{{612, 412, 1500}, Vec3d(0.001, 0, -1).normalized(), 0, kInfinity};
  const Seen there = seen(world, light, kPhotonMap, {&onto, 1}, 20);
  CHECK(there.anomalies == 0);
  CHECK(there.mean == 0);
}
