#include "octree/tree/walk.h"

#include <cassert>

#include "octree/tree/line.h"

namespace obscura {

using detail::finite;
using detail::kSmallestDirection;

void Walk::start(const Ray& ray) noexcept {
  assert(finite(ray.origin) && finite(ray.direction) && !(ray.t_min > ray.t_max));
  begin_ = end_ = block_end_ = ray.t_min;
  leave_ = -kInfinity;
  if (!finite(ray.origin) || !finite(ray.direction)) return;
  const Box3i& domain = tree_->domain;

  // The ray is clipped to the domain by times of planes that are rounded as those inside are.
  double enter = ray.t_min;
  double leave = ray.t_max;
  bool moves = false;
  for (int axis = 0; axis < 3; ++axis) {
    origin_[axis] = ray.origin[axis];
    direction_[axis] = ray.direction[axis];
    if (std::abs(direction_[axis]) < kSmallestDirection) {
      direction_[axis] = inverse_[axis] = 0;
      sign_[axis] = 0;
      if (!(origin_[axis] >= domain.min[axis] && origin_[axis] < domain.max[axis])) return;
      continue;
    }
    moves = true;
    inverse_[axis] = 1.0 / direction_[axis];
    sign_[axis] = direction_[axis] > 0 ? 1 : -1;
    const double to_min = time(axis, domain.min[axis]);
    const double to_max = time(axis, domain.max[axis]);
    enter = std::max(enter, sign_[axis] > 0 ? to_min : to_max);
    leave = std::min(leave, sign_[axis] > 0 ? to_max : to_min);
  }
  assert(moves);
  if (!moves || !(enter < leave)) return;

  leave_ = leave;
  begin_ = end_ = block_end_ = enter_ = enter;
  for (int axis = 0; axis < 3; ++axis) {
    voxel_[axis] = locate(axis, enter, domain.min[axis], domain.max[axis] - 1);
    block_t_[axis] = enter;
    plane_[axis] = voxel_[axis] + (sign_[axis] > 0 ? 1 : 0);
  }
  kind_ = Kind::empty;
  cell_level_ = -1;  // no block yet: voxel_ is where the ray is
}

// The voxel in [low, high] in which the ray is just after t: the ray enters it at t or before, and leaves it after t.
int Walk::locate(int axis, double t, int low, int high) const noexcept {
  const double position = std::min(std::max(origin_[axis] + t * direction_[axis], low + 0.0), high + 0.0);
  int i = static_cast<int>(position);
  i -= position < i;  // std::floor, which may be a call
  if (sign_[axis] > 0) {
    while (i < high && time(axis, i + 1.0) <= t) ++i;
    while (i > low && time(axis, i) > t) --i;
  } else if (sign_[axis] < 0) {
    while (i > low && time(axis, i) <= t) --i;
    while (i < high && time(axis, i + 1.0) > t) ++i;
  }
  return i;
}

void Walk::enter_block() noexcept {
  // Where the ray is now: across the planes it has just reached, elsewhere still in the last cell.
  if (cell_level_ >= 0) {
    for (int axis = 0; axis < 3; ++axis) {
      if (sign_[axis] == 0) continue;
      const bool up = sign_[axis] > 0;
      if (block_t_[axis] <= begin_) {
        voxel_[axis] = up ? corner_[axis] + (1 << block_level_) : corner_[axis] - 1;
      } else {
        const int size = 1 << cell_level_;
        const int low = static_cast<int>(plane_[axis]) - (up ? size : 0);
        voxel_[axis] = size == 1 ? low : locate(axis, begin_, low, low + size - 1);
      }
    }
  }

  // The block there, and when the ray leaves it.
  const Vec3i voxel(voxel_[0], voxel_[1], voxel_[2]);
  assert(tree_->holds(voxel));
  const std::uint32_t word = tree_->word_at(voxel);
  int leaf_level;
  if (detail::Word::is_empty(word)) {
    leaf_level = detail::Word::empty_level(word);
    kind_ = Kind::empty;
  } else {
    record_ = tree_->record(word);
    leaf_level = header(0).cell_level();
    kind_ = Kind::leaves;
  }
  if (leaf_level < stop_level_) {
    kind_ = Kind::coarse;
    leaf_level = stop_level_;
    if (leaf_level > 3) {
      bool any = false;
      for (int c = 0; c < tree_->channel_count() && !any; ++c) {
        const Bounds& b = tree_->pyramid_bounds(voxel, leaf_level, c);
        any = b.max != 0 || b.min != 0;
      }
      if (!any) kind_ = Kind::empty;
    }
  }
  enter_cell(leaf_level);
}

// The cell of this level, or the brick of leaves of this level, in which the present voxel is.
void Walk::enter_cell(int leaf_level) noexcept {
  cell_level_ = leaf_level;
  block_level_ = std::max(3, leaf_level);
  corner_ = cell_corner(block_level_);
  for (int axis = 0; axis < 3; ++axis) {
    block_t_[axis] = exit_time(
        axis, static_cast<double>(corner_[axis]) + (sign_[axis] > 0 ? static_cast<double>(1 << block_level_) : 0.0));
  }
  block_end_ = std::min(std::min(block_t_[0], block_t_[1]), block_t_[2]);

  // The leaf in it.
  const int bits = block_level_ - cell_level_;  // of a leaf's number, per axis
  index_ = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int leaf = (voxel_[axis] - corner_[axis]) >> cell_level_;
    const int next_leaf = sign_[axis] > 0 ? leaf + 1 : leaf;
    plane_[axis] = corner_[axis] + static_cast<double>(next_leaf) * static_cast<double>(1 << cell_level_);
    step_[axis] = static_cast<double>(sign_[axis]) * static_cast<double>(1 << cell_level_);
    t_[axis] = exit_time(axis, plane_[axis]);
    index_ += leaf << (bits * axis);
    stride_[axis] = sign_[axis] * (1 << (bits * axis));
  }
}

// Whether the ray comes just now into the cell of this level, or begins there.
bool Walk::enters(int level) const noexcept {
  if (begin_ == enter_) return true;
  const Vec3i corner = cell_corner(level);
  for (int axis = 0; axis < 3; ++axis) {
    if (sign_[axis] == 0) continue;
    const double plane = static_cast<double>(corner[axis]) + (sign_[axis] > 0 ? 0.0 : static_cast<double>(1 << level));
    if (time(axis, plane) >= begin_) return true;
  }
  return false;
}

double Walk::exit_of(int level) const noexcept {
  const Vec3i corner = cell_corner(level);
  double end = kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    end = std::min(end, exit_time(axis, static_cast<double>(corner[axis]) +
                                            (sign_[axis] > 0 ? static_cast<double>(1 << level) : 0.0)));
  }
  return end;
}

Cell Walk::cell() const noexcept {
  const int bits = block_level_ - cell_level_;
  const int mask = (1 << bits) - 1;
  return {corner_ + Vec3i((index_ & mask) << cell_level_, ((index_ >> bits) & mask) << cell_level_,
                          (index_ >> (2 * bits)) << cell_level_),
          cell_level_};
}

float Walk::coarse_value(int channel) const noexcept { return detail::cell_bounds(*tree_, channel, cell()).mean; }

}  // namespace obscura
