#include "octree/build/collect.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <new>

#include "octree/base/error.h"

namespace obscura::detail {
namespace {

constexpr std::size_t kMaxChannels = 64;

std::string text(const Vec3i& v) { return fmt::format("({}, {}, {})", v.x, v.y, v.z); }

struct Range {
  float min, max;
  double sum;
};

// Eight interleaved lanes, so that the compiler can keep them in a vector and the sum is the same everywhere.
Range range_of(const float* values) noexcept {
  float min[8], max[8];
  double sum[8];
  for (int k = 0; k < 8; ++k) {
    min[k] = max[k] = values[k];
    sum[k] = static_cast<double>(values[k]);
  }
  for (int i = 8; i < 512; i += 8) {
    for (int k = 0; k < 8; ++k) {
      const float v = values[i + k];
      min[k] = v < min[k] ? v : min[k];
      max[k] = v > max[k] ? v : max[k];
      sum[k] += static_cast<double>(v);
    }
  }
  Range range{min[0], max[0], 0};
  for (int k = 0; k < 8; ++k) {
    range.min = std::min(range.min, min[k]);
    range.max = std::max(range.max, max[k]);
  }
  range.sum = ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
  return range;
}

// The largest level whose cells are all uniform: 0, 1 or 2.
int common_cell_level(const float* values) noexcept {
  for (int level = 1; level <= 2; ++level) {
    const int mask = (1 << level) - 1;
    for (int i = 0; i < 512; ++i) {
      const int first = i & ~(mask | mask << 3 | mask << 6);
      if (values[i] != values[first]) return level - 1;
    }
  }
  return 2;
}

class Collector {
 public:
  Collector(const VoxelStream& stream, const Progress& progress)
      : stream_(stream), progress_(progress), tree_(make_tree(stream)) {}

  void brick(const Vec3i& corner, const float* const* values) {
    const std::size_t channels = tree_.channels.size();
    Range ranges[kMaxChannels];
    bool zero = true, uniform = true;
    for (std::size_t c = 0; c < channels; ++c) {
      ranges[c] = range_of(values[c]);
      if (!std::isfinite(ranges[c].sum)) refuse(corner, c, std::span(values[c], 512));
      zero = zero && ranges[c].min == 0 && ranges[c].max == 0;
      uniform = uniform && ranges[c].min == ranges[c].max;
    }
    if (zero) return;
    const double part = domain_volume(tree_.domain, {corner, 3});
    if (part != 512) require_inside(corner, values);
    std::uint32_t& word = tree_.table[tree_.table_index(corner)];
    if (uniform) {
      float value[kMaxChannels];
      for (std::size_t c = 0; c < channels; ++c) value[c] = ranges[c].min;
      const std::lock_guard lock(mutex_);
      word = uniform_.word(store_, 3, {value, channels});
      return;
    }

    // A record of floats. Its leaves are as large as all channels allow.
    int level = 2;
    for (std::size_t c = 0; c < channels && level > 0; ++c) level = std::min(level, common_cell_level(values[c]));
    std::size_t bytes = channels * sizeof(ChannelHeader);
    ChannelHeader headers[kMaxChannels];
    for (std::size_t c = 0; c < channels; ++c) {
      const int bits = ranges[c].min == ranges[c].max ? 0 : 32;
      headers[c] = {ranges[c].min, bits ? ranges[c].max : 0.0f, static_cast<float>(ranges[c].sum / part),
                    ChannelHeader::make_meta(bits, level, bits ? bytes : c * sizeof(ChannelHeader))};
      bytes += packed_bytes(bits, level);
    }
    const std::lock_guard lock(mutex_);
    count();
    word = store_.add(bytes);
    std::byte* record = store_.at(word);
    std::memcpy(record, headers, channels * sizeof(ChannelHeader));
    for (std::size_t c = 0; c < channels; ++c) {
      if (headers[c].bits() == 0) continue;
      std::byte* data = record + headers[c].data_offset();
      if (level == 0) {
        std::memcpy(data, values[c], 512 * sizeof(float));
        continue;
      }
      const int side = 8 >> level;
      for (int i = 0; i < side * side * side; ++i) {
        const int at = ((i % side) | (i / side % side) << 3 | (i / (side * side)) << 6) << level;
        std::memcpy(data + 4 * i, values[c] + at, sizeof(float));
      }
    }
  }

