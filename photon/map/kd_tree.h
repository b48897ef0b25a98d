// A kd-tree over photons, sorted in place into buckets of sixteen: 24 bytes a photon and 0.75 beside.
// It finds the nearest; what they mean is the density estimate's business.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "photon/map/photon.h"

namespace obscura {

/// The nearest photons that a query has found so far. It lives on the stack (66 KB, of which a query
/// touches 16 bytes a neighbour), so that a query allocates nothing, and is handed from query to query
/// where the search goes on over shifted copies of the photons.
class Nearest {
 public:
  static constexpr int kMax = 4096;  ///< most neighbours of one query

  /// @param k               how many to find, clamped to 1 .. kMax
  /// @param max_distance2   photons at this squared distance (m2) or farther are not found
  explicit Nearest(int k, float max_distance2 = std::numeric_limits<float>::infinity()) noexcept;

  int count() const noexcept { return count_; }
  int wanted() const noexcept { return k_; }
  bool full() const noexcept { return count_ == k_; }
  /// All are as far as the farthest.
  bool all_equal() const noexcept;
  /// Squared distance (m2) that a photon must not exceed to be among the nearest.
  float bound() const noexcept { return bound_; }

  /// Squared distance (m2) and index of the i-th; the farthest is the last, else in no order. Equal
  /// distances: the lower index is the nearer.
  float distance2(int i) const noexcept { return distance2_[i]; }
  std::uint32_t index(int i) const noexcept { return index_[i]; }

 private:
  friend class KdTree;
  static constexpr int kBucket = 16;
  static constexpr int kCapacity = 2 * kMax + 4 * kBucket;

  int count_within(float distance2) const noexcept;
  /// Keeps the k nearest, up to `most` and equally far ones, and tightens the bound.
  void reduce(int most) noexcept;
  int farthest() const noexcept;
  void finish() noexcept;

  int k_;
  int count_ = 0;
  int full_;  ///< reduce when the count passes it
  float bound_;
  alignas(16) float distance2_[kCapacity];
  std::uint32_t index_[kCapacity];
};

/// Immutable. The same bits for any number of threads.
class KdTree {
 public:
  KdTree() = default;
  /// Takes the photons and reorders them; O(n log n), in parallel. Positions must be finite.
  explicit KdTree(std::vector<Photon> photons);

  /// In the tree's order, which is the order that indices refer to.
  std::span<const Photon> photons() const noexcept { return photons_; }
  std::uint64_t bytes() const noexcept {
    return photons_.capacity() * sizeof(Photon) + splits_.capacity() * sizeof(Split);
  }

  /// Adds to `nearest` the photons that are nearer to x than its worst, each under its index plus
  /// `first_index`. Distances are float arithmetic, dx dx + dy dy + dz dz, without contraction.
  void nearest(const Vec3f& x, Nearest& nearest, std::uint32_t first_index = 0) const noexcept;

 private:
  static constexpr int kBucket = Nearest::kBucket;

  /// An inner node: it parts the buckets [begin, end) at the middle. Nodes lie in pre-order.
  struct Split {
    float low;   ///< the left child ends here
    float high;  ///< the right child begins here
    std::uint32_t axis;
  };

  /// Buckets of the left child of a node of `count` buckets.
  static constexpr std::uint32_t left_buckets(std::uint32_t count) noexcept { return count - count / 2; }
  struct Builder;

  std::vector<Photon> photons_;
  std::vector<Split> splits_;
  Vec3f min_{0, 0, 0};
  Vec3f max_{0, 0, 0};
};

}  // namespace obscura
