#include "photon/optics/quadrature.h"

#include <cassert>

#include "octree/base/math.h"

namespace obscura {

GaussLegendre::GaussLegendre(int points) : node(points), weight(points) {
  assert(points > 0);
  for (int i = 0; i < points; ++i) {
    // Newton on the Legendre polynomial P_n from the asymptotic place of its root (Abramowitz &
    // Stegun 22.16.6, 25.4.29).
    double x = -std::cos(kPi * (i + 0.75) / (points + 0.5));
    double derivative = 1;
    for (int step = 0; step < 100; ++step) {
      double p = 1;
      double previous = 0;
      for (int n = 1; n <= points; ++n) {
        const double next = ((2 * n - 1) * x * p - (n - 1) * previous) / n;
        previous = p;
        p = next;
      }
      derivative = points * (x * p - previous) / (x * x - 1);
      const double change = p / derivative;
      x -= change;
      if (std::abs(change) < 1e-16) break;
    }
    node[i] = 0.5 * (1 + x);
    weight[i] = 1 / ((1 - x * x) * derivative * derivative);
  }
}

}  // namespace obscura