  void tile(const Vec3i& corner, int level, std::span<const float> values) {
    assert(level >= 3 && values.size() == tree_.channels.size());
    bool zero = true;
    for (std::size_t c = 0; c < values.size(); ++c) {
      if (!std::isfinite(values[c])) refuse(corner, c, values.subspan(c, 1));
      zero = zero && values[c] == 0;
    }
    if (zero) return;

    // Word by word. Where the tile reaches out of the domain, a brick that holds zeros outside.
    const std::int64_t side = std::int64_t{1} << level;
    Vec3i first, last;
    for (int axis = 0; axis < 3; ++axis) {
      first[axis] = std::max(corner[axis], tree_.origin[axis]);
      last[axis] = static_cast<int>(std::min<std::int64_t>(
          corner[axis] + side, std::int64_t{tree_.origin[axis]} + 8 * std::int64_t{tree_.size[axis]}));
    }
    std::uint32_t word;
    {
      const std::lock_guard lock(mutex_);
      count();
      word = uniform_.word(store_, 3, values);
    }
    for (int z = first.z; z < last.z; z += 8) {
      for (int y = first.y; y < last.y; y += 8) {
        for (int x = first.x; x < last.x; x += 8) {
          const Vec3i at(x, y, z);
          if (domain_volume(tree_.domain, {at, 3}) == 512) {
            tree_.table[tree_.table_index(at)] = word;
          } else {
            overhanging(at, values);
          }
        }
      }
    }
  }

  TreeData take() {
    merge_equal(tree_, store_, uniform_);
    store_.release_to(tree_);
    finish(tree_);
    return std::move(tree_);
  }

 private:
  void count() {
    if ((++taken_ & 1023u) == 0) {
      progress_.report("reading voxels", taken_, 0);
      if (progress_.cancelled()) throw ResourceError(stream_.name, "cancelled while reading voxels");
    }
  }

  /// Importers check what they read. A stream of another origin may hold anything.
  [[noreturn]] void refuse(const Vec3i& corner, std::size_t channel, std::span<const float> values) const {
    const auto bad =
        std::find_if(values.begin(), values.end(), [](float v) { return !std::isfinite(v); }) - values.begin();
    const Vec3i voxel =
        corner + Vec3i(static_cast<int>(bad & 7), static_cast<int>(bad >> 3 & 7), static_cast<int>(bad >> 6));
    throw InputError(fmt::format("{}, {}", stream_.name, tree_.channels[channel]),
                     fmt::format("voxel {} holds {}", text(voxel), values[static_cast<std::size_t>(bad)]),
                     "values must be finite");
  }

  void require_inside(const Vec3i& corner, const float* const* values) const {
    for (int i = 0; i < 512; ++i) {
      const Vec3i voxel = corner + Vec3i(i & 7, (i >> 3) & 7, i >> 6);
      if (tree_.holds(voxel)) continue;
      for (std::size_t c = 0; c < tree_.channels.size(); ++c) {
        if (values[c][i] == 0) continue;
        throw InputError(
            fmt::format("{}, {}", stream_.name, tree_.channels[c]),
            fmt::format("voxel {} holds a value but lies outside the bounds that the source stated", text(voxel)),
            "repair the source's bounds");
      }
    }
  }

  void overhanging(const Vec3i& corner, std::span<const float> values) {
    std::vector<float> bricks(512 * values.size());
    std::vector<const float*> pointers(values.size());
    for (std::size_t c = 0; c < values.size(); ++c) {
      pointers[c] = &bricks[512 * c];
      for (int i = 0; i < 512; ++i) {
        if (tree_.holds(corner + Vec3i(i & 7, (i >> 3) & 7, i >> 6))) {
          bricks[512 * c + static_cast<std::size_t>(i)] = values[c];
        }
      }
    }
    brick(corner, pointers.data());
  }

