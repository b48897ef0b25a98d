#include "photon/world/box_tree.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <numeric>

namespace obscura {
namespace {

constexpr std::size_t kLeaf = 4;
constexpr int kBins = 16;
constexpr std::size_t kParallel = 1 << 14;
constexpr int kSplitByArea = 64;  // deeper than this, by half the number

double half_area(const Box3d& box) {
  if (box.isEmpty()) return 0;
  const Vec3d s = box.size();
  return s.x * s.y + s.y * s.z + s.z * s.x;
}

float below(double x) {
  const float f = static_cast<float>(x);
  return static_cast<double>(f) <= x ? f : std::nextafter(f, -std::numeric_limits<float>::infinity());
}
float above(double x) { return -below(-x); }

}  // namespace

struct BoxTree::Builder {
  std::span<const Box3d> boxes;
  BoxTree& tree;

  /// As every leaf but the last of a subtree is full, where each node goes is known beforehand.
  static std::size_t node_count(std::size_t boxes) { return 2 * ((boxes + kLeaf - 1) / kLeaf) - 1; }
  // Twice the centre.
  double middle(std::uint32_t box, int axis) const { return boxes[box].min[axis] + boxes[box].max[axis]; }

  /// The number of boxes on the lower side of the best split and its axis.
  std::size_t split(std::size_t begin, std::size_t end, int depth, int& axis) const {
    const std::size_t n = end - begin;
    const std::size_t half = std::max(kLeaf, n / 2 / kLeaf * kLeaf);
    Box3d middles;
    for (std::size_t i = begin; i < end; ++i) {
      const Box3d& box = boxes[tree.order_[i]];
      middles.extendBy(box.min + box.max);
    }
    const Vec3d size = middles.size();
    axis = static_cast<int>(middles.majorAxis());
    if (!(size[axis] > 0) || depth > kSplitByArea) return half;

    struct Bin {
      Box3d box;
      std::size_t count = 0;
    };
    double best = kInfinity;
    std::size_t lower = half;
    for (int a = 0; a < 3; ++a) {
      if (!(size[a] > 0)) continue;
      std::array<Bin, kBins> bins;
      const double scale = kBins / size[a];
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t box = tree.order_[i];
        const int b = std::clamp(static_cast<int>((middle(box, a) - middles.min[a]) * scale), 0, kBins - 1);
        Bin& bin = bins[static_cast<std::size_t>(b)];
        bin.box.extendBy(boxes[box]);
        ++bin.count;
      }
      std::array<double, kBins> upper_cost{};
      Bin sum;
      for (std::size_t b = kBins - 1; b > 0; --b) {
        sum.box.extendBy(bins[b].box);
        sum.count += bins[b].count;
        upper_cost[b] = half_area(sum.box) * static_cast<double>(sum.count);
      }
      sum = {};
      for (std::size_t b = 0; b + 1 < kBins; ++b) {
        sum.box.extendBy(bins[b].box);
        sum.count += bins[b].count;
        const double cost = half_area(sum.box) * static_cast<double>(sum.count) + upper_cost[b + 1];
        if (sum.count == 0 || sum.count == n || cost >= best) continue;
        best = cost;
        lower = sum.count;
        axis = a;
      }
    }
    // Full leaves on the lower side.
    return std::clamp((lower + kLeaf / 2) / kLeaf * kLeaf, kLeaf, (n - 1) / kLeaf * kLeaf);
  }

  Box3d build(std::size_t begin, std::size_t end, std::size_t node, int depth) {
    const std::size_t n = end - begin;
    Box3d box;
    Node made{};
    if (n <= kLeaf) {
      for (std::size_t i = begin; i < end; ++i) box.extendBy(boxes[tree.order_[i]]);
      made.first = static_cast<std::uint32_t>(begin);
      made.count = static_cast<std::uint32_t>(n);
    } else {
      int axis = 0;
      const std::size_t middle_at = begin + split(begin, end, depth, axis);
      const auto at = [&](std::size_t i) { return tree.order_.begin() + static_cast<std::ptrdiff_t>(i); };
      std::nth_element(at(begin), at(middle_at), at(end), [&](std::uint32_t a, std::uint32_t b) {
        const double x = middle(a, axis), y = middle(b, axis);
        return x != y ? x < y : a < b;
      });
      const std::size_t second = node + 1 + node_count(middle_at - begin);
      Box3d other;
      const auto lower = [&] { box = build(begin, middle_at, node + 1, depth + 1); };
      const auto upper = [&] { other = build(middle_at, end, second, depth + 1); };
      if (n > kParallel) {
        tbb::parallel_invoke(lower, upper);
      } else {
        lower();
        upper();
      }
      box.extendBy(other);
      made.first = static_cast<std::uint32_t>(second);
    }
    for (int axis = 0; axis < 3; ++axis) {
      made.low[axis] = below(box.min[axis]);
      made.high[axis] = above(box.max[axis]);
    }
    tree.nodes_[node] = made;
    return box;
  }
};

BoxTree::BoxTree(std::span<const Box3d> boxes) : order_(boxes.size()) {
  if (boxes.empty()) return;
  std::iota(order_.begin(), order_.end(), 0u);
  nodes_.resize(Builder::node_count(boxes.size()));
  Builder{boxes, *this}.build(0, boxes.size(), 0, 0);
}

}  // namespace obscura
