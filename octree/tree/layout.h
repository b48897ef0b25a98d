// The memory of an Octree, drawn once: immutable, pointer-free but for its four arrays, made by the
// builder, read by octree.h and the walks. octree/README.md draws it. Not for callers of octree.h.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "octree/base/math.h"

namespace obscura {

/// Guaranteed bounds of a channel in a cell, rounded outward, and its mean over the cell's part in the domain.
struct Bounds {
  float min = 0;
  float max = 0;
  float mean = 0;
};

/// The cube of voxels [corner, corner + 2^level).
struct Cell {
  Vec3i corner{0, 0, 0};
  int level = 0;
};

namespace detail {

/// A word of the top table, one per 8^3 voxels: an empty leaf with its level, or where a record is.
struct Word {
  static constexpr std::uint32_t kEmpty = 0x80000000u;
  static constexpr std::uint32_t empty(int level) noexcept { return kEmpty | static_cast<std::uint32_t>(level); }
  static constexpr bool is_empty(std::uint32_t word) noexcept { return (word & kEmpty) != 0; }
  static constexpr int empty_level(std::uint32_t word) noexcept { return static_cast<int>(word & 31u); }
  /// An empty word also holds how many bricks away the nearest brick is that is not empty, counted along the axis on
  /// which it is farthest. All bricks nearer than that are empty, so a ray may skip them in any direction. 0: not
  /// known.
  static constexpr int kMaxDistance = 255;
  static constexpr std::uint32_t with_distance(std::uint32_t word, int distance) noexcept {
    return word | static_cast<std::uint32_t>(distance) << 5;
  }
};

inline constexpr float kFloatMax = std::numeric_limits<float>::max();

/// Records start at multiples of this many bytes; a word counts in these.
inline constexpr std::size_t kRecordUnit = 16;
/// Bytes that may be read before the first and after the last record's values.
inline constexpr std::size_t kRecordPadding = 512;

/// One channel of a record. A record is channel_count headers and then each channel's packed values.
/// bits 0: uniform, the value is `offset`; 1..24: value = offset + scale * q, q of so many bits, and offset
/// and offset + scale * (2^bits - 1) bound it; 32: float values, offset is their minimum and scale their maximum.
struct ChannelHeader {
  float offset;
  float scale;
  float mean;          ///< over the record's part in the domain
  std::uint32_t meta;  ///< bits | cell level << 6 | (data - record) / 4 << 11

  int bits() const noexcept { return static_cast<int>(meta & 63u); }
  /// Level of the record's leaves: 0..2 in a brick, >= 3 for a uniform leaf; the same in all channels.
  int cell_level() const noexcept { return static_cast<int>((meta >> 6) & 31u); }
  std::size_t data_offset() const noexcept { return std::size_t{meta >> 11} * 4; }

  static std::uint32_t make_meta(int bits, int cell_level, std::size_t data_offset) noexcept {
    assert(bits >= 0 && bits <= 32 && cell_level >= 0 && cell_level < 32);
    assert(data_offset % 4 == 0 && data_offset / 4 < (1u << 21));
    return static_cast<std::uint32_t>(bits) | static_cast<std::uint32_t>(cell_level) << 6 |
           static_cast<std::uint32_t>(data_offset / 4) << 11;
  }
};
static_assert(sizeof(ChannelHeader) == 16);

/// Value number i of a channel; i counts the record's leaves, x fastest. 0 for a uniform record.
inline float unpack(const std::byte* record, const ChannelHeader& header, unsigned i) noexcept {
  const unsigned bits = header.meta & 63u;
  const std::byte* data = record + header.data_offset();
  std::uint32_t word;
  if (bits == 32) {
    float value;
    std::memcpy(&value, data + 4 * std::size_t{i}, 4);
    return value;
  }
  const unsigned at = i * bits;
  std::memcpy(&word, data + (at >> 3), 4);
  const std::uint32_t q = (word >> (at & 7u)) & ((1u << bits) - 1u);
  return header.offset + header.scale * static_cast<float>(q);
}

/// All 8^3 voxels of a record, x fastest.
inline void unpack_brick(const std::byte* record, const ChannelHeader& header, std::span<float, 512> out) noexcept {
  if (header.bits() == 0) {
    std::fill(out.begin(), out.end(), header.offset);
    return;
  }
  const int level = header.cell_level();
  const int bits = 3 - level;
  if (level == 0 && header.bits() == 32) {
    std::memcpy(out.data(), record + header.data_offset(), 512 * sizeof(float));
    return;
  }
  for (int i = 0; i < 512; ++i) {
    const int x = (i & 7) >> level, y = ((i >> 3) & 7) >> level, z = (i >> 6) >> level;
    out[static_cast<std::size_t>(i)] = unpack(record, header, static_cast<unsigned>(x | y << bits | z << (2 * bits)));
  }
}

/// Voxels of a cell that lie in the domain.
inline double domain_volume(const Box3i& domain, const Cell& cell) noexcept {
  double volume = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = std::max<double>(domain.min[axis], cell.corner[axis]);
    const double high = std::min<double>(
        domain.max[axis], static_cast<double>(cell.corner[axis]) + static_cast<double>(std::int64_t{1} << cell.level));
    volume *= std::max(0.0, high - low);
  }
  return volume;
}

/// Bytes of a channel's packed values, a multiple of 4.
inline std::size_t packed_bytes(int bits, int cell_level) noexcept {
  if (bits == 0) return 0;
  const std::size_t values = std::size_t{512} >> (3 * cell_level);
  return (values * static_cast<std::size_t>(bits) + 31) / 32 * 4;
}

/// Cells of one level above the bricks: dense, x fastest, channel_count bounds each.
struct PyramidLevel {
  Vec3i size{0, 0, 0};
  std::vector<Bounds> cells;
};

struct FreeDeleter {
  void operator()(std::byte* memory) const noexcept { std::free(memory); }
};

struct TreeData {
  std::vector<std::string> channels;
  Affine index_to_local, local_to_index;
  Box3i domain;           ///< [min, max)
  Vec3i origin{0, 0, 0};  ///< of the table: domain.min rounded down to multiples of 8
  Vec3i size{0, 0, 0};    ///< of the table, in words
  int top_level = 3;
  std::vector<std::uint32_t> table;                  ///< x fastest
  std::vector<std::uint32_t> blocks;                 ///< index into the table of each block's first word, ascending
  std::vector<PyramidLevel> pyramid;                 ///< level 4, 5, ... top_level
  std::unique_ptr<std::byte[], FreeDeleter> memory;  ///< kRecordPadding bytes, the records, kRecordPadding bytes
  std::size_t record_bytes = 0;
  bool lossless = true;  ///< all values are floats (or uniform); else all are packed

