// A ray from block to block, for sums along it (optical depths, free paths): all blocks are 8^3 voxels, the three next
// planes between them are carried along, and a brick's leaves are walked in registers. walk.h tells where planes are.
#pragma once

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>

#include "octree/base/math.h"
#include "octree/tree/layout.h"

#define OBSCURA_UNROLL_AXES _Pragma("GCC unroll 3")

namespace obscura::detail {

/// Directions whose inverse would overflow are parallel to the axis.
inline constexpr double kSmallestDirection = std::numeric_limits<double>::min();

inline bool finite(const Vec3d& v) noexcept { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

/// The leaves of one brick along a ray: the number of the first, the times of the next planes, the times from plane to
/// plane and how the number changes there.
struct LeafSteps {
  double next[3], delta[3];
  std::ptrdiff_t stride[3], first;
};

class Line {
 public:
  /// Calls visit(line, word, begin, end) for each block that is not empty, front to back, until it returns false. A
  /// leaf of 16^3 voxels comes in several pieces.
  /// @return where the ray ends or leaves the domain; where it begins if it misses that.
  template <class Visit>
  static double walk(const TreeData& tree, const Ray& ray, Visit&& visit) noexcept {
    Line line(tree);
    if (!line.start(ray)) return ray.t_min;
    line.run(visit);
    return line.leave_;
  }

  /// The leaves of the brick in which the ray is from `begin` on.
  LeafSteps leaves(double begin, int level) const noexcept {
    LeafSteps steps;
    steps.first = 0;
    assert(level >= 0 && level < 3);
    static constexpr double kSizes[] = {1, 2, 4}, kPerSize[] = {1, 0.5, 0.25};  // of a leaf in a brick, in voxels
    const double size = kSizes[level], per_size = kPerSize[level];
    const int bits = 3 - level, last = (1 << bits) - 1;
    OBSCURA_UNROLL_AXES
    for (int a = 0; a < 3; ++a) {
      const double corner = plane_[a] - far_[a];
      int leaf = static_cast<int>(((origin_[a] - corner) + begin * direction_[a]) * per_size);
      leaf = leaf < 0 ? 0 : leaf > last ? last : leaf;
      steps.next[a] = time(a, corner + (leaf + up_[a]) * size);
      steps.delta[a] = delta_[a] * size;
      steps.first += std::ptrdiff_t{leaf} << (bits * a);
      steps.stride[a] = std::ptrdiff_t{up_[a] ? 1 : -1} * (std::ptrdiff_t{1} << (bits * a));
    }
    if (exact_) locate_exactly(begin, level, steps);
    return steps;
  }

 private:
  explicit Line(const TreeData& tree) noexcept : tree_(tree) {}

  double time(int a, double plane) const noexcept { return (plane - origin_[a]) * inverse_[a]; }
  double block_plane(int a, int block) const noexcept { return tree_.origin[a] + 8.0 * block; }

  bool start(const Ray& ray) noexcept;
  int locate(int a, double t, double low_plane, double size, int guess, int low, int high) const noexcept;
  void locate_exactly(double begin, int level, LeafSteps& steps) const noexcept;
  double large_planes(int level, double (&planes)[3]) const noexcept;
  void jump(const double (&planes)[3]) noexcept;

  // Farther than this many blocks to the next that is not empty, it is found anew instead of by steps.
  static constexpr int kFar = 4;
  // Leaves of this level and above are crossed at once.
  static constexpr int kLarge = 5;

  template <class Visit>
  void run(Visit&& visit) noexcept {
    const std::uint32_t* const table = tree_.table.data();
    while (t_ < leave_) {
      const std::uint32_t word = table[word_];
      const double x = next_[0] < next_[1] ? next_[0] : next_[1], y = next_[2] < leave_ ? next_[2] : leave_;
      const double to = x < y ? x : y;
      if (Word::is_empty(word)) {
        const int distance = static_cast<int>(word >> 5 & static_cast<unsigned>(Word::kMaxDistance));
        if (distance >= kFar) {
          double planes[3];
          for (int a = 0; a < 3; ++a) planes[a] = plane_[a] + step_[a] * (distance - 1);
          jump(planes);
          continue;
        }
      } else {
        const int level = tree_.header(word, 0).cell_level();
        if (level >= kLarge) {
          double planes[3];
          const double end = large_planes(level, planes);
          if (!visit(static_cast<const Line&>(*this), word, t_, end)) return;
          jump(planes);
          continue;
        }
        if (!visit(static_cast<const Line&>(*this), word, t_, to)) return;
      }
      t_ = to;
      OBSCURA_UNROLL_AXES
      for (int a = 0; a < 3; ++a) {
        const bool over = next_[a] <= to;
        plane_[a] += over ? step_[a] : 0.0;
        word_ += over ? word_stride_[a] : 0;
        next_[a] = time(a, plane_[a]);
      }
    }
  }

  const TreeData& tree_;
  double t_ = 0, leave_ = 0;
  std::ptrdiff_t word_ = 0, word_stride_[3];
  double origin_[3], direction_[3], inverse_[3], delta_[3];
  double plane_[3], next_[3], step_[3];  // the block's far planes, their times, from one to the next
  double far_[3];                        // from a block's corner to its far plane: 8 or 0
  int up_[3];                            // 1 where the ray goes up or is parallel, else 0
  bool exact_ = false;                   // a rounded position does not tell voxels well enough
};

/// Calls visit(number, begin, end) for the leaves of a brick until it returns false. Times are added up from plane to
/// plane: off by a few roundings at most, since every brick begins anew; so near to its end the brick is at its end.
template <class Visit>
inline void for_each_leaf(const LeafSteps& steps, double begin, double end, Visit&& visit) noexcept {
  const double limit = end - 8e-15 * (std::abs(begin) + std::abs(end));
  double t0 = steps.next[0], t1 = steps.next[1], t2 = steps.next[2], t = begin;
  const double d0 = steps.delta[0], d1 = steps.delta[1], d2 = steps.delta[2];
  const std::ptrdiff_t s0 = steps.stride[0], s1 = steps.stride[1], s2 = steps.stride[2];
  std::ptrdiff_t i = steps.first;
  for (;;) {
    const double x = t0 < t1 ? t0 : t1, to = x < t2 ? x : t2;
    if (to >= limit) {
      visit(i, t, end);
      return;
    }
    if (!visit(i, t, to)) return;
    t = to;
    i += (t0 <= to ? s0 : 0) + (t1 <= to ? s1 : 0) + (t2 <= to ? s2 : 0);
    // Added, not chosen: which plane comes next is not to be foretold, and compilers branch on a choice.
    t0 += t0 <= to ? d0 : 0.0;
    t1 += t1 <= to ? d1 : 0.0;
    t2 += t2 <= to ? d2 : 0.0;
  }
}

}  // namespace obscura::detail
