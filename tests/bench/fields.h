// Fields for the benchmarks as OpenVDB grids: real clouds where they are at hand, a rough fractal and a
// smooth plume of any size, and the stream that pours a grid into the octree's builder.
#pragma once

#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Prune.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "octree/base/random.h"
#include "octree/source/voxels.h"
#include "tests/bench/noise.h"

namespace obscura::bench {

/// Fills a grid leaf by leaf from a function of the voxel; leaves that the function keeps 0 are not made.
/// `possible(centre, radius)` says whether anything can be in a ball of voxels.
template <class Possible, class Value>
openvdb::FloatGrid::Ptr make_grid(int n, Possible&& possible, Value&& value) {
  auto grid = openvdb::FloatGrid::create(0.0f);
  using Leaf = openvdb::FloatTree::LeafNodeType;
  const int bricks = n / 8;
  std::vector<std::vector<Leaf*>> layers(static_cast<std::size_t>(bricks));
  tbb::parallel_for(0, bricks, [&](int bx) {
    for (int by = 0; by < bricks; ++by) {
      for (int bz = 0; bz < bricks; ++bz) {
        const openvdb::Coord origin(8 * bx, 8 * by, 8 * bz);
        if (!possible(origin.x() + 4, origin.y() + 4, origin.z() + 4, 7.0)) continue;
        Leaf* leaf = nullptr;
        for (openvdb::Index i = 0; i < 512; ++i) {
          const openvdb::Coord at = origin + Leaf::offsetToLocalCoord(i);
          const float v = value(at.x(), at.y(), at.z());
          if (!(v > 0)) continue;
          if (!leaf) leaf = new Leaf(origin, 0.0f);
          leaf->setValueOn(i, v);
        }
        if (leaf) layers[static_cast<std::size_t>(bx)].push_back(leaf);
      }
    }
  });
  for (auto& layer : layers) {
    for (Leaf* leaf : layer) grid->tree().addLeaf(leaf);
  }
  return grid;
}

/// Billows down to the voxel inside a ball: rough in every cell.
inline openvdb::FloatGrid::Ptr rough_fractal(int n) {
  return make_grid(
      n,
      [=](double x, double y, double z, double r) {
        return std::hypot(x - 0.5 * n, y - 0.5 * n, z - 0.5 * n) < kFractalRadius * n + r;
      },
      [=](int x, int y, int z) { return fractal_density(n, x, y, z); });
}

/// A plume that bends and widens: smooth in every cell.
inline openvdb::FloatGrid::Ptr smooth_plume(int n) {
  const auto axis = [n](double z, double& x, double& y, double& width) {
    const double s = z / n;
    x = n * (0.25 + 0.45 * s * s);
    y = n * (0.5 + 0.05 * std::sin(6 * s));
    width = n * (0.03 + 0.1 * s);
  };
  return make_grid(
      n,
      [=](double x, double y, double z, double r) {
        double cx, cy, width;
        axis(z, cx, cy, width);
        return std::hypot(x - cx, y - cy) < 3.2 * width + 2 * r;
      },
      [=](int x, int y, int z) {
        double cx, cy, width;
        axis(z, cx, cy, width);
        const double q = ((x - cx) * (x - cx) + (y - cy) * (y - cy)) / (width * width);
        return q < 9 ? static_cast<float>(1e-2 * n * n / (width * width) * (std::exp(-0.5 * q) - std::exp(-4.5)))
                     : 0.0f;
      });
}

/// The first float grid of a file; null where the file is absent.
inline openvdb::FloatGrid::Ptr read_grid(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return nullptr;
  openvdb::io::File file(path.string());
  file.open();
  const openvdb::GridPtrVecPtr grids = file.getGrids();
  for (const openvdb::GridBase::Ptr& base : *grids) {
    if (auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(base)) return grid;
  }
  return nullptr;
}

/// Pours the grid: leaves in parallel, then active tiles. Voxels of one metre.
inline VoxelStream grid_stream(const openvdb::FloatGrid::Ptr& grid) {
  VoxelStream stream;
  stream.channels = {"density"};
  const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
  stream.bounds = Box3i(Vec3i(box.min().x(), box.min().y(), box.min().z()),
                        Vec3i(box.max().x() + 1, box.max().y() + 1, box.max().z() + 1));
  stream.name = "grid";
  stream.pour = [grid](VoxelSink& sink) {
    std::vector<const openvdb::FloatTree::LeafNodeType*> leaves;
    grid->tree().getNodes(leaves);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves.size(), 64), [&](const auto& range) {
      alignas(64) float values[512];
      const float* pointer = values;
      for (std::size_t l = range.begin(); l != range.end(); ++l) {
        const openvdb::FloatTree::LeafNodeType& leaf = *leaves[l];
        const float* from = leaf.buffer().data();
        for (int x = 0; x < 8; ++x) {
          for (int y = 0; y < 8; ++y) {
            for (int z = 0; z < 8; ++z) values[x + 8 * y + 64 * z] = *from++;
          }
        }
        if (leaf.onVoxelCount() != 512) {
          for (auto off = leaf.cbeginValueOff(); off; ++off) {
            const openvdb::Coord c = openvdb::FloatTree::LeafNodeType::offsetToLocalCoord(off.pos());
            values[c.x() + 8 * c.y() + 64 * c.z()] = 0;
          }
        }
        sink.brick(Vec3i(leaf.origin().x(), leaf.origin().y(), leaf.origin().z()), &pointer);
      }
    });
    auto tile = grid->tree().cbeginValueOn();
    tile.setMaxDepth(openvdb::FloatTree::ValueOnCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile) {
      const openvdb::CoordBBox extent = tile.getBoundingBox();
      const float value = *tile;
      int level = 3;
      while ((1 << level) < extent.dim().x()) ++level;
      sink.tile(Vec3i(extent.min().x(), extent.min().y(), extent.min().z()), level, {&value, 1});
    }
  };
  return stream;
}

}  // namespace obscura::bench
