// Searching the tree: descent with the gaps between the children, four photons at a time, and a set of
// the nearest that is thinned out by counting instead of kept in order.
#include "photon/map/kd_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace obscura {
namespace {

/// Four lanes, by the extension that gcc and clang share; no target lacks it.
using Four [[gnu::vector_size(16)]] = float;
using Four_i [[gnu::vector_size(16)]] = std::int32_t;

bool none(Four_i mask) noexcept {
  std::uint64_t halves[2];
  std::memcpy(halves, &mask, sizeof mask);
  return (halves[0] | halves[1]) == 0;
}

}  // namespace

Nearest::Nearest(int k, float max_distance2) noexcept
    : k_(std::clamp(k, 1, kMax)),
      full_(2 * k_ + 2 * kBucket),
      bound_(std::isinf(max_distance2) ? max_distance2 : std::nextafter(max_distance2, -1.0f)) {}

int Nearest::count_within(float distance2) const noexcept {
  const Four limit{distance2, distance2, distance2, distance2};
  Four_i sum{0, 0, 0, 0};
  for (int i = 0; i < count_; i += 4) {  // filled up with infinities
    Four four;
    std::memcpy(&four, distance2_ + i, sizeof four);
    sum -= four <= limit;
  }
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

void Nearest::reduce(int most) noexcept {
  for (int i = count_; i % 4 != 0; ++i) distance2_[i] = std::numeric_limits<float>::infinity();

  // A distance within which there are from k to `most`: squared distances have a density like their
  // root, so the next guess is where the share would be right; every third halves the bits instead.
  std::uint32_t low = 0, high = std::bit_cast<std::uint32_t>(bound_);  // too few before low, enough at high
  int within = count_within(bound_), below = 0;
  for (int step = 1; within > most && low < high; ++step) {
    const float from = std::bit_cast<float>(low), to = std::bit_cast<float>(high);
    std::uint32_t guess = low + (high - low) / 2;
    if (step % 3 != 0 && std::isfinite(to)) {
      const float share =
          (static_cast<float>(k_) + 0.5f - static_cast<float>(below)) / static_cast<float>(within - below);
      guess = std::clamp(std::bit_cast<std::uint32_t>(from + share * (to - from)), low, high - 1);
    }
    const int count = count_within(std::bit_cast<float>(guess));
    if (count < k_) {
      low = guess + 1;
      below = count;
    } else {
      high = guess;
      within = count;
    }
  }
  bound_ = std::bit_cast<float>(high);

  int kept = 0;
  for (int i = 0; i < count_; ++i) {
    const float distance2 = distance2_[i];
    const std::uint32_t index = index_[i];
    distance2_[kept] = distance2;
    index_[kept] = index;
    kept += distance2 <= bound_;
  }
  count_ = kept;
}

bool Nearest::all_equal() const noexcept {
  return std::all_of(distance2_, distance2_ + count_,
                     [this](float distance2) { return distance2 == distance2_[count_ - 1]; });
}

int Nearest::farthest() const noexcept {
  int farthest = 0;
  for (int i = 1; i < count_; ++i) {
    if (distance2_[i] > distance2_[farthest] ||
        (distance2_[i] == distance2_[farthest] && index_[i] > index_[farthest])) {
      farthest = i;
    }
  }
  return farthest;
}

void Nearest::finish() noexcept {
  if (count_ > k_) {
    reduce(k_);
    // What is left over lies at the bound: the lower indices stay.
    if (count_ > k_) {
      const auto at_bound = [this](int i) { return distance2_[i] == bound_; };
      int inside = 0;
      for (int i = 0; i < count_; ++i) {
        if (at_bound(i)) continue;
        std::swap(distance2_[i], distance2_[inside]);
        std::swap(index_[i], index_[inside++]);
      }
      std::nth_element(index_ + inside, index_ + k_ - 1, index_ + count_);
      count_ = k_;
    }
  }
  if (count_ == 0) return;
  const int last = farthest();
  std::swap(distance2_[last], distance2_[count_ - 1]);
  std::swap(index_[last], index_[count_ - 1]);
  if (count_ == k_) bound_ = distance2_[count_ - 1];
}

void KdTree::nearest(const Vec3f& x, Nearest& nearest, std::uint32_t first_index) const noexcept {
  if (photons_.empty()) return;

  // What is still to be visited: a subtree, and how far x is outside of its slab on each axis.
  struct Visit {
    Vec3f outside;
    float distance2;
    std::uint32_t node, begin, end;
  };
  const auto length2 = [](const Vec3f& v) { return (v.x * v.x + v.y * v.y) + v.z * v.z; };
  Visit stack[64];
  int depth = 0;

  Vec3f outside;
  for (int axis = 0; axis < 3; ++axis) {
    outside[axis] = std::max({0.0f, min_[axis] - x[axis], x[axis] - max_[axis]});
  }
  const auto buckets = static_cast<std::uint32_t>((photons_.size() + kBucket - 1) / kBucket);
  stack[depth++] = {outside, length2(outside), 0, 0, buckets};

  const Four x4{x.x, x.x, x.x, x.x}, y4{x.y, x.y, x.y, x.y}, z4{x.z, x.z, x.z, x.z};
  while (depth > 0) {
    const Visit& top = stack[--depth];
    if (top.distance2 > nearest.bound_) continue;
    std::uint32_t node = top.node, begin = top.begin, end = top.end;
    Vec3f gap = top.outside;

    // Descend to the bucket on x's side; leave the other side for later.
    while (end - begin > 1) {
      const Split split = splits_[node];
      const std::uint32_t middle = begin + left_buckets(end - begin);
      const auto axis = static_cast<int>(split.axis);
      const float q = x[axis], before = gap[axis];
      const float to_left = q > split.low ? q - split.low : before;
      const float to_right = q < split.high ? split.high - q : before;
      const std::uint32_t left = node + 1, right = node + (middle - begin);
      const bool left_first = to_left <= to_right;
      gap[axis] = left_first ? to_right : to_left;
      const float far2 = length2(gap);
      stack[depth] = {gap, far2, left_first ? right : left, left_first ? middle : begin, left_first ? end : middle};
      depth += far2 <= nearest.bound_;
      gap[axis] = left_first ? to_left : to_right;
      node = left_first ? left : right;
      begin = left_first ? begin : middle;
      end = left_first ? middle : end;
    }
    if (length2(gap) > nearest.bound_) continue;

    // Four photons at a time: their positions are transposed from the first 16 bytes of each.
    const std::uint32_t first = begin * kBucket;
    const auto size = static_cast<std::uint32_t>(photons_.size());
    const std::uint32_t last = std::min(first + kBucket, size);
    const float bound = nearest.bound_;
    const Four bound4{bound, bound, bound, bound};
    std::uint32_t i = first;
    for (; i + 4 <= last; i += 4) {
      const auto load = [&](std::uint32_t j) {
        Four four;
        std::memcpy(&four, &photons_[j], sizeof four);
        return four;
      };
      const Four p0 = load(i), p1 = load(i + 1), p2 = load(i + 2), p3 = load(i + 3);
      const Four xy01 = __builtin_shufflevector(p0, p1, 0, 4, 1, 5);
      const Four xy23 = __builtin_shufflevector(p2, p3, 0, 4, 1, 5);
      const Four z01 = __builtin_shufflevector(p0, p1, 2, 6, 2, 6);
      const Four z23 = __builtin_shufflevector(p2, p3, 2, 6, 2, 6);
      const Four dx = __builtin_shufflevector(xy01, xy23, 0, 1, 4, 5) - x4;
      const Four dy = __builtin_shufflevector(xy01, xy23, 2, 3, 6, 7) - y4;
      const Four dz = __builtin_shufflevector(z01, z23, 0, 1, 4, 5) - z4;
      const Four distances = (dx * dx + dy * dy) + dz * dz;
      if (none(distances <= bound4)) continue;
      for (int lane = 0; lane < 4; ++lane) {
        nearest.distance2_[nearest.count_] = distances[lane];
        nearest.index_[nearest.count_] = first_index + i + static_cast<std::uint32_t>(lane);
        nearest.count_ += distances[lane] <= bound;
      }
    }
    for (; i < last; ++i) {
      const float d2 = length2(photons_[i].position - x);
      nearest.distance2_[nearest.count_] = d2;
      nearest.index_[nearest.count_] = first_index + i;
      nearest.count_ += d2 <= nearest.bound_;
    }
    if (nearest.count_ > nearest.full_) {
      const int most = nearest.k_ + nearest.k_ / 8;
      nearest.reduce(most);
      if (nearest.count_ > most) nearest.finish();  // many at the same distance
    }
  }
  nearest.finish();
}

}  // namespace obscura
