// Building the tree by selection and querying it by descent with tight gaps between the children.
#include "photon/kd_tree.h"

#include <oneapi/tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <tuple>

namespace obscura {
namespace {

/// Four lanes, by the extension that gcc and clang share; no target lacks it.
using Four [[gnu::vector_size(16)]] = float;

constexpr std::uint32_t kParallelBuckets = 256;  // smaller subtrees are built by one thread

/// Buckets of the left child of a node of `count` buckets.
constexpr std::uint32_t left_buckets(std::uint32_t count) noexcept { return count - count / 2; }

void bounding_box(std::span<const Photon> photons, Vec3f& low, Vec3f& high) noexcept {
  low = high = photons.front().position;
  for (const Photon& photon : photons) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], photon.position[axis]);
      high[axis] = std::max(high[axis], photon.position[axis]);
    }
  }
}

/// A total order of different photons, first along the axis: the tree depends on the photons alone, not
/// on the order in which they came.
bool before(const Photon& a, const Photon& b, int axis) noexcept {
  if (a.position[axis] != b.position[axis]) return a.position[axis] < b.position[axis];
  const auto key = [](const Photon& p) {
    return std::tuple(p.position.x, p.position.y, p.position.z, p.batch, p.direction, p.collisions,
                      p.split, p.power);
  };
  return key(a) < key(b);
}

}  // namespace

Nearest::Nearest(int k, float max_distance2) noexcept
    : k_(std::clamp(k, 1, kMax)), full_(2 * k_ + 2 * kBucket),
      bound_(std::isinf(max_distance2) ? max_distance2 : std::nextafter(max_distance2, -1.0f)) {}

void Nearest::reduce() noexcept {
  if (count_ < k_) return;
  std::pair<float, std::uint32_t> all[kCapacity];
  for (int i = 0; i < count_; ++i) all[i] = {distance2_[i], index_[i]};
  std::nth_element(all, all + k_ - 1, all + count_);
  for (int i = 0; i < k_; ++i) {
    distance2_[i] = all[i].first;
    index_[i] = all[i].second;
  }
  count_ = k_;
  bound_ = all[k_ - 1].first;
}

void Nearest::finish() noexcept {
  if (count_ > k_) return reduce();
  if (count_ == 0) return;
  int farthest = 0;
  for (int i = 1; i < count_; ++i) {
    if (std::pair(distance2_[i], index_[i]) > std::pair(distance2_[farthest], index_[farthest])) {
      farthest = i;
    }
  }
  if (count_ == k_) bound_ = distance2_[farthest];
  std::swap(distance2_[farthest], distance2_[count_ - 1]);
  std::swap(index_[farthest], index_[count_ - 1]);
}

KdTree::KdTree(std::vector<Photon> photons) : photons_(std::move(photons)) {
  if (photons_.empty()) return;
  const auto buckets = static_cast<std::uint32_t>((photons_.size() + kBucket - 1) / kBucket);
  splits_.resize(buckets - 1);
  bounding_box(photons_, min_, max_);
  build(0, 0, buckets);
}

void KdTree::build(std::uint32_t node, std::uint32_t begin, std::uint32_t end) {
  const std::size_t first = std::size_t{begin} * kBucket;
  const std::size_t last = std::min(std::size_t{end} * kBucket, photons_.size());
  if (end - begin == 1) {
    std::sort(photons_.begin() + first, photons_.begin() + last,
              [](const Photon& a, const Photon& b) { return before(a, b, 0); });
    return;
  }
  const std::uint32_t middle = begin + left_buckets(end - begin);
  const std::span<Photon> all(photons_.data() + first, last - first);

  Vec3f low, high;
  bounding_box(all, low, high);
  const Vec3f extent = high - low;
  int axis = 0;
  for (int i = 1; i < 3; ++i) {
    if (extent[i] > extent[axis]) axis = i;
  }

  const auto nth = all.begin() + static_cast<std::ptrdiff_t>(std::size_t{middle} * kBucket - first);
  std::nth_element(all.begin(), nth, all.end(),
                   [axis](const Photon& a, const Photon& b) { return before(a, b, axis); });
  float end_of_left = all.front().position[axis];
  for (auto it = all.begin(); it != nth; ++it) {
    end_of_left = std::max(end_of_left, it->position[axis]);
  }
  splits_[node] = {end_of_left, nth->position[axis], static_cast<std::uint32_t>(axis)};

  const auto left = [&] { build(node + 1, begin, middle); };
  const auto right = [&] { build(node + (middle - begin), middle, end); };
  if (end - begin > kParallelBuckets) {
    oneapi::tbb::parallel_invoke(left, right);
  } else {
    left();
    right();
  }
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
    Visit at = stack[--depth];
    if (at.distance2 > nearest.bound_) continue;

    // Descend to the bucket on x's side; leave the other side for later.
    while (at.end - at.begin > 1) {
      const Split& split = splits_[at.node];
      const std::uint32_t middle = at.begin + left_buckets(at.end - at.begin);
      Visit left{at.outside, 0, at.node + 1, at.begin, middle};
      Visit right{at.outside, 0, at.node + (middle - at.begin), middle, at.end};
      const float q = x[static_cast<int>(split.axis)];
      if (q > split.low) left.outside[static_cast<int>(split.axis)] = q - split.low;
      if (q < split.high) right.outside[static_cast<int>(split.axis)] = split.high - q;
      left.distance2 = length2(left.outside);
      right.distance2 = length2(right.outside);
      const bool left_first = left.distance2 <= right.distance2;
      const Visit& far = left_first ? right : left;
      if (far.distance2 <= nearest.bound_) stack[depth++] = far;
      at = left_first ? left : right;
    }
    if (at.distance2 > nearest.bound_) continue;

    // Four photons at a time: their positions are transposed from the first 16 bytes of each.
    const std::uint32_t first = at.begin * kBucket;
    const auto size = static_cast<std::uint32_t>(photons_.size());
    const std::uint32_t last = std::min(first + kBucket, size);
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
      for (int lane = 0; lane < 4; ++lane) {
        nearest.distance2_[nearest.count_] = distances[lane];
        nearest.index_[nearest.count_] = first_index + i + static_cast<std::uint32_t>(lane);
        nearest.count_ += distances[lane] <= nearest.bound_;
      }
    }
    for (; i < last; ++i) {
      const float d2 = length2(photons_[i].position - x);
      nearest.distance2_[nearest.count_] = d2;
      nearest.index_[nearest.count_] = first_index + i;
      nearest.count_ += d2 <= nearest.bound_;
    }
    if (nearest.count_ > nearest.full_) nearest.reduce();
  }
  nearest.finish();
}

}  // namespace obscura
