// What a user would take instead of the octree's walk: a NanoVDB grid walked by a hierarchical DDA in
// double with the leaf's pointer at hand, and a dense array walked by a DDA.
#pragma once

#include <nanovdb/NanoVDB.h>
#include <nanovdb/util/Ray.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "octree/base/math.h"

namespace obscura::bench {

/// Optical depth through a NanoVDB grid in index space (voxel i spans [i, i+1)). NanoVDB's own HDDA takes the
/// minimum of times in float; this one keeps its scheme (one DDA whose step is the node's size, Amanatides and Woo
/// inside leaves) in double throughout.
class NanoWalk {
 public:
  explicit NanoWalk(const nanovdb::NanoGrid<float>& grid) : tree_(&grid.tree()), box_(grid.tree().root().bbox()) {}

  double depth(const Ray& ray) const noexcept {
    const auto accessor = tree_->getAccessor();
    Box3d box(Vec3d(box_.min()[0], box_.min()[1], box_.min()[2]),
              Vec3d(box_.max()[0] + 1.0, box_.max()[1] + 1.0, box_.max()[2] + 1.0));
    auto [t, leave] = clip(ray, box);
    if (!(t < leave)) return 0;
    double inverse[3], next[3], delta[3];
    int step[3];
    nanovdb::Coord at;
    const Vec3d start = ray.at(t);
    for (int a = 0; a < 3; ++a) {
      at[a] = std::clamp(static_cast<int>(std::floor(start[a])), box_.min()[a], box_.max()[a]);
      const double d = ray.direction[a];
      inverse[a] = d == 0 ? 0 : 1 / d;
      step[a] = d > 0 ? 1 : d < 0 ? -1 : 0;
      delta[a] = std::abs(inverse[a]);
    }
    // Times of the next planes of the cell of this size that holds `at`.
    const auto set_planes = [&](int size) {
      for (int a = 0; a < 3; ++a) {
        if (step[a] == 0) {
          next[a] = kInfinity;
          continue;
        }
        const int corner = at[a] & ~(size - 1);
        next[a] = ((step[a] > 0 ? corner + size : corner) - ray.origin[a]) * inverse[a];
      }
    };
    double depth = 0;
    const nanovdb::NanoLeaf<float>* leaf = accessor.probeLeaf(at);
    if (leaf) set_planes(1);
    while (t < leave) {
      if (leaf) {
        // Voxel by voxel until the leaf changes; the DDA goes on from one leaf into the next.
        const float* values = leaf->data()->mValues;
        const nanovdb::Coord origin(at[0] & ~7, at[1] & ~7, at[2] & ~7);
        for (;;) {
          const float value = values[(at[0] & 7) << 6 | (at[1] & 7) << 3 | (at[2] & 7)];
          const int a = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
          const double to = std::min(next[a], leave);
          depth += static_cast<double>(value) * (to - t);
          t = to;
          next[a] += delta[a];
          at[a] += step[a];
          if ((at[a] & ~7) != origin[a] || t >= leave) break;
        }
        if (t >= leave) break;
        leaf = accessor.probeLeaf(at);
        continue;
      }
      // A tile: over it at once, then find the voxel behind it.
      const int size = static_cast<int>(accessor.getDim(at, nanovdb::Ray<double>()));
      const float value = accessor.getValue(at);
      set_planes(size);
      const int a = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
      const double to = std::min(next[a], leave);
      depth += static_cast<double>(value) * (to - t);
      t = to;
      const Vec3d p = ray.at(t);
      for (int b = 0; b < 3; ++b) {
        const int corner = at[b] & ~(size - 1);
        if (b == a) {
          at[b] = step[b] > 0 ? corner + size : corner - 1;
        } else {
          at[b] = std::clamp(nanovdb::Floor(p[b]), corner, corner + size - 1);
        }
      }
      leaf = accessor.probeLeaf(at);
      if (leaf) {
        set_planes(1);
        for (int b = 0; b < 3; ++b) {
          if (next[b] < t) next[b] = t;  // rounding at a plane
        }
      }
    }
    return depth;
  }

 private:
  const nanovdb::NanoTree<float>* tree_;
  nanovdb::CoordBBox box_;
};

/// Optical depth through a dense array, x fastest.
class DenseWalk {
 public:
  DenseWalk(Vec3i low, Vec3i size)
      : low_(low),
        size_(size),
        values_(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
                static_cast<std::size_t>(size.z)) {}

  float& value(const Vec3i& v) { return values_[index(v.x - low_.x, v.y - low_.y, v.z - low_.z)]; }
  std::size_t bytes() const { return values_.size() * sizeof(float); }

  double depth(const Ray& ray) const noexcept {
    auto [t, leave] = clip(ray, Box3d(Vec3d(low_), Vec3d(low_ + size_)));
    if (!(t < leave)) return 0;
    int at[3], step[3];
    double next[3], delta[3];
    std::ptrdiff_t stride[3] = {1, size_.x, static_cast<std::ptrdiff_t>(size_.x) * size_.y};
    const Vec3d start = ray.at(t);
    for (int a = 0; a < 3; ++a) {
      at[a] = std::clamp(static_cast<int>(std::floor(start[a])) - low_[a], 0, size_[a] - 1);
      const double d = ray.direction[a];
      step[a] = d > 0 ? 1 : d < 0 ? -1 : 0;
      delta[a] = d == 0 ? kInfinity : std::abs(1 / d);
      next[a] = d == 0 ? kInfinity : (low_[a] + at[a] + (d > 0 ? 1 : 0) - ray.origin[a]) / d;
      stride[a] *= step[a];
    }
    const float* value = &values_[index(at[0], at[1], at[2])];
    double depth = 0;
    for (;;) {
      const int a = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
      const double to = std::min(next[a], leave);
      depth += static_cast<double>(*value) * (to - t);
      t = to;
      if (t >= leave) return depth;
      at[a] += step[a];
      if (at[a] < 0 || at[a] >= size_[a]) return depth;
      next[a] += delta[a];
      value += stride[a];
    }
  }

 private:
  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size_.y) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size_.x) +
           static_cast<std::size_t>(x);
  }
  Vec3i low_, size_;
  std::vector<float> values_;
};

}  // namespace obscura::bench
