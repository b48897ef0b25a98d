// Checking sparse grids and pouring several of one lattice into a sink as one stream.
#include "octree/source/sparse_grid.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <memory>
#include <mutex>
#include <tuple>

#include "octree/base/error.h"

namespace obscura::detail {
namespace {

constexpr int kBrickVoxels = 512;
constexpr std::array<int, 3> kLevels{3, 7, 12};

struct CornerOrder {
  bool operator()(const Vec3i& a, const Vec3i& b) const noexcept {
    return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x);
  }
};

Vec3i ancestor(const Vec3i& corner, int level) noexcept {
  const int mask = ~((1 << level) - 1);
  return {corner.x & mask, corner.y & mask, corner.z & mask};
}

Vec3i voxel_of_brick(const Vec3i& corner, int index) noexcept {
  return corner + Vec3i(index & 7, (index >> 3) & 7, index >> 6);
}

/// What a scan of some bricks found; `bad` is the place, in the file's order, of the first value that is refused.
struct Scan {
  Box3i bounds;
  float min = std::numeric_limits<float>::infinity();
  float max = -std::numeric_limits<float>::infinity();
  std::uint64_t bad = ~std::uint64_t{0};
  float bad_value = 0;

  void add(float value, const Vec3i& corner, int size, std::uint64_t place, bool non_negative) noexcept {
    if (!std::isfinite(value) || (non_negative && value < 0)) {
      if (place < bad) {
        bad = place;
        bad_value = value;
      }
      return;
    }
    min = std::min(min, value);
    max = std::max(max, value);
    if (value != 0) {
      bounds.extendBy(corner);
      bounds.extendBy(corner + Vec3i(size));
    }
  }
  void join(const Scan& other) noexcept {
    if (!other.bounds.isEmpty()) bounds.extendBy(other.bounds);
    min = std::min(min, other.min);
    max = std::max(max, other.max);
    if (other.bad < bad) {
      bad = other.bad;
      bad_value = other.bad_value;
    }
  }
};

[[noreturn]] void refuse_value(const std::string& where, const Vec3i& voxel, float value) {
  throw InputError(where,
                   fmt::format("voxel ({}, {}, {}) holds {}", voxel.x, voxel.y, voxel.z,
                               std::isnan(value) ? std::string("NaN") : fmt::format("{}", value)),
                   std::isfinite(value) ? "values of this grid must not be negative"
                                        : "values must be finite; clean the grid where it is written");
}

/// Bricks and tiles of several grids that together cover each block once.
struct Partition {
  std::vector<Vec3i> bricks;
  std::vector<std::pair<Vec3i, int>> tiles;
};

void sort_unique(std::vector<Vec3i>& corners) {
  std::sort(corners.begin(), corners.end(), CornerOrder{});
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
}

bool holds(const std::vector<Vec3i>& sorted, const Vec3i& corner) {
  return std::binary_search(sorted.begin(), sorted.end(), corner, CornerOrder{});
}

Partition partition(std::span<const SparseGrid> grids) {
  // Every brick once, and the tiles of every level.
  Partition result;
  std::array<std::vector<Vec3i>, kLevels.size()> tiles;
  for (const SparseGrid& grid : grids) {
    result.bricks.insert(result.bricks.end(), grid.bricks.begin(), grid.bricks.end());
    for (const SparseTile& tile : grid.tiles)
      tiles[static_cast<std::size_t>(std::find(kLevels.begin(), kLevels.end(), tile.level) - kLevels.begin())]
          .push_back(tile.corner);
  }
  sort_unique(result.bricks);
  for (auto& level : tiles) sort_unique(level);

  // From coarse to fine: a tile with a brick or a smaller tile of another grid inside is split.
  for (std::size_t level = kLevels.size(); level-- > 0;) {
    if (level == 0) {
      for (const Vec3i& corner : tiles[0])
        if (!holds(result.bricks, corner)) result.tiles.emplace_back(corner, kLevels[0]);
      break;
    }
    if (tiles[level].empty()) continue;
    std::vector<Vec3i> divided;
    const auto divide = [&](const std::vector<Vec3i>& finer) {
      for (const Vec3i& corner : finer) divided.push_back(ancestor(corner, kLevels[level]));
    };
    divide(result.bricks);
    for (std::size_t finer = 0; finer < level; ++finer) divide(tiles[finer]);
    sort_unique(divided);
    const int child = kLevels[level - 1];
    const int count = 1 << (kLevels[level] - child);
    for (const Vec3i& corner : tiles[level]) {
      if (!holds(divided, corner)) {
        result.tiles.emplace_back(corner, kLevels[level]);
        continue;
      }
      for (int z = 0; z < count; ++z)
        for (int y = 0; y < count; ++y)
          for (int x = 0; x < count; ++x) tiles[level - 1].push_back(corner + Vec3i(x, y, z) * (1 << child));
    }
    sort_unique(tiles[level - 1]);
  }
  return result;
}

/// Finds the brick or the uniform value of one grid at a block.
class Lookup {
 public:
  Lookup(const SparseGrid& grid, bool consume) : grid_(&grid), consume_(consume) {
    bricks_.reserve(grid.bricks.size());
    for (std::size_t i = 0; i < grid.bricks.size(); ++i) bricks_.emplace_back(grid.bricks[i], i);
    std::sort(bricks_.begin(), bricks_.end(),
              [](const auto& a, const auto& b) { return CornerOrder{}(a.first, b.first); });
    for (std::size_t level = 0; level < kLevels.size(); ++level) {
      for (const SparseTile& tile : grid.tiles)
        if (tile.level == kLevels[level]) tiles_[level].emplace_back(tile.corner, tile.value);
      std::sort(tiles_[level].begin(), tiles_[level].end(),
                [](const auto& a, const auto& b) { return CornerOrder{}(a.first, b.first); });
    }
  }

