#include "photon/optics/planck_table.h"

#include <cassert>

#include "octree/base/math.h"

namespace obscura {

PlanckTable::PlanckTable(const Band& band, int interval, double K_min, double K_max)
    : planck_(band.weighted_planck(interval)) {
  assert(K_min > 0 && K_max >= K_min);
  first_row_ = row_of(1 / K_max);
  const std::int64_t last_row = row_of(1 / K_min);

  // ln L and its first two derivatives with respect to u = 1/K at a row's start:
  // with K = 1/u and a = d ln L / d ln K, b = K^2 L''/L: d/du = -a/u, d2/du2 = (b - a^2 + 2a) /
  // u^2.
  struct Node {
    double u, value, first, second;
  };
  const auto node = [&](std::int64_t row) {
    const double u = row_start(row);
    const LogPlanck p = planck_.log_radiance(1 / u);
    return Node{u, p.log, -p.slope / u, (p.second - p.slope * p.slope + 2 * p.slope) / (u * u)};
  };

  Node left = node(first_row_);
  for (std::int64_t row = first_row_; row <= last_row; ++row) {
    const Node right = node(row + 1);
    const double h = right.u - left.u;
    Row r{left.u, 1 / h, {}};
    if (left.value == -kInfinity) {
      r.c = {-kInfinity, 0, 0, 0, 0, 0};
    } else {
      // Quintic Hermite interpolation in monomials of s.
      const double d0 = h * left.first, d1 = h * right.first;
      const double e0 = 0.5 * h * h * left.second, e1 = 0.5 * h * h * right.second;
      const double rise = right.value - left.value;
      r.c = {left.value,
             d0,
             e0,
             10 * rise - 6 * d0 - 4 * d1 - 3 * e0 + e1,
             -15 * rise + 8 * d0 + 7 * d1 + 3 * e0 - 2 * e1,
             6 * rise - 3 * d0 - 3 * d1 - e0 + e1};
    }
    rows_.push_back(r);
    left = right;
  }
}

}  // namespace obscura
