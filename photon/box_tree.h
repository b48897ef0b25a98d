// A hierarchy of boxes that is asked which of them reach into a convex region. Embree's own answers only
// rays and points.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "octree/base/math.h"

namespace obscura {

/// The points x with normal . x + offset >= 0.
struct HalfSpace {
  Vec3d normal{0, 0, 0};
  double offset = 0;

  double height(const Vec3d& x) const noexcept { return normal.dot(x) + offset; }
};

/// Immutable. Four boxes a leaf, 32 bytes a node: 20 bytes a box with the order of the boxes.
class BoxTree {
 public:
  /// Most half-spaces that a region may have.
  static constexpr std::size_t kMaxPlanes = 16;

  BoxTree() = default;
  /// Splits by the surface area heuristic in 16 bins (Wald, "On fast construction of SAH-based bounding
  /// volume hierarchies", 2007); uses all threads, and its result does not depend on them. Boxes are
  /// stored in float, rounded outward: they should lie about the origin.
  explicit BoxTree(std::span<const Box3d> boxes);

  /// Calls visit(index) for every box that no half-space alone keeps out of the region, in a fixed order,
  /// until one call returns true. Returns whether one did. Allocates nothing.
  template <class Visit>
  bool any(std::span<const HalfSpace> region, Visit&& visit) const {
    if (nodes_.empty()) return false;
    struct Entry {
      std::uint32_t node, planes;
    };
    std::array<Entry, kMaxDepth + 2> stack;
    std::size_t size = 0;
    const auto push = [&](std::uint32_t node, std::uint32_t planes) {
      if (reaches(nodes_[node], region, planes)) stack[size++] = {node, planes};
    };
    push(0, (1u << region.size()) - 1);
    while (size > 0) {
      const Entry at = stack[--size];
      const Node& node = nodes_[at.node];
      if (node.count == 0) {
        push(node.first, at.planes);
        push(at.node + 1, at.planes);
        continue;
      }
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        if (visit(order_[i])) return true;
      }
    }
    return false;
  }

  std::size_t bytes() const noexcept { return nodes_.size() * sizeof(Node) + order_.size() * sizeof(order_[0]); }

 private:
  static constexpr std::size_t kMaxDepth = 96;

  struct Node {
    float low[3];
    std::uint32_t first;  // of a leaf its first place in the order, else the second child; the first is next
    float high[3];
    std::uint32_t count;  // boxes of a leaf; 0: has children
  };
  struct Builder;

  /// False where the box is outside one of the planes; drops those that it is wholly inside of.
  static bool reaches(const Node& node, std::span<const HalfSpace> region, std::uint32_t& planes) noexcept {
    for (std::uint32_t left = planes; left != 0; left &= left - 1) {
      const HalfSpace& plane = region[static_cast<std::size_t>(__builtin_ctz(left))];
      double inner = plane.offset, outer = plane.offset;
      for (int axis = 0; axis < 3; ++axis) {
        const double low = plane.normal[axis] * static_cast<double>(node.low[axis]);
        const double high = plane.normal[axis] * static_cast<double>(node.high[axis]);
        inner += low < high ? high : low;
        outer += low < high ? low : high;
      }
      if (inner < 0) return false;
      if (outer >= 0) planes &= ~(left & -left);
    }
    return true;
  }

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
};

}  // namespace obscura