  /// @returns true with the values of the brick, or false with the one value that all its voxels have
  bool fill(const Vec3i& corner, std::span<float, kBrickVoxels> values) const {
    if (const auto* brick = find(bricks_, corner)) {
      grid_->read(*brick, values);
      if (consume_ && grid_->release) grid_->release(*brick);
      return true;
    }
    std::fill(values.begin(), values.end(), value(corner));
    return false;
  }
  float value(const Vec3i& corner) const {
    for (std::size_t level = 0; level < kLevels.size(); ++level)
      if (const float* tile = find(tiles_[level], ancestor(corner, kLevels[level]))) return *tile;
    return grid_->background;
  }

 private:
  template <class T>
  static const T* find(const std::vector<std::pair<Vec3i, T>>& sorted, const Vec3i& corner) {
    const auto place =
        std::lower_bound(sorted.begin(), sorted.end(), corner,
                         [](const auto& entry, const Vec3i& wanted) { return CornerOrder{}(entry.first, wanted); });
    return place != sorted.end() && place->first == corner ? &place->second : nullptr;
  }

  const SparseGrid* grid_;
  bool consume_;
  std::vector<std::pair<Vec3i, std::size_t>> bricks_;
  std::array<std::vector<std::pair<Vec3i, float>>, kLevels.size()> tiles_;
};

void pour_grids(std::span<const SparseGrid> grids, bool consume, const VoxelSink& sink) {
  const Partition blocks = partition(grids);
  std::vector<Lookup> lookups;
  for (const SparseGrid& grid : grids) lookups.emplace_back(grid, consume);
  const std::size_t channels = grids.size();

  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks.bricks.size(), 16), [&](const auto& range) {
    std::vector<float> values(channels * kBrickVoxels);
    std::vector<const float*> pointers(channels);
    for (std::size_t c = 0; c < channels; ++c) pointers[c] = values.data() + c * kBrickVoxels;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      for (std::size_t c = 0; c < channels; ++c)
        lookups[c].fill(blocks.bricks[i],
                        std::span<float, kBrickVoxels>(values.data() + c * kBrickVoxels, kBrickVoxels));
      if (std::any_of(values.begin(), values.end(), [](float v) { return v != 0; }))
        sink.brick(blocks.bricks[i], pointers.data());
    }
  });
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks.tiles.size(), 64), [&](const auto& range) {
    std::vector<float> values(channels);
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      for (std::size_t c = 0; c < channels; ++c) values[c] = lookups[c].value(blocks.tiles[i].first);
      if (std::any_of(values.begin(), values.end(), [](float v) { return v != 0; }))
        sink.tile(blocks.tiles[i].first, blocks.tiles[i].second, values);
    }
  });
}

}  // namespace