  const VoxelStream& stream_;
  const Progress& progress_;
  TreeData tree_;
  std::mutex mutex_;  // over store_, uniform_ and taken_
  RecordStore store_;
  UniformRecords uniform_;
  std::uint64_t taken_ = 0;
};

}  // namespace

std::uint32_t RecordStore::add(std::size_t bytes) {
  bytes = (bytes + kRecordUnit - 1) / kRecordUnit * kRecordUnit;
  if (used_ + bytes + 2 * kRecordPadding > capacity_) {
    reserve(std::max(used_ + bytes, capacity_ + capacity_ / 2 + (std::size_t{1} << 20)));
  }
  const std::size_t at = used_;
  used_ += bytes;
  if (used_ > kMaxRecordBytes) {
    throw ResourceError("octree", fmt::format("more than {} GiB of voxels", kMaxRecordBytes >> 30),
                        "use a coarser grid or a tolerance");
  }
  return static_cast<std::uint32_t>(at / kRecordUnit);
}

void RecordStore::reserve(std::size_t bytes) {
  const std::size_t capacity = bytes + 2 * kRecordPadding;
  if (capacity <= capacity_) return;
  void* grown = std::realloc(memory_.get(), capacity);
  if (!grown) {
    throw ResourceError("octree", fmt::format("out of memory at {} MiB of voxels", bytes >> 20), "use a coarser grid");
  }
  static_cast<void>(memory_.release());
  memory_.reset(static_cast<std::byte*>(grown));
  if (capacity_ == 0) std::memset(memory_.get(), 0, kRecordPadding);
  capacity_ = capacity;
}

void RecordStore::release_to(TreeData& tree) {
  const std::size_t bytes = used_ + 2 * kRecordPadding;
  if (capacity_ < bytes) reserve(used_);
  std::memset(memory_.get() + kRecordPadding + used_, 0, kRecordPadding);
  if (void* fitted = std::realloc(memory_.get(), bytes)) {
    static_cast<void>(memory_.release());
    memory_.reset(static_cast<std::byte*>(fitted));
  }
  tree.memory = std::move(memory_);
  tree.record_bytes = used_;
  used_ = capacity_ = 0;
}

std::string UniformRecords::key(int level, std::span<const float> values) {
  std::string bytes(values.size_bytes() + 1, static_cast<char>(level));
  std::memcpy(bytes.data() + 1, values.data(), values.size_bytes());
  return bytes;
}

std::uint32_t UniformRecords::word(RecordStore& store, int level, std::span<const float> values) {
  const auto [entry, is_new] = words_.try_emplace(key(level, values), 0u);
  if (is_new) {
    entry->second = store.add(values.size() * sizeof(ChannelHeader));
    for (std::size_t c = 0; c < values.size(); ++c) {
      // The data offset points at the header itself: a kernel that reads a float there finds `offset`, the value.
      const ChannelHeader header{values[c], 0.0f, values[c],
                                 ChannelHeader::make_meta(0, level, c * sizeof(ChannelHeader))};
      std::memcpy(store.at(entry->second) + c * sizeof header, &header, sizeof header);
    }
  }
  return entry->second;
}

TreeData make_tree(const VoxelStream& stream) {
  if (stream.channels.empty()) throw InputError(stream.name, "has no channel");
  if (stream.channels.size() > kMaxChannels) {
    throw InputError(stream.name, fmt::format("has more than {} channels", kMaxChannels));
  }
  const double volume = linear_determinant(stream.index_to_local);
  if (!std::isfinite(volume) || volume == 0) {
    throw InputError(stream.name, "the transform from voxels to metres cannot be inverted",
                     "give it a voxel size that is not zero");
  }
  TreeData tree;
  tree.channels = stream.channels;
  tree.index_to_local = stream.index_to_local;
  tree.local_to_index = stream.index_to_local.inverse();
  tree.domain = stream.bounds;
  if (tree.domain.isEmpty() || tree.domain.min == tree.domain.max) tree.domain = Box3i(Vec3i(0), Vec3i(0));
  constexpr int kFarthest = 1 << 30;
  std::uint64_t words = 1;
  for (int axis = 0; axis < 3; ++axis) {
    int& low = tree.domain.min[axis];
    int& high = tree.domain.max[axis];
    if (low < -kFarthest || high > kFarthest) {
      throw ResourceError(stream.name, "voxel coordinates reach beyond 2^30", "use a coarser grid");
    }
    tree.origin[axis] = low & ~7;
    if (high <= low) high = low;
    tree.size[axis] = std::max(1, (high - tree.origin[axis] + 7) >> 3);
    words *= static_cast<std::uint64_t>(tree.size[axis]);
    if (words > kMaxTopCells) {
      throw ResourceError(stream.name,
                          fmt::format("its bounds {} to {} hold more than 2^26 bricks of 8^3 voxels",
                                      text(tree.domain.min), text(tree.domain.max)),
                          "use a coarser grid, or give far-apart clouds a file each");
    }
  }
  tree.table.assign(words, Word::empty(3));
  return tree;
}

TreeData collect(const VoxelStream& stream, const Progress& progress) {
  Collector collector(stream, progress);
  VoxelSink sink(
      [&](const Vec3i& corner, const float* const* values) { collector.brick(corner, values); },
      [&](const Vec3i& corner, int level, std::span<const float> values) { collector.tile(corner, level, values); });
  if (stream.pour) stream.pour(sink);
  return collector.take();
}

}  // namespace obscura::detail
