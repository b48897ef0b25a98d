// The immutable octree of a cloud: several channels on one topology, leaves at every level, guaranteed
// bounds in every cell. Walks are in walk.h and batch_walk.h; octree/build/build.h makes it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "octree/base/math.h"
#include "octree/tree/layout.h"

namespace obscura {

/// A piece of the tree that has a record: a brick (level 3, up to 512 different voxels) or a uniform leaf of level
/// >= 3. Leaves that are empty in all channels are no blocks.
struct Block {
  Cell cell;
  bool uniform = false;
};

struct OctreeStatistics {
  std::vector<std::uint64_t> leaves;        ///< non-empty leaves per level, index = level
  std::vector<std::uint64_t> empty_leaves;  ///< empty leaves per level >= 3 (empty voxels of bricks count as leaves)
  std::uint64_t bricks = 0;
  std::uint64_t uniform_blocks = 0;
  std::uint64_t bytes = 0;             ///< all that the octree holds
  std::uint64_t bytes_table = 0;       ///< top table and block list
  std::uint64_t bytes_headers = 0;     ///< record headers
  std::uint64_t bytes_values = 0;      ///< packed values, with the gaps between records
  std::uint64_t bytes_pyramid = 0;     ///< bounds above the bricks
  std::uint64_t bytes_dense = 0;       ///< float per voxel of the domain and channel
  std::vector<double> bits_per_value;  ///< per channel: mean over the bricks' stored values
};

/// Immutable; movable; share it as std::shared_ptr<const Octree>. All queries are thread-safe and noexcept.
class Octree {
 public:
  explicit Octree(detail::TreeData data) noexcept : data_(std::move(data)) {}

  int channel_count() const noexcept { return data_.channel_count(); }
  const std::vector<std::string>& channels() const noexcept { return data_.channels; }
  /// From index space, where voxel (i,j,k) spans [i,i+1)x[j,j+1)x[k,k+1), to the cloud's own metres.
  const Affine& index_to_local() const noexcept { return data_.index_to_local; }
  const Affine& local_to_index() const noexcept { return data_.local_to_index; }
  /// Voxels [min, max) that may hold a value; outside, every channel is 0.
  const Box3i& domain() const noexcept { return data_.domain; }
  /// One cell of this level holds the domain.
  int top_level() const noexcept { return data_.top_level; }
  /// That cell.
  Cell top() const noexcept { return {data_.origin, data_.top_level}; }
  /// The cell of a level, 0..top_level(), that holds a voxel. Cells of a level tile space from top().corner on.
  Cell cell_at(const Vec3i& voxel, int level) const noexcept { return {data_.corner(voxel, level), level}; }

  /// Value at a point of index space; a point on a face belongs to the voxel above it. 0 outside.
  float value(int channel, const Vec3d& index_point) const noexcept;
  /// Mean over the cell of this level that holds the point, or over its leaf where that is larger. 0 outside.
  float value(int channel, const Vec3d& index_point, int level) const noexcept;

  /// Bounds of a cell of level 0..top_level(), aligned as cell_at() makes them; 0 where it is outside the domain.
  Bounds bounds(int channel, const Cell& cell) const noexcept;
  /// Bounds of the whole tree.
  Bounds bounds(int channel) const noexcept { return bounds(channel, top()); }

  /// Calls f(const Cell&, std::span<const float> values) for every leaf with a value that is not 0, in a
  /// fixed order.
  template <class F>
  void for_each_leaf(F&& f) const;

  std::uint32_t block_count() const noexcept { return static_cast<std::uint32_t>(data_.blocks.size()); }
  Block block(std::uint32_t i) const noexcept;
  /// The 8^3 voxels of a brick, x fastest; a uniform block fills it with its value.
  void decode(std::uint32_t block, int channel, std::span<float, 512> out) const noexcept;

  OctreeStatistics statistics() const;

  /// For the walks.
  const detail::TreeData& data() const noexcept { return data_; }
  /// For the builder: takes the memory out again.
  detail::TreeData take() && noexcept { return std::move(data_); }

 private:
  Vec3i block_voxel(std::uint32_t i) const noexcept;

  detail::TreeData data_;
};

template <class F>
void Octree::for_each_leaf(F&& f) const {
  std::vector<float> values(data_.channels.size());
  for (std::uint32_t i = 0; i < block_count(); ++i) {
    const std::uint32_t word = data_.table[data_.blocks[i]];
    const int level = data_.header(word, 0).cell_level();
    const Cell cell = block(i).cell;
    const unsigned side_bits = level >= 3 ? 0u : static_cast<unsigned>(3 - level);
    for (unsigned leaf = 0; leaf < (1u << (3 * side_bits)); ++leaf) {
      const Vec3i at(static_cast<int>(leaf & ((1u << side_bits) - 1u)) << level,
                     static_cast<int>((leaf >> side_bits) & ((1u << side_bits) - 1u)) << level,
                     static_cast<int>(leaf >> (2 * side_bits)) << level);
      bool any = false;
      for (std::size_t c = 0; c < values.size(); ++c) {
        values[c] = detail::unpack(data_.record(word), data_.header(word, static_cast<int>(c)), leaf);
        any = any || values[c] != 0;
      }
      if (any) f(Cell{cell.corner + at, level}, std::span<const float>(values));
    }
  }
}

}  // namespace obscura
