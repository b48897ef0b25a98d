// Worlds for tests: from a function of the voxel to a cloud with one medium in one grey band.
#pragma once

#include <functional>
#include <memory>

#include "octree/base/statistics.h"
#include "octree/build/build.h"
#include "photon/paths/radiance.h"
#include "photon/trace/light.h"
#include "photon/world/world.h"
#include "tests/support/rough_cloud.h"
#include "tests/support/voxel_fields.h"

namespace obscura::test {

struct CloudWish {
  Vec3i voxels{16, 16, 16};
  double voxel_m = 1;
  Vec3d stretch{1, 1, 1};  // of the voxels' sides
  std::function<double(const Vec3i&)> density = [](const Vec3i&) { return 1.0; };
  double extinction = 1;
  double albedo = 0;
  double source = 0;  // W/m2/sr
  PhaseFunction phase;
  std::array<double, 2> period_m{0, 0};
  Vec3d corner_m{0, 0, 0};
};

/// The rough cloud of rough_cloud.h, 3.2 m wide: optical depths up to 20.
inline CloudWish rough_wish(double albedo, double g = 0, double source = 0) {
  CloudWish wish;
  wish.voxels = Vec3i(kRoughSide);
  wish.density = [](const Vec3i& v) { return rough_density(v); };
  wish.voxel_m = 0.1;
  wish.extinction = 3;
  wish.albedo = albedo;
  wish.source = source;
  if (g != 0) wish.phase = PhaseFunction::henyey_greenstein(g);
  return wish;
}

/// A lossless cloud whose lower corner is at corner_m.
inline Cloud make_cloud(const CloudWish& wish) {
  VoxelStream stream = field_stream(Box3i(Vec3i(0), wish.voxels), {"density"},
                                    [&](int, const Vec3i& v) { return static_cast<float>(wish.density(v)); });
  stream.index_to_local.makeIdentity();
  for (int i = 0; i < 3; ++i) stream.index_to_local[i][i] = wish.voxel_m * wish.stretch[i];
  BuildSettings settings;
  settings.tolerance = 0;
  settings.measure.optical_weight = {wish.extinction};
  Cloud cloud;
  cloud.name = "test";
  cloud.octree = std::make_shared<const Octree>(build_octree(stream, settings).first);
  cloud.local_to_world = placement(wish.corner_m, Vec3d(0), 1);
  cloud.media.push_back({0, {wish.extinction}, {wish.albedo}, wish.phase});
  if (wish.source > 0) cloud.source = {wish.source};
  cloud.period_m = wish.period_m;
  return cloud;
}

/// One cloud in one grey band under a sky.
inline WorldContents grey_contents(const CloudWish& wish, double sky = 0) {
  WorldContents contents;
  contents.bands.emplace_back("grey");
  contents.clouds.push_back(make_cloud(wish));
  contents.sky = {sky};
  return contents;
}

/// Radiance along one ray as many independent rays see it, photon map included: mean and batch error.
struct RayRadiance {
  double mean = 0;
  double error = 0;  // of batches and rays
  double transmission = 0;
  double bias = 0;
};

inline RayRadiance ray_radiance(const World& world, const Light& light, const Ray& ray, int count,
                                const RadianceSettings& settings = {}, std::uint64_t first_history = 0) {
  std::vector<Ray> rays(static_cast<std::size_t>(count), ray);
  std::vector<std::uint64_t> histories;
  for (int i = 0; i < count; ++i) histories.push_back(first_history + static_cast<std::uint64_t>(i));
  std::vector<Incoming> incoming(rays.size());
  incoming_radiance({world, 0}, light.maps.empty() ? nullptr : &light.maps[0], settings, rays, histories, incoming);
  RayRadiance result;
  Moments total;
  std::array<double, kBatches> batches{};
  for (const Incoming& in : incoming) {
    total.add(in.total());
    result.transmission += in.transmission / count;
    result.bias += in.bias / count;
    for (std::size_t b = 0; b < batches.size(); ++b) batches[b] += in.map[b] / count;
  }
  result.mean = total.mean();
  result.error = std::hypot(total.standard_error(), batch_mean(batches).standard_error);
  return result;
}

}  // namespace obscura::test
