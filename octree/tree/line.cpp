#include "octree/tree/line.h"

#include <cassert>

namespace obscura::detail {

bool Line::start(const Ray& ray) noexcept {
  assert(finite(ray.origin) && finite(ray.direction) && !(ray.t_min > ray.t_max));
  if (!finite(ray.origin) || !finite(ray.direction)) return false;
  const Box3i& domain = tree_.domain;
  double enter = ray.t_min, leave = ray.t_max, fastest = 0;
  for (int a = 0; a < 3; ++a) {
    origin_[a] = ray.origin[a];
    direction_[a] = ray.direction[a];
    up_[a] = !(direction_[a] < 0);
    if (std::abs(direction_[a]) < kSmallestDirection) {
      direction_[a] = 0;
      up_[a] = 1;
      inverse_[a] = delta_[a] = kInfinity;  // the planes above are never reached
      if (!(origin_[a] >= domain.min[a] && origin_[a] < domain.max[a])) return false;
      origin_[a] = std::floor(origin_[a]) + 0.5;  // any place in the voxel will do: here rounding cannot leave it
    } else {
      inverse_[a] = 1.0 / direction_[a];
      delta_[a] = std::abs(inverse_[a]);
      enter = std::max(enter, time(a, up_[a] ? domain.min[a] : domain.max[a]));
      leave = std::min(leave, time(a, up_[a] ? domain.max[a] : domain.min[a]));
    }
    fastest = std::max(fastest, std::abs(direction_[a]));
    far_[a] = up_[a] ? 8.0 : 0.0;
    step_[a] = up_[a] ? 8.0 : -8.0;
  }
  assert(fastest > 0);
  if (!(fastest > 0) || !(enter < leave)) return false;
  t_ = enter;
  leave_ = leave;

  // A position is wrong by some 1e-16 of its largest term. Along an axis on which the ray is slow that is so much time
  // that voxels have to be found from the times of planes instead (exact_).
  std::ptrdiff_t stride = 1;
  word_ = 0;
  for (int a = 0; a < 3; ++a) {
    const double extent = std::abs(origin_[a]) + std::abs(domain.min[a]) + std::abs(domain.max[a]);
    exact_ = exact_ || (direction_[a] != 0 && std::abs(direction_[a]) < 4e-5 * extent * fastest);
    const double position = (origin_[a] + t_ * direction_[a] - tree_.origin[a]) / 8;
    const int last = tree_.size[a] - 1;
    const int block =
        locate(a, t_, tree_.origin[a], 8, static_cast<int>(std::clamp(position, 0.0, last + 0.0)), 0, last);
    plane_[a] = block_plane(a, block + up_[a]);
    next_[a] = time(a, plane_[a]);
    word_ += block * stride;
    word_stride_[a] = up_[a] ? stride : -stride;
    stride *= tree_.size[a];
  }
  return true;
}

// The cell in [low, high] along an axis in which the ray is just after t: the ray enters it at t or before, and leaves
// it after t. Cell i begins at low_plane + i * size. @param guess  where to begin looking
int Line::locate(int a, double t, double low_plane, double size, int guess, int low, int high) const noexcept {
  if (direction_[a] == 0) return guess;
  int i = std::clamp(guess, low, high);
  if (up_[a]) {
    while (i < high && time(a, low_plane + (i + 1) * size) <= t) ++i;
    while (i > low && time(a, low_plane + i * size) > t) --i;
  } else {
    while (i > low && time(a, low_plane + i * size) <= t) --i;
    while (i < high && time(a, low_plane + (i + 1) * size) > t) ++i;
  }
  return i;
}

void Line::locate_exactly(double begin, int level, LeafSteps& steps) const noexcept {
  const int bits = 3 - level, last = (1 << bits) - 1;
  const double size = 1 << level;
  const std::ptrdiff_t first = steps.first;
  for (int a = 0; a < 3; ++a) {
    const double corner = plane_[a] - far_[a];
    const int guess = static_cast<int>(first >> (bits * a)) & last;
    const int leaf = locate(a, begin, corner, size, guess, 0, last);
    steps.next[a] = time(a, corner + (leaf + up_[a]) * size);
    steps.first += std::ptrdiff_t{leaf - guess} * (std::ptrdiff_t{1} << (bits * a));
  }
}

// The far planes of a leaf that is larger than a block, and when the ray leaves it.
double Line::large_planes(int level, double (&planes)[3]) const noexcept {
  double end = leave_;
  for (int a = 0; a < 3; ++a) {
    const int here = (static_cast<int>(plane_[a]) - tree_.origin[a]) / 8 - up_[a];
    planes[a] = block_plane(a, ((here >> (level - 3)) + up_[a]) << (level - 3));
    end = std::min(end, time(a, planes[a]));
  }
  return end;
}

// Goes on to the first of three planes, one on each axis, none of which is before the block's far plane.
void Line::jump(const double (&planes)[3]) noexcept {
  double times[3], to = leave_;
  for (int a = 0; a < 3; ++a) to = std::min(to, times[a] = time(a, planes[a]));
  t_ = to;
  if (!(to < leave_)) return;
  word_ = 0;
  for (int a = 0; a < 3; ++a) {
    const int here = (static_cast<int>(plane_[a]) - tree_.origin[a]) / 8 - up_[a];
    const int beyond = (static_cast<int>(planes[a]) - tree_.origin[a]) / 8 - (up_[a] ? 0 : 1);
    int block = beyond;
    if (times[a] > to) {
      const int before = up_[a] ? beyond - 1 : beyond + 1;  // the last block before the plane
      const double position = (origin_[a] + to * direction_[a] - tree_.origin[a]) * 0.125;
      const int low = std::max(0, std::min(here, before)), high = std::min(tree_.size[a] - 1, std::max(here, before));
      block =
          locate(a, to, tree_.origin[a], 8, static_cast<int>(std::clamp(position, low + 0.0, high + 0.0)), low, high);
    }
    plane_[a] = block_plane(a, block + up_[a]);
    next_[a] = time(a, plane_[a]);
    word_ += block * std::abs(word_stride_[a]);
  }
}

}  // namespace obscura::detail
