// Joins two streams on different lattices: the second is sampled at the voxel centres of the first.
#include "octree/source/resample.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <mutex>
#include <unordered_map>

namespace obscura {
namespace {

struct CornerHash {
  std::size_t operator()(const Vec3i& c) const noexcept {
    std::uint64_t h = static_cast<std::uint32_t>(c.x) * 0x9E3779B97F4A7C15ull;
    h = (h ^ static_cast<std::uint32_t>(c.y)) * 0xC2B2AE3D27D4EB4Full;
    h = (h ^ static_cast<std::uint32_t>(c.z)) * 0x165667B19E3779F9ull;
    return static_cast<std::size_t>(h ^ (h >> 29));
  }
};

Vec3i ancestor(const Vec3i& voxel, int level) noexcept {
  const int mask = ~((1 << level) - 1);
  return {voxel.x & mask, voxel.y & mask, voxel.z & mask};
}

/// A stream held in memory for lookups by voxel.
class HeldStream {
 public:
  explicit HeldStream(const VoxelStream& stream) : stream_(&stream), channels_(stream.channels.size()) {
    background_ = stream.background;
    background_.resize(channels_, 0.0f);
    std::mutex mutex;
    VoxelSink sink(
        [&](const Vec3i& corner, const float* const* values) {
          std::vector<float> copy;
          copy.reserve(channels_ * 512);
          for (std::size_t c = 0; c < channels_; ++c) copy.insert(copy.end(), values[c], values[c] + 512);
          const std::lock_guard lock(mutex);
          bricks_.emplace(corner, std::move(copy));
        },
        [&](const Vec3i& corner, int level, std::span<const float> values) {
          const std::lock_guard lock(mutex);
          tiles_[level].emplace(corner, std::vector<float>(values.begin(), values.end()));
        });
    stream.pour(sink);
  }

  /// Where the values of the block around a voxel are, found once for many voxels of the block.
  struct Block {
    Vec3i corner{std::numeric_limits<int>::max()};
    const float* brick = nullptr;    // 512 per channel
    const float* uniform = nullptr;  // one per channel
  };
  float value(const Vec3i& voxel, std::size_t channel, Block& block) const {
    const Vec3i corner = ancestor(voxel, 3);
    if (block.corner != corner) block = find(corner);
    if (!block.brick) return block.uniform[channel];
    const Vec3i in = voxel - corner;
    return block.brick[channel * 512 + static_cast<std::size_t>(in.x + 8 * in.y + 64 * in.z)];
  }
  const VoxelStream& stream() const noexcept { return *stream_; }
  std::span<const float> background() const noexcept { return background_; }

  /// The values of the tile that holds the whole box of voxels; null where there is none.
  const std::vector<float>* tile_around(const Box3i& box) const {
    for (const auto& [level, tiles] : tiles_) {
      const Vec3i corner = ancestor(box.min, level);
      if (corner != ancestor(box.max - Vec3i(1), level)) continue;
      if (const auto found = tiles.find(corner); found != tiles.end()) return &found->second;
    }
    return nullptr;
  }

 private:
  Block find(const Vec3i& corner) const {
    if (const auto brick = bricks_.find(corner); brick != bricks_.end()) return {corner, brick->second.data(), nullptr};
    for (const auto& [level, tiles] : tiles_)
      if (const auto tile = tiles.find(ancestor(corner, level)); tile != tiles.end())
        return {corner, nullptr, tile->second.data()};
    return {corner, nullptr, background_.data()};
  }

  const VoxelStream* stream_;
  std::size_t channels_;
  std::vector<float> background_;
  std::unordered_map<Vec3i, std::vector<float>, CornerHash> bricks_;
  std::unordered_map<int, std::unordered_map<Vec3i, std::vector<float>, CornerHash>> tiles_;
};

/// Trilinear between the eight voxel centres around a point of the field's index space.
void sample(const HeldStream& field, const Vec3d& point, std::span<float> values, HeldStream::Block& block) {
  Vec3i low;
  Vec3d t;
  for (int axis = 0; axis < 3; ++axis) {
    const double shifted = point[axis] - 0.5;
    const double floor = std::floor(shifted);
    low[axis] = static_cast<int>(floor);
    t[axis] = shifted - floor;
    // On a lattice that coincides up to rounding the voxels' own values come back.
    if (t[axis] < 1e-9) t[axis] = 0;
    if (t[axis] > 1 - 1e-9) {
      t[axis] = 0;
      ++low[axis];
    }
  }
  for (std::size_t c = 0; c < values.size(); ++c) {
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3i step(corner & 1, (corner >> 1) & 1, corner >> 2);
      const double weight = (step.x ? t.x : 1 - t.x) * (step.y ? t.y : 1 - t.y) * (step.z ? t.z : 1 - t.z);
      if (weight > 0) sum += weight * field.value(low + step, c, block);
    }
    values[c] = static_cast<float>(sum);
  }
}

}  // namespace

