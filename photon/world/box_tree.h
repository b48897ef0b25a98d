// A hierarchy of boxes that is asked which of them reach into a convex region. Embree's own answers only
// rays and points.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
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
  static constexpr std::size_t kMaxPlanes = 8;

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
    std::array<std::uint32_t, kMaxDepth + 2> stack;
    std::size_t size = 0;
    const Planes planes(region, nodes_[0]);
    if (planes.reach(nodes_[0])) stack[size++] = 0;
    while (size > 0) {
      const std::uint32_t at = stack[--size];
      const Node& node = nodes_[at];
      if (node.count == 0) {
        if (planes.reach(nodes_[node.first])) stack[size++] = node.first;
        if (planes.reach(nodes_[at + 1])) stack[size++] = at + 1;
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

  /// A region in float for boxes: each half-space is moved outward by what rounding may take away.
  struct Planes {
    Planes(std::span<const HalfSpace> region, const Node& all) noexcept {
      for (std::size_t i = 0; i < region.size(); ++i) {
        double size = std::abs(region[i].offset);
        for (int axis = 0; axis < 3; ++axis) {
          const double n = region[i].normal[axis];
          high[axis][i] = static_cast<float>(std::max(n, 0.0));
          low[axis][i] = static_cast<float>(std::min(n, 0.0));
          size += std::abs(n) * static_cast<double>(std::max(std::abs(all.low[axis]), std::abs(all.high[axis])));
        }
        offset[i] = static_cast<float>(region[i].offset +
                                       8 * static_cast<double>(std::numeric_limits<float>::epsilon()) * size);
      }
    }
    /// False where the box is outside one of the half-spaces.
    bool reach(const Node& node) const noexcept {
      std::uint32_t signs = 0;  // of the farthest corner's heights; as integers, so that they join side by side
      for (std::size_t i = 0; i < kMaxPlanes; ++i) {
        const float inner = offset[i] + high[0][i] * node.high[0] + low[0][i] * node.low[0] +
                            high[1][i] * node.high[1] + low[1][i] * node.low[1] + high[2][i] * node.high[2] +
                            low[2][i] * node.low[2];
        signs |= std::bit_cast<std::uint32_t>(inner);
      }
      return signs >> 31 == 0;
    }

    std::array<float, kMaxPlanes> offset{};
    std::array<std::array<float, kMaxPlanes>, 3> high{}, low{};  // positive and negative parts of the normals
  };

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
};

}  // namespace obscura
