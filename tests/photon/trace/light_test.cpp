// Photons of all bands and intervals together, and what photons refuse to serve.
#include "photon/trace/light.h"

#include <catch2/catch.hpp>

#include "octree/base/error.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

/// A grey band and a thermal one with three intervals.
World two_bands() {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  WorldContents contents;
  contents.bands.emplace_back("grey");
  contents.bands.emplace_back("ir", 3.0, 12.0, 3);
  Cloud cloud = make_cloud(wish);
  cloud.media[0].extinction = {0.5, 0.5, 1.0, 0.25};
  cloud.media[0].albedo = {0.5, 0.5, 0.5, 0.5};
  cloud.temperature.constant_K = 400;
  cloud.source = {2.0, std::nullopt, std::nullopt, std::nullopt};
  contents.clouds.push_back(cloud);
  return World(std::move(contents));
}

double sum(const BatchTally& tally) {
  double result = 0;
  for (const double value : tally) result += value;
  return result;
}

World periodic(std::array<double, 2> period, std::optional<std::array<double, 2>> second = {}, double turn = 0) {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.period_m = period;
  WorldContents contents = grey_contents(wish, 1);
  if (second) {
    wish.period_m = *second;
    contents.clouds.push_back(make_cloud(wish));
    contents.clouds.back().local_to_world = placement({0, 0, 0}, {0, 0, turn}, 1);
  }
  return World(std::move(contents));
}

}  // namespace

TEST_CASE("intervals of a band share its photons by power, and every band has its own", "[photon][light]") {
  const World world = two_bands();
  TraceSettings settings;
  settings.photons = 30000;
  const Light light = trace_light(world, settings);
  REQUIRE(light.maps.size() == 4);
  REQUIRE(light.bands.size() == 2);
  CHECK(light.emitted == Approx(60000).margin(3));
  CHECK(light.anomalies == 0);
  double power[4], ir = 0;
  for (int i = 0; i < 4; ++i) power[i] = PhotonEmitter({world, i}).power();
  for (int i = 1; i < 4; ++i) {
    ir += power[i];
    const double k = SpectralWorld(world, i).optics(0).parts()[0].extinction;
    CHECK(power[i] == Approx(4 * kPi * 0.5 * k * 512 * world.bands()[1].planck(i - 1, 400)).epsilon(1e-6));
  }
  CHECK(sum(light.bands[0].energy.emitted) == Approx(power[0]));
  CHECK(sum(light.bands[1].energy.emitted) == Approx(ir));
  // Powers within an interval follow its own number of photons.
  std::uint64_t stored = 0;
  for (int i = 0; i < 4; ++i) {
    const PhotonMap& map = light.maps[static_cast<std::size_t>(i)].volume;
    stored += map.size();
    const double photons = i == 0 ? 30000 : 30000 * power[i] / ir;
    CHECK(static_cast<double>(map.photons()[0].power) == Approx(power[i] / photons).epsilon(0.01));
  }
  CHECK(light.stored == stored);
  CHECK(light.bytes > 24 * stored);
}

TEST_CASE("an interval without power gets an empty map, one with little at least a photon", "[photon][light]") {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  WorldContents contents;
  contents.bands.emplace_back("ir", 3.0, 12.0, 3);
  Cloud cloud = make_cloud(wish);
  cloud.media[0].extinction = {1, 1, 1};
  cloud.media[0].albedo = {0, 0, 0};
  cloud.source = {0.0, 1e-9, 1.0};
  contents.clouds.push_back(cloud);
  TraceSettings settings;
  settings.photons = 1000;
  const Light light = trace_light(World(std::move(contents)), settings);
  CHECK(light.maps[0].volume.size() == 0);
  CHECK(light.maps[1].volume.size() <= 1);
  CHECK(light.emitted == 1001);
}

TEST_CASE("what photons of a periodic cloud cannot serve is refused by name", "[photon][light]") {
  TraceSettings settings;
  settings.photons = 100;
  CHECK_NOTHROW(trace_light(periodic({8, 8}), settings));
  CHECK_NOTHROW(trace_light(periodic({8, 8}, {{8, 8}}), settings));
  CHECK_THROWS_AS(trace_light(periodic({8, 8}, {{8, 9}}), settings), NumericalError);
  CHECK_THROWS_AS(trace_light(periodic({8, 8}, {{0, 0}}), settings), NumericalError);
  // Periods of one length in two directions have no common cell either.
  CHECK_THROWS_AS(trace_light(periodic({8, 8}, {{8, 8}}, 0.5), settings), NumericalError);
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.period_m = {8, 8};
  for (int kind = 0; kind < 3; ++kind) {
    WorldContents contents = grey_contents(wish);
    if (kind == 0) contents.sources.push_back({{0, 0, 20}, 1, {1}});
    if (kind == 1) contents.particles.push_back({{0, 0, 20}, 1, {1}});
    if (kind == 2) contents.beams.push_back({{0, 0, 20}, {0, 0, -1}, 1, {1}});
    CHECK_THROWS_AS(trace_light(World(std::move(contents)), settings), NumericalError);
  }
  const FluxRectangle upright{{0, 0, 4}, {1, 0, 0}, {0, 0, 1}};
  const FluxRectangle flat{{0, 0, 4}, {1, 0, 0}, {0, 1, 0}};
  CHECK_THROWS_AS(trace_light(periodic({8, 8}), settings, {&upright, 1}), NumericalError);
  CHECK_NOTHROW(trace_light(periodic({8, 8}), settings, {&flat, 1}));
  CHECK_NOTHROW(trace_light(World(grey_contents({}, 1)), settings, {&upright, 1}));
}

TEST_CASE("histories that would not end are refused unless no photon is wanted", "[photon][light]") {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.extinction = 1e4;
  wish.albedo = 1;
  const World world(grey_contents(wish, 1));
  TraceSettings settings;
  settings.photons = 10;
  CHECK_THROWS_AS(trace_light(world, settings), NumericalError);
  settings.photons = 0;
  CHECK(trace_light(world, settings).stored == 0);
}

TEST_CASE("light from beyond passes rectangles above and below a periodic layer", "[photon][light]") {
  CloudWish wish;
  wish.voxels = Vec3i(2);
  wish.voxel_m = 0.5;
  wish.period_m = {1, 1};
  WorldContents contents = grey_contents(wish, 2.0);
  contents.sun = Sun{Vec3d(0, 0.6, 0.8), {3.0}, 0};
  const World world(std::move(contents));
  TraceSettings settings;
  settings.photons = 50000;
  // A cell's share of what comes down on the layer from above: the sky's pi L and the sun's E cos.
  const std::vector<FluxRectangle> rectangles{{{0.5, 0.5, 4}, {1, 0, 0}, {0, 1, 0}},
                                              {{0.5, 0.5, 1.5}, {1, 0, 0}, {0, 1, 0}},
                                              {{0.5, 0.5, -3}, {1, 0, 0}, {0, 1, 0}}};
  const Light light = trace_light(world, settings, rectangles);
  for (const std::size_t above : {0u, 1u}) {
    const auto down = light.bands[0].flux[above].backward;
    CHECK(pairwise_sum(down) == Approx(2 * kPi + 3 * 0.8).epsilon(0.01));
  }
  CHECK(pairwise_sum(light.bands[0].flux[2].forward) == Approx(2 * kPi).epsilon(0.01));
}
