// Slabs of a periodic cloud for the references d1 to d7: layers from the top down, one cell wide.
#pragma once

#include "tests/support/worlds.h"

namespace obscura::test {

struct SlabLayer {
  double depth;
  double albedo;
  PhaseFunction phase;
};

struct SlabWish {
  std::vector<SlabLayer> layers;
  double mu0 = 0;  ///< of a sun of irradiance 1, in the plane of x and z, coming down; 0: none
  double sky = 0;
  double source = 0;
};

/// A cell of 8 x 8 m; each layer is a cloud of its own, 8 m high, the last at z = 0.
inline WorldContents slab_contents(const SlabWish& slab) {
  WorldContents contents;
  contents.bands.emplace_back("grey");
  contents.sky = {slab.sky};
  const auto count = static_cast<int>(slab.layers.size());
  for (int i = 0; i < count; ++i) {
    const SlabLayer& layer = slab.layers[static_cast<std::size_t>(i)];
    CloudWish wish;
    wish.voxels = Vec3i(8);
    wish.extinction = layer.depth / 8;
    wish.albedo = layer.albedo;
    wish.phase = layer.phase;
    wish.source = slab.source;
    wish.period_m = {8, 8};
    wish.corner_m = Vec3d(0, 0, 8.0 * (count - 1 - i));
    contents.clouds.push_back(make_cloud(wish));
  }
  if (slab.mu0 > 0) {
    Sun sun;
    sun.toward = Vec3d(-std::sqrt(1 - slab.mu0 * slab.mu0), 0, slab.mu0);
    sun.irradiance = {1};
    contents.sun = sun;
  }
  return contents;
}

}  // namespace obscura::test
