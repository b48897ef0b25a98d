// Settings of discrete ordinates for layers that repeat.
#pragma once

#include "photon/ordinates/ordinates.h"
#include "tests/support/slabs.h"

namespace obscura::test {

inline OrdinatesSettings slab_settings(int cells, int order) {
  OrdinatesSettings settings;
  settings.cells = Vec3i(1, 1, cells);
  settings.order = order;
  settings.quadrature = AngularQuadrature::double_gauss;
  return settings;
}

/// Light of a sun at mu0: shares reflected, transmitted after scattering, absorbed.
struct SlabShares {
  double up, down, absorbed;
  int sweeps;
  double residual;
};

inline SlabShares slab_shares(const SlabWish& slab, const OrdinatesSettings& settings) {
  const World world(slab_contents(slab));
  const OrdinatesSolution solution = solve_ordinates({world, 0}, settings);
  const OrdinatesPowers& powers = solution.powers();
  const double in = 64 * (slab.mu0 > 0 ? slab.mu0 : slab.sky > 0 ? kPi : 1.0);
  return {powers.left[2][1] / in, powers.left[2][0] / in, (powers.absorbed + powers.first_absorbed) / in,
          solution.iterations(), powers.residual()};
}

}  // namespace obscura::test
