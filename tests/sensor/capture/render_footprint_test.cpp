// The camera's spots reach the clouds: rays that see a cloud from afar are walked with footprints.
#include <catch2/catch.hpp>

#include "sensor/capture/render.h"
#include "tests/support/rendered.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

TEST_CASE("clouds far away are rendered by coarse cells within their tolerance, near ones as without",
          "[sensor][render][footprint]") {
  // Two sources: the emission has to be followed segment by segment.
  CloudWish thin;
  thin.voxels = Vec3i(64);
  thin.density = [](const Vec3i& v) { return 1 + 0.3 * std::sin(0.1 * v.x) * std::sin(0.07 * v.z + 0.05 * v.y); };
  thin.extinction = 1e-4;
  thin.source = 1;
  CloudWish other = thin;
  other.source = 2;
  other.corner_m = {20, 0, 0};
  WorldContents contents = grey_contents(thin, 0.5);
  contents.clouds.push_back(make_cloud(other));
  const World world(std::move(contents));

  CameraSettings camera;
  camera.look_at_m = {42, 32, 32};
  camera.position_m = {42, -10000, 32};
  camera.resolution = {8, 6};
  SamplerSettings sampling;
  sampling.max_oversampling = 1;
  RadianceSettings exact, coarse;
  exact.footprint_tolerance = 0;
  const auto image = [&](double fov_deg, const RadianceSettings& settings) {
    camera.fov_deg = fov_deg;
    return test::render_pass(world, std::span<const PhotonMaps>(), Camera(camera), sampling, settings);
  };
  const Rendered far = image(0.5, coarse);  // pixels of 11 m
  const Rendered reference = image(0.5, exact);
  CHECK(far.counts.footprint.rays > 0);
  CHECK(far.counts.footprint.coarse > 0);
  CHECK(far.counts.footprint.error_bound <= coarse.footprint_tolerance);
  CHECK(reference.counts.footprint.rays == 0);
  CHECK(image(0.2, coarse).counts.footprint.rays == 0);  // pixels of 4 m
  sampling.max_oversampling = 16;                        // each stands for a sixteenth of its pixel
  CHECK(image(0.5, coarse).counts.footprint.rays == 0);
}
