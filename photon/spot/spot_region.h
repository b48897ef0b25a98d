// The geometry of a ray spot: a pyramid or a prism that holds all of its rays, and polygons cut by it.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "photon/spot/spot.h"
#include "photon/world/box_tree.h"

namespace obscura::detail {

/// A triangle, or what is left of it: convex. An edge goes from its corner to the next.
struct Fragment {
  static constexpr int kNoSide = -1;
  static constexpr std::size_t kMost = 6 + BoxTree::kMaxPlanes;

  explicit Fragment(const std::array<Vec3d, 3>& triangle) noexcept
      : corners{triangle[0], triangle[1], triangle[2]}, sides{0, 1, 2} {}

  std::array<Vec3d, kMost> corners;
  std::array<int, kMost> sides;  ///< of the triangle that the edge lies on, or kNoSide
  std::size_t size = 3;

  /// Keeps what is in the half-space, its border included (Sutherland and Hodgman, CACM 17, 1974).
  /// False where nothing is left.
  bool cut(const HalfSpace& half) noexcept;
  bool cut(std::span<const HalfSpace> region) noexcept {
    for (const HalfSpace& half : region) {
      if (!cut(half)) return false;
    }
    return true;
  }
};

/// A direction after a mirror.
inline Vec3d mirrored(const Vec3d& way, const Vec3d& normal) noexcept { return way - 2 * way.dot(normal) * normal; }

/// A plane that rays of a spot begin at, instead of at the eye.
using Mirror = HalfSpace;  // its inside is where they go

/// Convex; holds all rays of a spot. About the surfaces' local origin.
class SpotRegion {
 public:
  /// @param slack  m by which geometry outside still counts
  /// @param mirror where the rays begin; none: as the spot's own t_min says
  SpotRegion(const Spot& spot, const Vec3d& origin, double slack, const Mirror* mirror);

  /// Rays have one origin, else one direction.
  bool central() const noexcept { return central_; }
  /// False where it is all of space.
  bool bounded() const noexcept { return bounded_; }
  /// Where rays begin at a plane that is not the eye's.
  bool mirrored() const noexcept { return mirrored_; }
  const HalfSpace& start() const noexcept { return planes_[start_]; }
  /// Half-spaces, the slack included.
  std::span<const HalfSpace> planes() const noexcept { return {planes_.data(), count_}; }

  const Vec3d& eye() const noexcept { return eye_; }
  const Vec3d& axis() const noexcept { return axis_; }
  /// Along the axis from the eye, m.
  double height(const Vec3d& x) const noexcept { return (x - eye_).dot(axis_); }
  /// Along the ray to x, m.
  double distance(const Vec3d& x) const noexcept { return central_ ? (x - eye_).length() : height(x); }
  /// The way of the ray that comes to x.
  Vec3d direction(const Vec3d& x) const noexcept { return central_ ? (x - eye_).normalized() : axis_; }
  /// Unit directions from, and starts of, the edges between the sides.
  Vec3d edge_start(std::size_t i) const noexcept { return central_ ? eye_ : starts_[i]; }
  const Vec3d& edge(std::size_t i) const noexcept { return edges_[i]; }
  /// The largest angle between two rays or, where they are parallel, the largest distance, m.
  double spread() const noexcept;
  /// From a point to the region without its slack and its start, m; 0 inside; a lower bound where it is not bounded.
  double distance_to(const Vec3d& x) const noexcept;

 private:
  bool central_ = true, bounded_ = false, mirrored_ = false;
  Vec3d eye_{0, 0, 0}, axis_{0, 0, 1};
  std::array<HalfSpace, 6> planes_;  // four sides, where bounded; the eye's plane; the mirror's
  std::size_t count_ = 0, start_ = 0;
  double slack_ = 0;
  std::array<Vec3d, 4> edges_, starts_;
};

}  // namespace obscura::detail
