// Gauss-Legendre quadrature: nodes and weights on [0, 1] for any number of points.
#pragma once

#include <vector>

namespace obscura {

/// Exact for polynomials up to degree 2 n - 1. Made once, where set-up may allocate.
struct GaussLegendre {
  explicit GaussLegendre(int points);

  std::vector<double> node;    ///< in (0, 1), increasing
  std::vector<double> weight;  ///< adds up to 1
};

}  // namespace obscura
