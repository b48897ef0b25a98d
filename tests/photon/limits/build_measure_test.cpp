// The error measure that the octree's builder takes from a cloud's optics.
#include "photon/limits/build_measure.h"

#include <catch2/catch.hpp>

#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

VoxelStream warm_stream() {
  return field_stream(Box3i(Vec3i(0), Vec3i(16)), {"smoke", "fog", "kelvin"}, [](int channel, const Vec3i& v) {
    if (channel == 2) return static_cast<float>(200 + 20 * v.x);  // 200 to 500
    return static_cast<float>(channel == 0 ? 1.0 : 0.5);
  });
}

Cloud two_media() {
  Cloud cloud;
  cloud.media.push_back({0, {0.1, 0.4, 0.2}, {0.5, 0.25, 0}, {}});
  cloud.media.push_back({1, {0.3, 0.2, 0.1}, {0, 0, 0}, {}});
  return cloud;
}

std::vector<Band> bands() { return {Band("mw", 3.0, 5.0, 2), Band("grey")}; }

}  // namespace

TEST_CASE("extinction counts in the interval where the media together attenuate most", "[photon][build_measure]") {
  const std::vector<Band> all = bands();
  const ErrorMeasure measure = build_measure(two_media(), all, warm_stream());
  REQUIRE(measure.optical_weight.size() == 3);
  CHECK(measure.optical_weight[0] == Approx(0.4));  // 0.6 in all, against 0.4 and 0.3
  CHECK(measure.optical_weight[1] == Approx(0.2));
  CHECK(measure.optical_weight[2] == 0);
  CHECK(!measure.emission);  // no temperature channel
  // A placement that doubles lengths doubles optical depths.
  Cloud scaled = two_media();
  scaled.local_to_world = placement({5, 6, 7}, {0.1, 0.2, 0.3}, 2);
  CHECK(build_measure(scaled, all, warm_stream()).optical_weight[0] == Approx(0.8));
}

TEST_CASE("emission counts relative to the warmest voxel, in the interval where it shines most",
          "[photon][build_measure]") {
  Cloud cloud = two_media();
  cloud.temperature = {2, 1, 0, 0};
  const std::vector<Band> all = bands();
  const ErrorMeasure measure = build_measure(cloud, all, warm_stream());
  REQUIRE(measure.emission);
  const Band& band = all[0];
  // At 500 K the second half of 3 to 5 um is the brighter.
  REQUIRE(band.planck(1, 500) > band.planck(0, 500));
  const auto expected = [&](double smoke, double fog, double kelvin) {
    return (smoke * 0.4 * 0.75 + fog * 0.2) * band.planck(1, kelvin) / band.planck(1, 500);
  };
  for (const auto& [smoke, fog, kelvin] :
       {std::tuple(1.f, 0.5f, 500.f), std::tuple(2.f, 0.f, 300.f), std::tuple(0.f, 3.f, 450.f)}) {
    const float values[] = {smoke, fog, kelvin};
    CHECK(measure.emission(values) ==
          Approx(expected(static_cast<double>(smoke), static_cast<double>(fog), static_cast<double>(kelvin)))
              .epsilon(1e-6));
  }
  const float nothing[] = {0, 0, 500};
  CHECK(measure.emission(nothing) == 0);
}

TEST_CASE("a temperature's scale and offset are obeyed; a given source replaces it", "[photon][build_measure]") {
  Cloud cloud = two_media();
  cloud.temperature = {2, 0.5, 100, 0};  // 200 to 350 K
  const std::vector<Band> all = bands();
  const ErrorMeasure measure = build_measure(cloud, all, warm_stream());
  const float values[] = {1, 0, 400};
  CHECK(measure.emission(values) == Approx(0.3 * all[0].planck(1, 300) / all[0].planck(1, 350)).epsilon(1e-6));
  cloud.source = {1.0, 1.0, 1.0};
  CHECK(!build_measure(cloud, all, warm_stream()).emission);
}

TEST_CASE("a cloud that emits is built within its tolerance of emission, too", "[photon][build_measure]") {
  Cloud cloud = two_media();
  cloud.temperature = {2, 1, 0, 0};
  const std::vector<Band> all = bands();
  BuildSettings settings;
  settings.tolerance = 1e-2;
  settings.measure = build_measure(cloud, all, warm_stream());
  auto [tree, report] = build_octree(warm_stream(), settings);
  CHECK(report.emission_error_measured > 0);
  CHECK(report.emission_error_measured <= 1e-2);
  // By the World's own pass, relative to a black body at 500 K.
  const auto radiance = [&](const std::shared_ptr<const Octree>& octree, const Ray& ray) {
    cloud.octree = octree;
    WorldContents contents;
    contents.bands = all;
    contents.clouds = {cloud};
    const World world(std::move(contents));
    const std::uint64_t history = 1;
    Incoming in;
    RadianceSettings emission_only;
    emission_only.scattering_depth = 0;
    incoming_radiance({world, 1}, nullptr, emission_only, {&ray, 1}, {&history, 1}, {&in, 1});
    return in.direct;
  };
  BuildSettings lossless;
  lossless.tolerance = 0;
  const auto merged_tree = std::make_shared<const Octree>(std::move(tree));
  const auto exact_tree = std::make_shared<const Octree>(build_octree(warm_stream(), lossless).first);
  double brightest = 0;
  Stream random(1, 0, 0);
  for (int i = 0; i < 20; ++i) {
    const Vec3d d = random_direction(random);
    const Ray ray{Vec3d(8) - 40.0 * d, d, 0, kInfinity};
    const double exact = radiance(exact_tree, ray);
    const double merged = radiance(merged_tree, ray);
    CHECK(std::abs(merged - exact) < 1e-2 * all[0].planck(1, 500));
    brightest = std::max(brightest, exact);
  }
  CHECK(brightest > 0.1 * all[0].planck(1, 500));
}
