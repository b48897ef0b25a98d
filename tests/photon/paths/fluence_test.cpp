// Fluence at points where it is known.
#include "photon/paths/fluence.h"

#include <catch2/catch.hpp>

#include "tests/support/agree.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

World thin(double extinction, double source, double sky, double sun, double diameter = 0.0093) {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.extinction = extinction;
  wish.source = source;
  WorldContents contents = grey_contents(wish, sky);
  if (sun > 0) contents.sun = Sun{{0, 0, 1}, {sun}, diameter};
  return World(std::move(contents));
}

}  // namespace

TEST_CASE("under an even sky the fluence is 4 pi times its radiance", "[photon][fluence]") {
  const BatchMean f = fluence({thin(0, 0, 0.7, 0), 0}, nullptr, {}, {4, 4, 4}, 500, 1);
  CHECK(f.mean == Approx(4 * kPi * 0.7).epsilon(1e-12));
  CHECK(f.standard_error < 1e-9);
}

TEST_CASE("the sun adds its irradiance, attenuated on the way, once", "[photon][fluence]") {
  CHECK(fluence({thin(0, 0, 0.7, 5), 0}, nullptr, {}, {4, 4, 4}, 500, 1).mean == Approx(4 * kPi * 0.7 + 5));
  CHECK(fluence({thin(0.3, 0, 0, 5), 0}, nullptr, {}, {4, 4, 4}, 500, 1).mean ==
        Approx(5 * std::exp(-1.2)).epsilon(1e-5));
  CHECK(fluence({thin(0.3, 0, 0, 5), 0}, nullptr, {}, {4, 4, -4}, 500, 1).mean ==
        Approx(5 * std::exp(-2.4)).epsilon(1e-5));
  // Rays do meet the disc of a sun as wide as this.
  CHECK(fluence({thin(0, 0, 0.7, 5, 1.0), 0}, nullptr, {}, {4, 4, 4}, 500, 1).mean == Approx(4 * kPi * 0.7 + 5));
  RadianceSettings none;
  none.parts.background = false;
  CHECK(fluence({thin(0.3, 0, 1, 5), 0}, nullptr, none, {4, 4, 4}, 500, 1).mean == 0);
}

TEST_CASE("in a cloud as bright as its sky the fluence is 4 pi times the source", "[photon][fluence]") {
  const BatchMean f = fluence({thin(0.3, 2, 2, 0), 0}, nullptr, {}, {1, 4, 6}, 500, 1);
  CHECK(f.mean == Approx(4 * kPi * 2).epsilon(1e-5));
}

TEST_CASE("beside a glowing ball the fluence is its solid angle times its radiance, within its error",
          "[photon][fluence]") {
  WorldContents contents;
  contents.bands.emplace_back("grey");
  contents.sources.push_back({{0, 0, 0}, 1, {6}});
  const World world(std::move(contents));
  const double expected = 6 * 2 * kPi * (1 - std::sqrt(1 - 0.25));
  Moments over_histories;
  int covered = 0;
  for (std::uint64_t history = 0; history < 50; ++history) {
    const BatchMean f = fluence({world, 0}, nullptr, {}, {2, 0, 0}, 2000, history);
    over_histories.add(f.mean);
    covered += std::abs(f.mean - expected) < 2 * f.standard_error;
  }
  CHECK(agree(over_histories.mean(), over_histories.standard_error(), expected, {.resolution = 0.03}));
  CHECK(covered > 45);  // stratified: the error is told too large rather than too small
  // Two directions are hardly stratified: then the error is neither too large nor too small.
  Moments pairs;
  double told = 0;
  constexpr int kPairs = 4000;
  for (std::uint64_t history = 0; history < kPairs; ++history) {
    const BatchMean f = fluence({world, 0}, nullptr, {}, {2, 0, 0}, 2, history);
    pairs.add(f.mean);
    told += f.standard_error * f.standard_error / kPairs;
  }
  CHECK(told == Approx(pairs.variance()).epsilon(0.15));
}

TEST_CASE("the map adds what has scattered: in a furnace that scatters the fluence is 4 pi B", "[photon][fluence]") {
  CloudWish wish;
  wish.voxels = Vec3i(16);
  wish.extinction = 0.4;
  wish.albedo = 0.7;
  wish.source = 2;
  const World world(grey_contents(wish, 2));
  TraceSettings trace;
  trace.photons = 200000;
  const Light light = trace_light(world, trace);
  const BatchMean f = fluence({world, 0}, &light.maps[0], {}, {7, 8, 9}, 400, 1);
  CHECK(std::abs(f.mean - 8 * kPi) < 4 * f.standard_error + 0.005 * 8 * kPi);
  CHECK(f.standard_error < 0.03 * 8 * kPi);
  CHECK(fluence({world, 0}, nullptr, {}, {7, 8, 9}, 400, 1).mean < 0.95 * 8 * kPi);
}
