// The scalar walk: a ray's segments through the leaves, front to back, in double and exact. It
// skips whole levels and can stop at a coarser one. batch_walk.h is tested against it.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <span>

#include "octree/base/math.h"
#include "octree/tree/octree.h"

namespace obscura {

/// The bounds of a cell's channels, looked up when they are asked for.
class CellBounds {
 public:
  CellBounds(const detail::TreeData& tree, const Cell& cell) noexcept : tree_(tree), cell_(cell) {}
  Bounds operator()(int channel) const noexcept { return detail::cell_bounds(tree_, channel, cell_); }

 private:
  const detail::TreeData& tree_;
  Cell cell_;
};

/// Walks one ray of index space through the octree. The segments tile the ray's part in the domain without gaps or
/// overlaps, empty cells included: each begins exactly where the last one ended. A ray that runs in a face belongs
/// to the voxel above it. Resumable, so that several can be merged; copyable; nothing is allocated.
///
/// The parameter of a plane x = p is always (p - origin) * (1 / direction), rounded alike whatever the level, so
/// that the order of planes is the same everywhere; voxels are found from it, not from a rounded position.
class Walk {
 public:
  /// @param stop_level cells are not split below this level; their value is then their mean.
  Walk(const Octree& tree, const Ray& index_ray, int stop_level = 0) noexcept
      : tree_(&tree.data()), stop_level_(std::min(stop_level, tree.data().top_level)) {
    start(index_ray);
  }

  /// Goes on to the next segment; false when the ray has left.
  bool next() noexcept {
    for (;;) {
      begin_ = end_;
      if (!(begin_ < leave_)) return false;
      if (begin_ < block_end_) {
        step();
      } else {
        enter_block();
      }
      if (end_segment()) return true;
    }
  }

  /// The same, but a cell above the leaves may become one segment. Where the ray enters a block that is not empty, the
  /// cells around it are offered from the coarsest on: `stops.level(begin)` says how coarse the first may be, and
  /// `stops.take(bounds, begin, end)` whether a cell is taken; bounds(channel) are its Bounds. Each cell is offered
  /// once, where the ray enters it or begins in it.
  template <class Stops>
  bool next(Stops&& stops) noexcept {
    for (;;) {
      begin_ = end_;
      if (!(begin_ < leave_)) return false;
      if (begin_ < block_end_) {
        step();
      } else {
        enter_block();
        if (kind_ == Kind::leaves) {
          const int finest = std::max(kFinestStop, cell_level_ + 1);
          for (int level = std::min(stops.level(begin_), tree_->top_level); level >= finest; --level) {
            if (level != block_level_ && !enters(level)) continue;
            const double end = level == block_level_ ? block_end_ : exit_of(level);
            if (!stops.take(CellBounds(*tree_, {cell_corner(level), level}), begin_, std::min(end, leave_))) continue;
            kind_ = Kind::coarse;
            enter_cell(level);
            break;
          }
        }
      }
      if (end_segment()) return true;
    }
  }
  /// Cells below bricks hold no bounds of their own: to find them costs more than to walk through the cell.
  static constexpr int kFinestStop = 3;

  /// Whether the present segment is that of a cell above the leaves.
  bool coarse() const noexcept { return kind_ == Kind::coarse; }

  /// Ray parameters of the present segment.
  double begin() const noexcept { return begin_; }
  double end() const noexcept { return end_; }

  /// Whether every channel is 0 in the present segment.
  bool empty() const noexcept {
    if (kind_ == Kind::empty) return true;
    for (int c = 0; c < tree_->channel_count(); ++c) {
      if (value(c) != 0) return false;
    }
    return true;
  }
  /// Whether the present leaf or cell is known to be empty without a look at its values: cheaper than empty(), and
  /// false where a leaf happens to hold zeros.
  bool in_empty_leaf() const noexcept { return kind_ == Kind::empty; }

