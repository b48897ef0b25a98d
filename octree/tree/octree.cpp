#include "octree/tree/octree.h"

#include <cassert>
#include <cmath>

namespace obscura {
namespace detail {
namespace {

// Bounds of a record as a whole, from its header alone.
Bounds record_bounds(const ChannelHeader& header) noexcept {
  const int bits = header.bits();
  if (bits == 0) return {header.offset, header.offset, header.mean};
  if (bits == 32) return {header.offset, header.scale, header.mean};
  // The largest value that unpack() can return, computed by the same operations.
  const float max = header.offset + header.scale * static_cast<float>((1u << bits) - 1u);
  return {header.offset, max, header.mean};
}

}  // namespace

Bounds cell_bounds(const TreeData& tree, int channel, const Cell& cell) noexcept {
  assert(channel >= 0 && channel < tree.channel_count());
  assert(cell.level >= 0 && tree.corner(cell.corner, cell.level) == cell.corner);
  // Outside the table there is nothing.
  const Vec3i at = cell.corner - tree.origin;
  for (int axis = 0; axis < 3; ++axis) {
    if (at[axis] < 0 || (at[axis] >> 3) >= tree.size[axis]) return {};
  }
  if (cell.level > 3) return tree.pyramid_bounds(cell.corner, std::min(cell.level, tree.top_level), channel);
  const std::uint32_t word = tree.word_at(cell.corner);
  if (Word::is_empty(word)) return {};
  const ChannelHeader& header = tree.header(word, channel);
  if (cell.level == 3 || header.bits() == 0) return record_bounds(header);

  // Below a brick: look at the leaves.
  const int level = header.cell_level();
  const int bits = 3 - level;
  const int side = std::max(1, (1 << cell.level) >> level);
  const Vec3i first((at.x & 7) >> level, (at.y & 7) >> level, (at.z & 7) >> level);
  Bounds result{kFloatMax, -kFloatMax, 0};
  double sum = 0;
  double volume = 0;
  for (int z = first.z; z < first.z + side; ++z) {
    for (int y = first.y; y < first.y + side; ++y) {
      for (int x = first.x; x < first.x + side; ++x) {
        const float value = unpack(tree.record(word), header, static_cast<unsigned>(x | y << bits | z << (2 * bits)));
        result.min = std::min(result.min, value);
        result.max = std::max(result.max, value);
        const Vec3i corner = tree.corner(cell.corner, 3) + Vec3i(x << level, y << level, z << level);
        const double part = domain_volume(tree.domain, {corner, level});
        sum += part * static_cast<double>(value);
        volume += part;
      }
    }
  }
  result.mean = volume > 0 ? static_cast<float>(sum / volume) : 0.0f;
  return result;
}

}  // namespace detail

namespace {

// The voxel that holds a point, or one outside the domain.
bool voxel_of(const Box3i& domain, const Vec3d& p, Vec3i& voxel) noexcept {
  if (!(p.x >= domain.min.x && p.x < domain.max.x && p.y >= domain.min.y && p.y < domain.max.y && p.z >= domain.min.z &&
        p.z < domain.max.z)) {
    return false;
  }
  voxel =
      Vec3i(static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y)), static_cast<int>(std::floor(p.z)));
  return true;
}

// Number of the leaf of a brick that holds a voxel.
unsigned leaf_of(const Vec3i& in_brick, int level) noexcept {
  const int bits = 3 - level;
  return static_cast<unsigned>((in_brick.x >> level) | (in_brick.y >> level) << bits |
                               (in_brick.z >> level) << (2 * bits));
}

}  // namespace

float Octree::value(int channel, const Vec3d& index_point) const noexcept {
  assert(channel >= 0 && channel < channel_count());
  Vec3i voxel;
  if (!voxel_of(data_.domain, index_point, voxel)) return 0;
  const std::uint32_t word = data_.word_at(voxel);
  if (detail::Word::is_empty(word)) return 0;
  const detail::ChannelHeader& header = data_.header(word, channel);
  if (header.bits() == 0) return header.offset;
  const Vec3i at = voxel - data_.origin;
  return detail::unpack(data_.record(word), header, leaf_of(Vec3i(at.x & 7, at.y & 7, at.z & 7), header.cell_level()));
}

