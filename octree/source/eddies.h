// Divergence-free noise that displaces smoke: octaves of eddies, each the curl of a random potential
// (Bridson, Hourihan and Nordenstam, "Curl-noise for procedural fluid flow", SIGGRAPH 2007).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "octree/base/math.h"
#include "octree/base/random.h"

namespace obscura::detail {

/// Four floats that are added and multiplied at once (a vector type of GCC and Clang).
typedef float Float4 __attribute__((vector_size(16)));

/// A random potential on a periodic lattice, quadratic B-splines in between: its curl is continuous
/// and exactly free of divergence. Of unit RMS length over the lattice.
class CurlNoise {
 public:
  explicit CurlNoise(std::uint64_t seed);

  /// Curl at a point in units of the lattice spacing.
  Vec3d operator()(const Vec3d& point) const noexcept;

 private:
  static constexpr int kSize = 32;
  Vec3d raw(const Vec3d& point) const noexcept;

  std::vector<Float4> potential_;  // the fourth is padding
  double scale_ = 1;
};

/// Eddies of halving sizes, from several widths of the plume down to a few voxels.
class Eddies {
 public:
  /// @param widest_m sigma of the plume where it is widest.
  Eddies(std::uint64_t seed, double strength, double widest_m, double voxel_m);

  /// Where the air at x came from. `width_m` is the plume's sigma there: an eddy larger than the plume
  /// has only had the time to move it by about the plume's own width.
  Vec3d origin_of(const Vec3d& x, double width_m) const noexcept;

  /// Distance from its origin within which nearly all air is found where the plume's sigma is `width_m`, metres.
  double farthest(double width_m) const noexcept {
    double sum = 0;
    for (const double size : sizes_) sum += std::pow(std::min(size, 2 * width_m), 2);
    return 2 * strength_ * std::sqrt(sum);
  }

 private:
  static constexpr int kSteps = 2;
  double strength_;
  std::vector<double> sizes_;
  std::vector<Vec3d> offsets_;
  CurlNoise noise_;
};

}  // namespace obscura::detail