  /// The value of the present leaf, or the mean of the present cell where the walk stops above the leaves.
  float value(int channel) const noexcept {
    assert(channel >= 0 && channel < tree_->channel_count());
    if (kind_ == Kind::leaves) return detail::unpack(record_, header(channel), static_cast<unsigned>(index_));
    return kind_ == Kind::empty ? 0.0f : coarse_value(channel);
  }

  /// The present leaf, or the cell at which the walk stops.
  Cell cell() const noexcept;

 private:
  enum class Kind : unsigned char { empty, leaves, coarse };

  const detail::ChannelHeader& header(int channel) const noexcept {
    return reinterpret_cast<const detail::ChannelHeader*>(record_)[channel];
  }
  double time(int axis, double plane) const noexcept { return (plane - origin_[axis]) * inverse_[axis]; }
  double exit_time(int axis, double plane) const noexcept { return sign_[axis] == 0 ? kInfinity : time(axis, plane); }

  void start(const Ray& ray) noexcept;
  void enter_block() noexcept;
  void enter_cell(int leaf_level) noexcept;
  Vec3i cell_corner(int level) const noexcept { return tree_->corner(Vec3i(voxel_[0], voxel_[1], voxel_[2]), level); }
  bool enters(int level) const noexcept;
  double exit_of(int level) const noexcept;
  bool end_segment() noexcept {
    end_ = std::min(std::min(std::min(t_[0], t_[1]), t_[2]), leave_);
    return end_ > begin_;  // the corner of a cell that is only touched is no segment
  }
  int locate(int axis, double t, int low, int high) const noexcept;
  float coarse_value(int channel) const noexcept;

  // Over the nearest plane into the next leaf of the same brick.
  void step() noexcept {
    if (t_[0] <= t_[1] && t_[0] <= t_[2]) {
      step_axis(0);
    } else if (t_[1] <= t_[2]) {
      step_axis(1);
    } else {
      step_axis(2);
    }
  }
  void step_axis(int axis) noexcept {
    plane_[axis] += step_[axis];
    t_[axis] = time(axis, plane_[axis]);
    index_ += stride_[axis];
  }

  const detail::TreeData* tree_;
  int stop_level_;
  Kind kind_ = Kind::empty;

  double begin_ = 0, end_ = 0;    // the present segment
  double enter_ = 0, leave_ = 0;  // where the ray begins or enters, ends or leaves the domain

  double origin_[3], inverse_[3], direction_[3];
  int sign_[3];  // of the direction

  // The block that the ray is in: its exit planes' times, the voxel of entry.
  double block_end_ = 0;
  double block_t_[3];
  int voxel_[3];
  Vec3i corner_{0, 0, 0};
  int block_level_ = 0;

  // Its leaves: next plane on each axis, when, and how the leaf's number changes there.
  double plane_[3], t_[3], step_[3];
  int stride_[3];
  int index_ = 0;
  int cell_level_ = 0;
  const std::byte* record_ = nullptr;
};

/// Calls visit(begin, end, const Walk&) for each segment, front to back, until it returns false.
template <class F>
void walk(const Octree& tree, const Ray& index_ray, F&& visit, int stop_level = 0) {
  Walk segments(tree, index_ray, stop_level);
  while (segments.next()) {
    if (!visit(segments.begin(), segments.end(), static_cast<const Walk&>(segments))) return;
  }
}

/// Integral over t of sum_c weights[c] * value_c along the ray; exact to rounding.
/// @param weights one per channel, in optical depth per (unit of value x unit of t).
double optical_depth(const Octree& tree, const Ray& index_ray, std::span<const double> weights) noexcept;

/// Where a free path ends.
struct FreePath {
  double t = 0;      ///< ray parameter of the collision, inside a leaf with extinction; else where the ray left
  double depth = 0;  ///< optical depth up to there: the target, or all there is
  bool collided = false;
};

/// Follows the ray until its optical depth reaches the target.
/// @param weights as in optical_depth().
FreePath free_path(const Octree& tree, const Ray& index_ray, std::span<const double> weights,
                   double target_depth) noexcept;

}  // namespace obscura
