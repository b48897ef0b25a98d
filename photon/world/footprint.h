// How wide a ray's spot is, and how far the ray may go by coarse cells of the clouds for it. Formulas:
// photon/METHODS.md, "The footprint".
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace obscura {

/// How wide the spot is that a ray stands for; the default is a line, which is walked exactly.
struct Footprint {
  double width = 0;   ///< m, where the ray begins
  double spread = 0;  ///< m per m of the way

  bool exists() const noexcept { return width > 0 || spread > 0; }
  /// At a distance t along the ray, m.
  double at(double t) const noexcept { return spread > 0 ? width + spread * t : width; }
  /// That of a ray that goes on from there.
  Footprint from(double t) const noexcept { return {at(t), spread}; }
};

/// What walks with footprints have done.
struct FootprintCounts {
  std::uint64_t rays = 0;      ///< walked with a footprint, mirrored legs included
  std::uint64_t segments = 0;  ///< of these rays, coarse cells included
  std::uint64_t coarse = 0;    ///< coarse cells among these
  double voxels = 0;           ///< estimate of the voxels that lie on the rays in coarse cells: from faces crossed
  double error_bound = 0;      ///< largest of all rays: of transmission, and of radiance over the largest source

  FootprintCounts& operator+=(const FootprintCounts& other) noexcept {
    rays += other.rays;
    segments += other.segments;
    coarse += other.coarse;
    voxels += other.voxels;
    error_bound = std::max(error_bound, other.error_bound);
    return *this;
  }
};

/// Decides for one ray which cells of the clouds may be taken whole, by their means: as long as a rigorous bound of
/// what that changes stays below the tolerance. The walks of all clouds that the ray meets share it.
class CoarseCells {
 public:
  /// @param tolerance of the transmission, and of the radiance relative to the largest source
  /// @param largest_source W/m2/sr, as SpectralWorld::largest_source(); 0: nothing emits
  CoarseCells(const Footprint& footprint, double tolerance, double largest_source) noexcept
      : footprint_(footprint),
        left_(tolerance),
        tolerance_(tolerance),
        per_source_(largest_source > 0 ? 1 / largest_source : 0.0) {}

  /// Coarsest level whose cells are no wider than the spot; 0 where none may be asked for.
  int level(double t, double voxel_m) const noexcept {
    if (patience_ < 0) return 0;
    const double width = footprint_.at(t);
    int level = 0;
    for (double side = 2 * voxel_m; side <= width && level < 30; side *= 2) ++level;
    return level;
  }

  /// Whether a cell is taken whole. A cell takes at most half of what is left, so that something is left for
  /// the way beyond it.
  /// @param extinction, emission largest deviations inside it from what is taken for them, 1/m and W/m3/sr
  bool take(double length, double extinction, double emission) noexcept {
    const double error = cost(length, extinction) + transmission_ * emission * length * per_source_;
    if (!allows(error)) return false;
    left_ -= error;
    depth_doubt_ += extinction * length;
    patience_ += kPatience;
    return true;
  }
  /// Whether the extinction alone allows it.
  bool allows(double length, double extinction) noexcept { return allows(cost(length, extinction)); }

  /// The caller of the walk must report every segment, in order: its depth, and the transmission up to its end.
  void passed(double depth, double transmission) noexcept {
    ++counts_.segments;
    depth_ += depth;
    transmission_ = transmission;
  }
  /// Called by a walk that has taken a cell whole.
  void passed_over(double voxels) noexcept {
    ++counts_.coarse;
    counts_.voxels += voxels;
  }

  /// Optical depth of all that was passed, and how far it may be off.
  double depth() const noexcept { return depth_; }
  double depth_doubt() const noexcept { return depth_doubt_; }
  FootprintCounts counts() const noexcept {
    FootprintCounts counts = counts_;
    counts.rays = 1;
    counts.error_bound = tolerance_ - left_;
    return counts;
  }

 private:
  // A ray that is refused so often gives up asking, and once more so often for each cell that it has taken.
  static constexpr int kPatience = 4;

  double cost(double length, double extinction) const noexcept { return transmission_ * extinction * length; }
  bool allows(double error) noexcept {
    if (error <= 0.5 * left_) return true;
    --patience_;
    return false;
  }

  Footprint footprint_;
  double left_, tolerance_;
  double per_source_;
  double depth_ = 0, depth_doubt_ = 0;
  double transmission_ = 1;  // up to what the walks have been told: no less than at the cell
  int patience_ = kPatience;
  FootprintCounts counts_;
};

}  // namespace obscura
