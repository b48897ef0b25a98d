// Cutting slabs of a dense file into bricks.
#include "octree/source/slabs.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <mutex>

#include "octree/base/error.h"

namespace obscura::detail {
namespace {

std::size_t cells_of(const Box3i& box) noexcept {
  const Vec3i size = box.max - box.min;
  return std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z);
}

/// Slabs of eight layers, in the file's order: visit(box, values per grid).
template <class F>
void for_each_slab(const DenseGrids& dense, std::span<const std::size_t> grids, F&& visit) {
  std::vector<std::vector<float>> values(grids.size());
  const int layers = dense.resolution[dense.slab_axis];
  for (int begin = 0; begin < layers; begin += 8) {
    Box3i box(Vec3i(0), dense.resolution);
    box.min[dense.slab_axis] = begin;
    box.max[dense.slab_axis] = std::min(begin + 8, layers);
    for (std::size_t g = 0; g < grids.size(); ++g) {
      values[g].resize(cells_of(box));
      dense.read(grids[g], box, values[g]);
    }
    visit(box, values);
  }
}

void refuse_bad(const DenseGrids& dense, std::size_t grid, const Box3i& box, std::span<const float> values) {
  const bool non_negative = dense.grids[grid].require_non_negative;
  const auto bad =
      std::find_if(values.begin(), values.end(), [&](float v) { return !std::isfinite(v) || (non_negative && v < 0); });
  if (bad == values.end()) return;
  const auto place = static_cast<std::size_t>(bad - values.begin());
  const Vec3i size = box.max - box.min;
  const auto x = place % std::size_t(size.x), y = place / std::size_t(size.x) % std::size_t(size.y),
             z = place / (std::size_t(size.x) * std::size_t(size.y));
  throw InputError(dense.where[grid],
                   fmt::format("voxel ({}, {}, {}) holds {}", box.min.x + int(x), box.min.y + int(y),
                               box.min.z + int(z), std::isnan(*bad) ? std::string("NaN") : fmt::format("{}", *bad)),
                   std::isfinite(*bad) ? "values of this grid must not be negative"
                                       : "values must be finite; clean the grid where it is written");
}

void pour_slabs(const DenseGrids& dense, VoxelSink& sink) {
  std::vector<std::size_t> all(dense.grids.size());
  for (std::size_t g = 0; g < all.size(); ++g) all[g] = g;
  for_each_slab(dense, all, [&](const Box3i& box, const std::vector<std::vector<float>>& values) {
    for (std::size_t g = 0; g < all.size(); ++g) refuse_bad(dense, g, box, values[g]);
    const Vec3i size = box.max - box.min;
    const Vec3i bricks((size.x + 7) / 8, (size.y + 7) / 8, (size.z + 7) / 8);
    tbb::parallel_for(0, bricks.x * bricks.y * bricks.z, [&](int b) {
      const Vec3i low = Vec3i(b % bricks.x, b / bricks.x % bricks.y, b / (bricks.x * bricks.y)) * 8;
      std::vector<float> brick(512 * all.size(), 0.0f);
      std::vector<const float*> pointers;
      bool empty = true;
      for (std::size_t g = 0; g < all.size(); ++g) {
        float* const to = brick.data() + 512 * g;
        pointers.push_back(to);
        for (int z = 0; z < std::min(8, size.z - low.z); ++z)
          for (int y = 0; y < std::min(8, size.y - low.y); ++y) {
            const std::size_t row =
                (std::size_t(low.z + z) * std::size_t(size.y) + std::size_t(low.y + y)) * std::size_t(size.x) +
                std::size_t(low.x);
            for (int x = 0; x < std::min(8, size.x - low.x); ++x) {
              to[x + 8 * y + 64 * z] = values[g][row + std::size_t(x)];
              empty = empty && to[x + 8 * y + 64 * z] == 0;
            }
          }
      }
      if (!empty) sink.brick(box.min + low, pointers.data());
    });
  });
}

}  // namespace

VoxelStream stream_slabs(DenseGrids dense) {
  VoxelStream stream;
  stream.name = dense.name;
  stream.index_to_local = dense.index_to_local;
  stream.bounds = Box3i(Vec3i(0), dense.resolution);
  for (const GridRequest& grid : dense.grids) stream.channels.push_back(grid.name);
  stream.background.assign(dense.grids.size(), 0.0f);
  stream.units = dense.units;
  const auto shared = std::make_shared<const DenseGrids>(std::move(dense));
  stream.pour = [shared](VoxelSink& sink) { pour_slabs(*shared, sink); };
  return stream;
}

SlabRange range_of(const DenseGrids& dense, std::size_t grid) {
  SlabRange range;
  range.min = kInfinity;
  range.max = -kInfinity;
  for_each_slab(dense, std::span(&grid, 1), [&](const Box3i&, const std::vector<std::vector<float>>& values) {
    for (const float value : values[0]) {
      range.min = std::min<double>(range.min, value);
      range.max = std::max<double>(range.max, value);
      range.nonzero += value != 0;
    }
  });
  return range;
}

GridInfo describe_lattice(const std::string& name, const Affine& index_to_local, const Vec3i& resolution) {
  GridInfo info;
  info.name = name;
  info.resolution = resolution;
  info.bounds = Box3i(Vec3i(0), resolution);
  info.index_to_local = index_to_local;
  for (int axis = 0; axis < 3; ++axis) {
    const auto row = index_to_local[axis];
    info.voxel_m[axis] = Vec3d(row[0], row[1], row[2]).length();
  }
  info.bytes_dense =
      sizeof(float) * std::uint64_t(resolution.x) * std::uint64_t(resolution.y) * std::uint64_t(resolution.z);
  return info;
}

void check_resolution(const std::string& where, const Vec3i& resolution) {
  std::uint64_t cells = 1;
  for (int axis = 0; axis < 3; ++axis) {
    if (resolution[axis] < 1 || resolution[axis] > 1 << 20)
      throw InputError(where,
                       fmt::format("a resolution of {} x {} x {} can't be", resolution.x, resolution.y, resolution.z),
                       "each axis needs 1 to 1048576 voxels");
    cells *= static_cast<std::uint64_t>(resolution[axis]);
  }
  if (cells > std::uint64_t{1} << 40)
    throw InputError(where, fmt::format("{} voxels are too many", cells), "at most 2^40 are possible");
}

}  // namespace obscura::detail