  int channel_count() const noexcept { return static_cast<int>(channels.size()); }
  const std::byte* records() const noexcept { return memory.get() + kRecordPadding; }
  const std::byte* record(std::uint32_t word) const noexcept {
    assert(!Word::is_empty(word) && std::size_t{word} * kRecordUnit < record_bytes);
    return records() + std::size_t{word} * kRecordUnit;
  }
  const ChannelHeader& header(std::uint32_t word, int channel) const noexcept {
    return *reinterpret_cast<const ChannelHeader*>(record(word) +
                                                   sizeof(ChannelHeader) * static_cast<std::size_t>(channel));
  }
  std::size_t table_index(const Vec3i& voxel) const noexcept {
    return (static_cast<std::size_t>((voxel.z - origin.z) >> 3) * static_cast<std::size_t>(size.y) +
            static_cast<std::size_t>((voxel.y - origin.y) >> 3)) *
               static_cast<std::size_t>(size.x) +
           static_cast<std::size_t>((voxel.x - origin.x) >> 3);
  }
  std::uint32_t word_at(const Vec3i& voxel) const noexcept { return table[table_index(voxel)]; }
  bool holds(const Vec3i& voxel) const noexcept {
    return voxel.x >= domain.min.x && voxel.x < domain.max.x && voxel.y >= domain.min.y && voxel.y < domain.max.y &&
           voxel.z >= domain.min.z && voxel.z < domain.max.z;
  }
  /// Level of the leaf, or 3 where there is a brick.
  int block_level(std::uint32_t word) const noexcept {
    if (Word::is_empty(word)) return Word::empty_level(word);
    return std::max(3, header(word, 0).cell_level());
  }
  /// Corner of the cell of a level that holds a voxel. Cells are aligned to the table's origin.
  Vec3i corner(const Vec3i& voxel, int level) const noexcept {
    const auto align = [level](int v, int o) { return (((v - o) >> level) << level) + o; };
    return {align(voxel.x, origin.x), align(voxel.y, origin.y), align(voxel.z, origin.z)};
  }
  /// Bounds of a cell of level >= 4 that lies in the table.
  const Bounds& pyramid_bounds(const Vec3i& voxel, int level, int channel) const noexcept {
    const PyramidLevel& cells = pyramid[static_cast<std::size_t>(level - 4)];
    const std::size_t index =
        (static_cast<std::size_t>((voxel.z - origin.z) >> level) * static_cast<std::size_t>(cells.size.y) +
         static_cast<std::size_t>((voxel.y - origin.y) >> level)) *
            static_cast<std::size_t>(cells.size.x) +
        static_cast<std::size_t>((voxel.x - origin.x) >> level);
    return cells.cells[index * channels.size() + static_cast<std::size_t>(channel)];
  }
};

/// Bounds and mean of a cell of any level, aligned to the table's origin.
Bounds cell_bounds(const TreeData& tree, int channel, const Cell& cell) noexcept;

}  // namespace detail
}  // namespace obscura
