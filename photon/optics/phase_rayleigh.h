// Light scattered by what is much smaller than its wavelength.
#pragma once

#include <cmath>

#include "octree/base/math.h"

namespace obscura {

/// 3 / (16 pi) (1 + mu^2), unpolarised. For the members see PhaseModel in phase.h.
struct RayleighPhase {
  double value(double mu) const noexcept { return 0.75 * (0.25 / kPi) * (1 + mu * mu); }

  /// Root of mu^3 + 3 mu = 8 u - 4 by the hyperbolic form of Cardano's formula.
  double sample(double u1, double) const noexcept { return 2 * std::sinh(std::asinh(4 * u1 - 2) / 3); }

  double sample_one_minus(double u1, double) const noexcept {
    // mu = 2 sinh(a/3) and 1 = 2 sinh(a1/3) with a1 = asinh(2): their difference as a product.
    const double a = std::asinh(4 * u1 - 2) / 3;
    const double a1 = std::asinh(2.0) / 3;
    // a1 - a from asinh(x) - asinh(y) = asinh(x sqrt(1 + y^2) - y sqrt(1 + x^2)).
    const double y = 4 * u1 - 2;
    const double gap = 4 * (1 - u1) * (2 + y) / (2 * std::sqrt(1 + y * y) + y * std::sqrt(5.0));
    const double half = y > -1 ? std::asinh(gap) / 6 : 0.5 * (a1 - a);
    return 4 * std::cosh(0.5 * (a1 + a)) * std::sinh(half);
  }

  double largest() const noexcept { return value(1); }
  double mean_cosine() const noexcept { return 0; }
  double moment(int l) const noexcept { return l == 0 ? 1 : l == 2 ? 0.1 : 0; }
  RayleighPhase blunted(double) const noexcept { return *this; }
};

}  // namespace obscura