VoxelStream resample(VoxelStream onto, VoxelStream field) {
  VoxelStream joined;
  joined.channels = onto.channels;
  joined.channels.insert(joined.channels.end(), field.channels.begin(), field.channels.end());
  joined.background = onto.background;
  joined.background.resize(onto.channels.size(), 0.0f);
  joined.background.insert(joined.background.end(), field.background.begin(), field.background.end());
  joined.background.resize(joined.channels.size(), 0.0f);
  joined.units = onto.units;
  joined.units.resize(onto.channels.size());
  joined.units.insert(joined.units.end(), field.units.begin(), field.units.end());
  joined.units.resize(joined.channels.size());
  joined.index_to_local = onto.index_to_local;
  joined.name = onto.name;

  joined.bounds = onto.bounds;

  const Affine to_field = onto.index_to_local * field.index_to_local.inverse();
  const auto state = std::make_shared<const std::pair<VoxelStream, VoxelStream>>(std::move(onto), std::move(field));
  joined.pour = [state, to_field](VoxelSink& sink) {
    const VoxelStream& base = state->first;
    const VoxelStream& field_stream = state->second;
    const HeldStream held(field_stream);
    const std::size_t first = base.channels.size();
    const std::size_t added = field_stream.channels.size();

    const auto brick = [&](const Vec3i& corner, const float* const* values) {
      std::vector<float> sampled(512 * added, 0.0f), at(added);
      HeldStream::Block block;
      for (int v = 0; v < 512; ++v) {
        const Vec3i voxel = corner + Vec3i(v & 7, (v >> 3) & 7, v >> 6);
        if (!base.bounds.intersects(voxel) || !base.bounds.intersects(voxel + Vec3i(1))) continue;
        const Vec3d centre = Vec3d(voxel) + Vec3d(0.5);
        sample(held, transform_point(to_field, centre), at, block);
        for (std::size_t c = 0; c < added; ++c) sampled[c * 512 + v] = at[c];
      }
      std::vector<const float*> pointers(values, values + first);
      for (std::size_t c = 0; c < added; ++c) pointers.push_back(sampled.data() + 512 * c);
      sink.brick(corner, pointers.data());
    };

    // A tile stays a tile where the field is uniform all around it; else it is divided.
    const std::function<void(const Vec3i&, int, std::span<const float>)> tile = [&](const Vec3i& corner, int level,
                                                                                    std::span<const float> values) {
      const Box3d box = transform_box(to_field, Box3d(Vec3d(corner), Vec3d(corner + Vec3i(1 << level))));
      Box3i reach;
      for (int axis = 0; axis < 3; ++axis) {
        reach.min[axis] = static_cast<int>(std::floor(box.min[axis])) - 1;
        reach.max[axis] = static_cast<int>(std::ceil(box.max[axis])) + 1;
      }
      const Box3i& filled = field_stream.bounds;
      bool apart = filled.isEmpty();
      for (int axis = 0; axis < 3; ++axis)
        apart = apart || reach.max[axis] <= filled.min[axis] || reach.min[axis] >= filled.max[axis];
      std::span<const float> uniform;
      if (apart)
        uniform = held.background();
      else if (const auto* around = held.tile_around(reach))
        uniform = *around;
      if (!uniform.empty()) {
        std::vector<float> all(values.begin(), values.end());
        all.insert(all.end(), uniform.begin(), uniform.end());
        sink.tile(corner, level, all);
      } else if (level == 3) {
        std::vector<float> flat(512 * first);
        std::vector<const float*> pointers;
        for (std::size_t c = 0; c < first; ++c) {
          std::fill_n(flat.begin() + static_cast<std::ptrdiff_t>(512 * c), 512, values[c]);
          pointers.push_back(flat.data() + 512 * c);
        }
        brick(corner, pointers.data());
      } else {
        tbb::parallel_for(0, 8, [&](int child) {
          tile(corner + Vec3i(child & 1, (child >> 1) & 1, child >> 2) * (1 << (level - 1)), level - 1, values);
        });
      }
    };
    VoxelSink joining(brick, tile);
    base.pour(joining);
  };
  return joined;
}

}  // namespace obscura
