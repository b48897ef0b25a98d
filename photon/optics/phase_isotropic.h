// Light that scatters alike in all directions.
#pragma once

#include "octree/base/math.h"

namespace obscura {

/// 1 / (4 pi) everywhere. For the members see PhaseModel in phase.h.
struct IsotropicPhase {
  double value(double) const noexcept { return 0.25 / kPi; }
  double sample(double u1, double) const noexcept { return 2 * u1 - 1; }
  double sample_one_minus(double u1, double) const noexcept { return 2 * (1 - u1); }
  double largest() const noexcept { return value(1); }
  double mean_cosine() const noexcept { return 0; }
  double moment(int l) const noexcept { return l == 0 ? 1 : 0; }
  IsotropicPhase blunted(double) const noexcept { return *this; }
};

}  // namespace obscura
