// A voxel stream poured into a dense array, for tests to look at.
#pragma once

#include <algorithm>
#include <mutex>
#include <vector>

#include "octree/source/voxels.h"

namespace obscura::test {

/// Holds stream.bounds densely; counts what is poured twice or, other than 0, outside the bounds.
class Dense {
 public:
  explicit Dense(const VoxelStream& stream)
      : channels_(stream.channels),
        low_(stream.bounds.min),
        size_(stream.bounds.isEmpty() ? Vec3i(0) : stream.bounds.max - stream.bounds.min) {
    const std::size_t cells = std::size_t(size_.x) * std::size_t(size_.y) * std::size_t(size_.z);
    values_.assign(channels_.size(), std::vector<float>(cells, 0.0f));
    std::vector<char> seen(cells, 0);
    std::mutex mutex;
    const auto put = [&](const Vec3i& voxel, auto&& value_of) {
      const Vec3i in = voxel - low_;
      if (in.x < 0 || in.y < 0 || in.z < 0 || in.x >= size_.x || in.y >= size_.y || in.z >= size_.z) {
        for (std::size_t c = 0; c < channels_.size(); ++c) outside_ += value_of(c) != 0;
        return;
      }
      const std::size_t place = index(in);
      twice_ += seen[place];
      seen[place] = 1;
      ++poured_;
      for (std::size_t c = 0; c < channels_.size(); ++c) values_[c][place] = value_of(c);
    };
    VoxelSink sink(
        [&](const Vec3i& corner, const float* const* values) {
          const std::lock_guard lock(mutex);
          ++bricks_;
          for (int v = 0; v < 512; ++v)
            put(corner + Vec3i(v & 7, (v >> 3) & 7, v >> 6), [&](std::size_t c) { return values[c][v]; });
        },
        [&](const Vec3i& corner, int level, std::span<const float> values) {
          const std::lock_guard lock(mutex);
          ++tiles_;
          for (int z = 0; z < 1 << level; ++z)
            for (int y = 0; y < 1 << level; ++y)
              for (int x = 0; x < 1 << level; ++x)
                put(corner + Vec3i(x, y, z), [&](std::size_t c) { return values[c]; });
        });
    stream.pour(sink);
  }

  Vec3i size() const { return size_; }
  float at(std::size_t channel, const Vec3i& in) const { return values_[channel][index(in)]; }
  const std::vector<float>& values(std::size_t channel) const { return values_[channel]; }
  double sum(std::size_t channel) const {
    double total = 0;
    for (const float value : values_[channel]) total += value;
    return total;
  }
  float min(std::size_t channel) const { return *std::min_element(values_[channel].begin(), values_[channel].end()); }
  float max(std::size_t channel) const { return *std::max_element(values_[channel].begin(), values_[channel].end()); }
  std::size_t nonzero(std::size_t channel) const {
    return values_[channel].size() - std::size_t(std::count(values_[channel].begin(), values_[channel].end(), 0.0f));
  }
  std::size_t bricks() const { return bricks_; }
  std::size_t tiles() const { return tiles_; }
  std::size_t poured() const { return poured_; }
  std::size_t twice() const { return twice_; }
  std::size_t outside() const { return outside_; }

 private:
  std::size_t index(const Vec3i& in) const {
    return (std::size_t(in.z) * std::size_t(size_.y) + std::size_t(in.y)) * std::size_t(size_.x) + std::size_t(in.x);
  }

  std::vector<std::string> channels_;
  Vec3i low_, size_;
  std::vector<std::vector<float>> values_;
  std::size_t bricks_ = 0, tiles_ = 0, poured_ = 0, twice_ = 0, outside_ = 0;
};

}  // namespace obscura::test