float Octree::value(int channel, const Vec3d& index_point, int level) const noexcept {
  if (level <= 0) return value(channel, index_point);
  Vec3i voxel;
  if (!voxel_of(data_.domain, index_point, voxel)) return 0;
  const std::uint32_t word = data_.word_at(voxel);
  const int leaf = detail::Word::is_empty(word) ? detail::Word::empty_level(word) : data_.header(word, 0).cell_level();
  if (leaf >= level) return value(channel, index_point);
  return detail::cell_bounds(data_, channel, cell_at(voxel, std::min(level, data_.top_level))).mean;
}

Bounds Octree::bounds(int channel, const Cell& cell) const noexcept {
  return detail::cell_bounds(data_, channel, cell);
}

Vec3i Octree::block_voxel(std::uint32_t i) const noexcept {
  assert(i < block_count());
  const int at = static_cast<int>(data_.blocks[i]);
  const Vec3i& size = data_.size;
  return data_.origin + 8 * Vec3i(at % size.x, at / size.x % size.y, at / (size.x * size.y));
}

Block Octree::block(std::uint32_t i) const noexcept {
  const int level = data_.header(data_.table[data_.blocks[i]], 0).cell_level();
  return {{block_voxel(i), std::max(3, level)}, level >= 3};
}

void Octree::decode(std::uint32_t block, int channel, std::span<float, 512> out) const noexcept {
  assert(channel >= 0 && channel < channel_count());
  const std::uint32_t word = data_.table[data_.blocks[block]];
  detail::unpack_brick(data_.record(word), data_.header(word, channel), out);
}

OctreeStatistics Octree::statistics() const {
  OctreeStatistics s;
  s.leaves.assign(static_cast<std::size_t>(data_.top_level) + 1, 0);
  s.empty_leaves.assign(static_cast<std::size_t>(data_.top_level) + 1, 0);
  s.bits_per_value.assign(data_.channels.size(), 0);
  std::uint64_t stored = 0;
  for (std::uint32_t i = 0; i < block_count(); ++i) {
    const std::uint32_t word = data_.table[data_.blocks[i]];
    const int level = data_.header(word, 0).cell_level();
    const std::uint64_t leaves = level >= 3 ? 1 : std::uint64_t{512} >> (3 * level);
    s.leaves[static_cast<std::size_t>(level)] += leaves;
    ++(level >= 3 ? s.uniform_blocks : s.bricks);
    if (level >= 3) continue;
    stored += leaves;
    for (std::size_t c = 0; c < data_.channels.size(); ++c) {
      s.bits_per_value[c] += static_cast<double>(leaves) * data_.header(word, static_cast<int>(c)).bits();
    }
  }
  for (double& bits : s.bits_per_value) bits = stored ? bits / static_cast<double>(stored) : 0;

  // An empty leaf is counted at its first word.
  std::size_t at = 0;
  for (int z = 0; z < data_.size.z; ++z) {
    for (int y = 0; y < data_.size.y; ++y) {
      for (int x = 0; x < data_.size.x; ++x, ++at) {
        const std::uint32_t word = data_.table[at];
        if (!detail::Word::is_empty(word)) continue;
        const int level = detail::Word::empty_level(word);
        if (((x | y | z) & ((1 << (level - 3)) - 1)) == 0) ++s.empty_leaves[static_cast<std::size_t>(level)];
      }
    }
  }

  s.bytes_table = (data_.table.size() + data_.blocks.size()) * sizeof(std::uint32_t);
  for (const detail::PyramidLevel& level : data_.pyramid) s.bytes_pyramid += level.cells.size() * sizeof(Bounds);
  s.bytes_headers = std::min<std::uint64_t>(
      data_.record_bytes, std::uint64_t{block_count()} * data_.channels.size() * sizeof(detail::ChannelHeader));
  s.bytes_values = data_.record_bytes - s.bytes_headers;
  s.bytes = sizeof(Octree) + s.bytes_table + s.bytes_pyramid + data_.record_bytes + 2 * detail::kRecordPadding;
  const Vec3i extent = data_.domain.max - data_.domain.min;
  s.bytes_dense = static_cast<std::uint64_t>(extent.x) * static_cast<std::uint64_t>(extent.y) *
                  static_cast<std::uint64_t>(extent.z) * data_.channels.size() * sizeof(float);
  return s;
}

}  // namespace obscura