SparseRange check(const SparseGrid& grid) {
  // A background other than 0 fills space: only a request that expects it may get one.
  if (!std::isfinite(grid.background))
    throw InputError(grid.where, "the background value is not finite", "write it with a finite background");
  if (grid.background != 0 && !grid.request.fills_space)
    throw InputError(grid.where, fmt::format("a background of {} would fill all of space", grid.background),
                     "write the grid with background 0 (a level set: convert it to a fog volume)");
  if (grid.background < 0 && grid.request.require_non_negative)
    throw InputError(grid.where, fmt::format("the background is {}", grid.background),
                     "values of this grid must not be negative");

  // Every stored value; the first offender in the file's order is the one that is named.
  const bool non_negative = grid.request.require_non_negative;
  Scan scan = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, grid.bricks.size(), 16), Scan{},
      [&](const auto& range, Scan part) {
        std::array<float, kBrickVoxels> values;
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          grid.read(i, values);
          for (int v = 0; v < kBrickVoxels; ++v)
            part.add(values[v], voxel_of_brick(grid.bricks[i], v), 1, i * kBrickVoxels + v, non_negative);
        }
        return part;
      },
      [](Scan a, const Scan& b) {
        a.join(b);
        return a;
      });
  if (scan.bad != ~std::uint64_t{0})
    refuse_value(grid.where, voxel_of_brick(grid.bricks[scan.bad / kBrickVoxels], scan.bad % kBrickVoxels),
                 scan.bad_value);
  for (std::size_t i = 0; i < grid.tiles.size(); ++i)
    scan.add(grid.tiles[i].value, grid.tiles[i].corner, 1 << grid.tiles[i].level, i, non_negative);
  if (scan.bad != ~std::uint64_t{0}) refuse_value(grid.where, grid.tiles[scan.bad].corner, scan.bad_value);
  if (scan.min > scan.max) scan.min = scan.max = grid.background;
  return {scan.bounds, scan.min, scan.max};
}

bool same_lattice(const Affine& a, const Affine& b, const Box3i& bounds) {
  // How far the corners of the bounds lie apart in the two lattices, in voxels of b.
  if (linear_determinant(a) == 0 || linear_determinant(b) == 0) return false;
  const Affine between = a * b.inverse();
  double farthest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d p(corner & 1 ? bounds.max.x : bounds.min.x, corner & 2 ? bounds.max.y : bounds.min.y,
                  corner & 4 ? bounds.max.z : bounds.min.z);
    farthest = std::max(farthest, (transform_point(between, p) - p).length());
  }
  return farthest <= 1e-6;
}

std::vector<VoxelStream> make_streams(const std::string& name, std::vector<SparseGrid> grids, Reload reload) {
  struct Group {
    std::vector<SparseGrid> grids;
    Box3i bounds;
  };
  std::vector<Group> groups;
  for (SparseGrid& grid : grids) {
    if (linear_determinant(grid.index_to_local) == 0)
      throw InputError(grid.where, "the grid's transform has no volume", "give every axis a voxel size");
    const SparseRange range = check(grid);
    const auto home = std::find_if(groups.begin(), groups.end(), [&](const Group& group) {
      Box3i both = group.bounds;
      if (!range.bounds.isEmpty()) both.extendBy(range.bounds);
      if (both.isEmpty()) both = Box3i(Vec3i(0), Vec3i(1));
      return same_lattice(group.grids.front().index_to_local, grid.index_to_local, both);
    });
    Group& group = home == groups.end() ? groups.emplace_back() : *home;
    if (!range.bounds.isEmpty()) group.bounds.extendBy(range.bounds);
    if (!grid.extent.isEmpty()) group.bounds.extendBy(grid.extent);
    group.grids.push_back(std::move(grid));
  }

  std::vector<VoxelStream> streams;
  for (Group& group : groups) {
    VoxelStream stream;
    stream.name = name;
    stream.index_to_local = group.grids.front().index_to_local;
    stream.bounds = group.bounds.isEmpty() ? Box3i(Vec3i(0), Vec3i(0)) : group.bounds;
    for (const SparseGrid& grid : group.grids) {
      stream.channels.push_back(grid.request.name);
      stream.background.push_back(grid.background);
      stream.units.push_back(grid.units);
    }
    // A background that fills space fills whole bricks: the bounds reach to their ends.
    if (std::any_of(stream.background.begin(), stream.background.end(), [](float b) { return b != 0; }) &&
        !group.bounds.isEmpty()) {
      stream.bounds.min = ancestor(stream.bounds.min, 3);
      stream.bounds.max = ancestor(stream.bounds.max + Vec3i(7), 3);
    }
    struct State {
      std::mutex mutex;
      std::vector<SparseGrid> grids;
      std::vector<GridRequest> requests;
    };
    const auto state = std::make_shared<State>();
    for (const SparseGrid& grid : group.grids) state->requests.push_back(grid.request);
    state->grids = std::move(group.grids);
    stream.pour = [state, reload](const VoxelSink& sink) {
      if (!reload) return pour_grids(state->grids, false, sink);
      std::vector<SparseGrid> mine;
      {
        const std::lock_guard lock(state->mutex);
        mine.swap(state->grids);
      }
      if (mine.empty()) mine = reload(state->requests);
      pour_grids(mine, true, sink);
    };
    streams.push_back(std::move(stream));
  }
  return streams;
}

}  // namespace obscura::detail
