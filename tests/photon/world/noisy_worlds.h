// Worlds of noisy clouds, rays about them, and optical depths by the scalar walk.
#pragma once

#include <utility>
#include <vector>

#include "octree/base/random.h"
#include "photon/optics/sampling.h"
#include "photon/world/world.h"
#include "photon/world/world_walk.h"
#include "tests/support/worlds.h"

namespace obscura::test {

inline double noise_density(const Vec3i& v) { return voxel_noise(3, v, 1) < 0.3 ? 0.0 : voxel_noise(3, v, 2); }

inline CloudWish noisy(double extinction = 0.4) {
  CloudWish wish;
  wish.voxels = {11, 9, 7};
  wish.voxel_m = 0.5;
  wish.density = noise_density;
  wish.extinction = extinction;
  return wish;
}

inline World world_of(std::vector<Cloud> clouds, double sky = 0) {
  WorldContents contents;
  contents.bands.emplace_back("grey");
  contents.clouds = std::move(clouds);
  contents.sky = {sky};
  return World(std::move(contents));
}

/// Rays that start around the World and inside it.
inline std::vector<Ray> rays_about(const World& world, int count, double t_max = kInfinity) {
  Stream random(9, 0, 0);
  std::vector<Ray> rays;
  const double radius = world.bounds().size().length();
  for (int i = 0; i < count; ++i) {
    Vec3d through = world.bounds().min;
    for (int axis = 0; axis < 3; ++axis) through[axis] += random.uniform() * world.bounds().size()[axis];
    const Vec3d d = random_direction(random);
    rays.push_back({i % 3 == 0 ? through : through - radius * d, d, 0, t_max});
  }
  return rays;
}

inline double scalar_depth(const World& world, const Ray& ray) {
  double depth = 0;
  WorldWalk walk({world, 0}, ray);
  while (walk.next()) depth += walk.optics().extinction * (walk.end() - walk.begin());
  return depth;
}

}  // namespace obscura::test
