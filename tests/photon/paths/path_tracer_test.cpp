// The path tracer against brute force, closed forms and its own error.
#include "photon/paths/path_tracer.h"

#include <catch2/catch.hpp>

#include "octree/base/error.h"
#include "octree/base/statistics.h"
#include "photon/optics/sampling.h"
#include "tests/support/agree.h"
#include "tests/support/analogue.h"
#include "tests/support/rough_cloud.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

BatchMean path_mean(const World& world, const Ray& ray, int rays, const PathSettings& settings = {}) {
  const std::vector<Ray> all(static_cast<std::size_t>(rays), ray);
  std::vector<std::uint64_t> histories(all.size());
  for (std::size_t i = 0; i < histories.size(); ++i) histories[i] = i;
  std::vector<Incoming> incoming(all.size());
  const RadianceCounts counts = path_radiance({world, 0}, settings, all, histories, incoming);
  CHECK(counts.anomalies == 0);
  Moments total;
  for (const Incoming& in : incoming) total.add(in.total());
  return {total.mean(), total.standard_error()};
}

}  // namespace

TEST_CASE("paths and brute force agree on a rough cloud", "[path][agreement]") {
  struct Setting {
    const char* name;
    double albedo, g, source, sky, sun;
  };
  const Setting settings[] = {{"thermal", 0.6, 0.3, 2.0, 0.3, 0},
                              {"sky", 0.9, 0.6, 0, 1.0, 0},
                              {"sun", 0.9, 0.6, 0, 0.0, 3.0},
                              {"all", 0.95, -0.4, 0.5, 0.2, 2.0}};
  const Vec3d toward = Vec3d(0.3, -0.5, 0.8).normalized();
  const Ray views[] = {{{1.6, -5, 2.5}, Vec3d(0.02, 6.6, -0.9).normalized(), 0, kInfinity},
                       {{1.63, 1.57, 1.61}, Vec3d(1, 0.1, -0.3).normalized(), 0, kInfinity}};
  for (const Setting& setting : settings) {
    const CloudWish wish = rough_wish(setting.albedo, setting.g, setting.source);
    WorldContents contents = grey_contents(wish, setting.sky);
    if (setting.sun > 0) contents.sun = Sun{toward, {setting.sun}, 0.01};
    const World world(std::move(contents));
    AnalogueScene scene;
    scene.box = Box3d(Vec3d(0), Vec3d(kRoughSide * wish.voxel_m));
    scene.medium = [&](const Vec3d& x) {
      const Vec3i voxel(static_cast<int>(std::floor(x.x / wish.voxel_m)),
                        static_cast<int>(std::floor(x.y / wish.voxel_m)),
                        static_cast<int>(std::floor(x.z / wish.voxel_m)));
      return AnalogueMedium{wish.extinction * rough_density(voxel), setting.albedo, setting.source};
    };
    scene.majorant = wish.extinction * 4.1;
    scene.g = setting.g;
    scene.sky = setting.sky;
    scene.sun = setting.sun;
    scene.toward_sun = toward;
    Analogue analogue(scene, 5);
    for (const Ray& view : views) {
      INFO(setting.name);
      const Moments reference = analogue.radiance(view.origin, view.direction, 60000);
      for (const int paths : {1, 8}) {
        PathSettings many;
        many.paths = paths;
        const BatchMean found = path_mean(world, view, 60000 / paths, many);
        CHECK(agree(found.mean, found.standard_error, reference.mean(),
                    {.resolution = 0.17, .reference_error = reference.standard_error(), .comparisons = 16}));
      }
    }
  }
}
