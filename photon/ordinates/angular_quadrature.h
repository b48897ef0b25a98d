// Quadratures over all directions for discrete ordinates: directions and positive weights, alike in all
// eight octants.
#pragma once

#include <array>
#include <vector>

#include "octree/base/math.h"

namespace obscura {

enum class AngularQuadrature {
  /// Gauss-Legendre in the cosine to z, 2 N equal azimuths: exact for spherical harmonics below degree 2 N.
  product,
  /// Gauss-Legendre in each hemisphere by itself, for layers: first moments of the hemispheres about z are
  /// exact.
  double_gauss,
  /// Levels alike along x, y and z (LQn; Lewis & Miller, Computational Methods of Neutron Transport, 1984,
  /// ch. 4). Weights of LQn turn negative at S20: from there on a triangle of Gauss-Legendre levels with
  /// fewer, equally spaced azimuths towards the pole, alike only in the octants.
  level_symmetric,
};

/// The ordinates of one octant come together, in the same order in each: ordinate i of octant o has the
/// magnitudes of ordinate i of octant 0; bit a of o is set where axis a is negative.
class OrdinateSet {
 public:
  /// @param order N of S_N: even, 2 to 32; @throws InputError
  OrdinateSet(AngularQuadrature kind, int order);

  int order() const noexcept { return order_; }
  int per_octant() const noexcept { return static_cast<int>(magnitude_.size()); }
  int size() const noexcept { return 8 * per_octant(); }
  /// Where light travels, in the first octant.
  const Vec3d& magnitude(int i) const noexcept { return magnitude_[static_cast<std::size_t>(i)]; }
  Vec3d direction(int octant, int i) const noexcept;
  /// sr; all add up to 4 pi.
  double weight(int i) const noexcept { return weight_[static_cast<std::size_t>(i)]; }
  /// Largest degree of spherical harmonics whose scattering the set can hold.
  int moment_order() const noexcept { return moment_order_; }
  /// Sum of weight times cosine over the hemisphere of an axis; pi where exact.
  double half_flux(int axis) const noexcept { return half_flux_[static_cast<std::size_t>(axis)]; }

 private:
  int order_;
  int moment_order_;
  std::vector<Vec3d> magnitude_;
  std::vector<double> weight_;
  std::array<double, 3> half_flux_{};
};

/// Real spherical harmonics, orthonormal over the sphere: (l, m) at l (l + 1) + m for l up to the order.
/// Legendre's P_l(a.b) = 4 pi / (2 l + 1) times the sum over m of Y_lm(a) Y_lm(b).
void spherical_harmonics(const Vec3d& direction, int order, double* values) noexcept;

}  // namespace obscura
