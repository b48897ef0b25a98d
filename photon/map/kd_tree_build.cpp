// Building the kd-tree in place: at each node the middle coordinate is found by a histogram and one
// pass without branches parts the photons. Serial in a node, parallel over nodes: always the same bits.
#include <oneapi/tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <tuple>

#include "photon/map/kd_tree.h"

namespace obscura {
namespace {

constexpr std::uint32_t kParallelBuckets = 256;  // smaller subtrees are built by one thread

/// A total order of different photons, first along the axis: the tree depends on the photons alone, not
/// on the order in which they came.
bool before(const Photon& a, const Photon& b, int axis) noexcept {
  if (a.position[axis] != b.position[axis]) return a.position[axis] < b.position[axis];
  const auto key = [](const Photon& p) {
    return std::tuple(p.position.x, p.position.y, p.position.z, p.batch, p.direction, p.collisions, p.power);
  };
  return key(a) < key(b);
}

struct Box {
  Vec3f low, high;
};

Box box_of(std::span<const Photon> photons) noexcept {
  float x0 = photons[0].position.x, y0 = photons[0].position.y, z0 = photons[0].position.z;
  float x1 = x0, y1 = y0, z1 = z0;
  for (const Photon& photon : photons) {
    const Vec3f p = photon.position;
    x0 = p.x < x0 ? p.x : x0;
    y0 = p.y < y0 ? p.y : y0;
    z0 = p.z < z0 ? p.z : z0;
    x1 = p.x > x1 ? p.x : x1;
    y1 = p.y > y1 ? p.y : y1;
    z1 = p.z > z1 ? p.z : z1;
  }
  return {{x0, y0, z0}, {x1, y1, z1}};
}

/// The coordinate that the nth photon would have if they were sorted along the axis.
float nth_coordinate(std::span<const Photon> photons, int axis, std::size_t nth, float low, float high) {
  constexpr std::size_t kFew = 64;
  if (photons.size() <= kFew) {
    std::array<float, kFew> keys;
    for (std::size_t i = 0; i < photons.size(); ++i) keys[i] = photons[i].position[axis];
    std::nth_element(keys.begin(), keys.begin() + nth, keys.begin() + photons.size());
    return keys[nth];
  }

  // Equal bins between the ends. Their borders need not be exact, only in order: truncation is.
  constexpr std::size_t kMostBins = 1024;
  const std::size_t bins = photons.size() > 8192 ? kMostBins : 128;
  const float scale = high > low ? static_cast<float>(bins) / (high - low) : std::numeric_limits<float>::infinity();
  const auto bin_of = [&](float key) {
    const float place = (key - low) * scale;
    return place < static_cast<float>(bins) ? static_cast<std::size_t>(static_cast<std::int32_t>(place)) : bins - 1;
  };
  std::vector<float> keys;
  if (std::isfinite(scale)) {
    std::array<std::uint32_t, kMostBins> counts;
    std::fill_n(counts.begin(), bins, 0u);
    for (const Photon& photon : photons) ++counts[bin_of(photon.position[axis])];
    std::size_t bin = 0;
    while (nth >= counts[bin]) nth -= counts[bin++];
    keys.reserve(counts[bin]);
    for (const Photon& photon : photons) {
      if (bin_of(photon.position[axis]) == bin) keys.push_back(photon.position[axis]);
    }
  } else {  // all but one place, or wider than a float
    for (const Photon& photon : photons) keys.push_back(photon.position[axis]);
  }
  std::nth_element(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(nth), keys.end());
  return keys[nth];
}

/// Moves the photons for which `first` holds to the front; how many there are.
template <class First>
std::size_t part(std::span<Photon> photons, const First& first) noexcept {
  std::size_t count = 0;
  for (Photon& photon : photons) {
    const Photon moved = photon;
    photon = photons[count];
    photons[count] = moved;
    count += first(moved);
  }
  return count;
}

/// Parts the photons so that the first `nth` come before the others along the axis.
void select(std::span<Photon> photons, int axis, std::size_t nth, float low, float high) {
  const float key = nth_coordinate(photons, axis, nth, low, high);
  const std::size_t less = part(photons, [=](const Photon& p) { return p.position[axis] < key; });
  if (less == nth) return;

  // Several photons at the very coordinate.
  const auto rest = photons.subspan(less);
  const std::size_t equal = part(rest, [=](const Photon& p) { return p.position[axis] == key; });
  std::nth_element(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(nth - less),
                   rest.begin() + static_cast<std::ptrdiff_t>(equal),
                   [axis](const Photon& a, const Photon& b) { return before(a, b, axis); });
}

/// By ranks: how many lie before each.
void sort_bucket(std::span<Photon> photons) noexcept {
  constexpr std::size_t kMost = 16;
  std::array<float, kMost> keys;
  std::array<Photon, kMost> copies;
  keys.fill(std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < photons.size(); ++i) {
    copies[i] = photons[i];
    keys[i] = photons[i].position.x;
  }
  std::uint32_t seen = 0;
  for (std::size_t i = 0; i < photons.size(); ++i) {
    std::int32_t rank = 0;
    for (std::size_t j = 0; j < kMost; ++j) rank += keys[j] < keys[i];
    photons[static_cast<std::size_t>(rank)] = copies[i];
    seen |= 1u << rank;
  }
  if (seen == (1u << photons.size()) - 1) return;
  std::copy_n(copies.begin(), photons.size(), photons.begin());
  std::sort(photons.begin(), photons.end(), [](const Photon& a, const Photon& b) { return before(a, b, 0); });
}

}  // namespace

struct KdTree::Builder {
  std::span<Photon> photons;
  std::span<Split> splits;

  std::span<Photon> range(std::uint32_t begin, std::uint32_t end) const noexcept {
    const std::size_t first = std::size_t{begin} * kBucket;
    return photons.subspan(first, std::min(std::size_t{end} * kBucket, photons.size()) - first);
  }

  void build(std::uint32_t node, std::uint32_t begin, std::uint32_t end, const Box& box) const {
    if (end - begin == 1) return sort_bucket(range(begin, end));
    const Vec3f extent = box.high - box.low;
    int axis = extent.y > extent.x ? 1 : 0;
    if (extent.z > extent[axis]) axis = 2;

    const std::uint32_t middle = begin + left_buckets(end - begin);
    select(range(begin, end), axis, std::size_t{middle - begin} * kBucket, box.low[axis], box.high[axis]);
    const Box left = box_of(range(begin, middle)), right = box_of(range(middle, end));
    splits[node] = {left.high[axis], right.low[axis], static_cast<std::uint32_t>(axis)};

    const auto build_left = [&] { build(node + 1, begin, middle, left); };
    const auto build_right = [&] { build(node + (middle - begin), middle, end, right); };
    if (end - begin > kParallelBuckets) {
      oneapi::tbb::parallel_invoke(build_left, build_right);
    } else {
      build_left();
      build_right();
    }
  }
};

KdTree::KdTree(std::vector<Photon> photons) : photons_(std::move(photons)) {
  if (photons_.empty()) return;
  const auto buckets = static_cast<std::uint32_t>((photons_.size() + kBucket - 1) / kBucket);
  splits_.resize(buckets - 1);
  const Box box = box_of(photons_);
  min_ = box.low;
  max_ = box.high;
  Builder{photons_, splits_}.build(0, 0, buckets, box);
}

}  // namespace obscura
