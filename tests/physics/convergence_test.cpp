// Errors fall with what they cost as theory says: photon/MEASURED.md, "How errors fall". Each judgement has a wrong
// input beside it that it refuses. build/convergence_bench prints the slopes with more repetitions.
#include "tests/support/convergence.h"

#include <catch2/catch.hpp>

using namespace obscura;
using namespace obscura::test;

TEST_CASE("the path tracer's error falls with the root of its flights", "[physics][convergence]") {
  CHECK(is_slope(slope_of(path_errors(1, 6)), -0.5, 0.06));
  // A cloud that emits too little is off by as much, whatever is spent.
  CHECK_FALSE(is_slope(slope_of(path_errors(0.9, 6)), -0.5, 0.06));
}

TEST_CASE("the density estimate's noise falls with the root of k in a ball of one size", "[physics][convergence]") {
  CHECK(is_slope(slope_of(density_noise({}, 250)), -0.5, 0.06));
  LocalLight flickering;
  flickering.flicker = 0.2;
  CHECK_FALSE(is_slope(slope_of(density_noise(flickering, 250)), -0.5, 0.06));
}

TEST_CASE("the density estimate's bias grows with (k / N)^(2/3)", "[physics][convergence]") {
  CHECK(is_slope(slope_of(density_bias({}, 250)), 2.0 / 3, 0.1));
  // Without the edge correction the first order is left: 1/3.
  LocalLight plain;
  plain.shift = 1;
  plain.face = true;
  plain.edge_correction = false;
  const Slope slope = slope_of(density_bias(plain, 250));
  CHECK_FALSE(is_slope(slope, 2.0 / 3, 0.1));
  CHECK(is_slope(slope, 1.0 / 3, 0.1));
}

TEST_CASE("with k as N^(4/7) the density estimate's error falls as N^(-2/7)", "[physics][convergence]") {
  CHECK(is_slope(slope_of(density_total({}, 8, 4.0 / 7, 200)), -2.0 / 7, 0.04));
  // A fixed k keeps its noise.
  CHECK_FALSE(is_slope(slope_of(density_total({}, 64, 0, 200)), -2.0 / 7, 0.04));
}

TEST_CASE("ordinates converge faster than with the square of their cells, and far faster with their order",
          "[physics][convergence]") {
  CHECK(is_slope(slope_of(ordinates_in_cells()), -2.5, 0.3));
  CHECK(is_slope(slope_of(ordinates_in_angle(0)), -5, 0.6));
  // A slab that is a little thicker is another problem: it does not converge to this one.
  std::vector<ErrorAt> other;
  for (const int cells : {8, 16, 32, 64}) {
    other.push_back({static_cast<double>(cells),
                     reflected(cells, 12, 0.5, 0, AngularQuadrature::double_gauss, 2.01) /
                             reflected(128, 12, 0.5, 0, AngularQuadrature::double_gauss) -
                         1,
                     0});
  }
  CHECK_FALSE(is_slope(slope_of(other), -2.5, 0.3));
}
