#include "photon/optics/planck_table.h"

#include <catch2/catch.hpp>

#include "octree/base/math.h"

using namespace obscura;

namespace {

// The largest relative error of the table over a dense set of temperatures.
double worst(const Band& band, double K_min, double K_max) {
  const PlanckTable table(band, 0, K_min, K_max);
  double result = 0;
  for (int i = 0; i <= 5000; ++i) {
    const double K = K_min * std::pow(K_max / K_min, i / 5000.0);
    const double exact = band.planck(0, K);
    const double value = table(K);
    if (exact == 0 || value == 0) {
      // Both are 0 except within rounding of the threshold.
      CHECK(std::max(exact, value) < 1.001e-300);
      continue;
    }
    result = std::max(result, std::abs(value - exact) / exact);
  }
  return result;
}

}  // namespace

TEST_CASE("the Planck table is right to 1e-9", "[photon][planck]") {
  CHECK(worst(Band("lwir", 8, 12), 2, 10000) < 1e-9);
  CHECK(worst(Band("mwir", 3, 5), 2, 10000) < 1e-9);
  CHECK(worst(Band("visible", 0.3, 0.7), 100, 10000) < 1e-9);
  CHECK(worst(Band("line", 10, 10.001), 2, 10000) < 1e-9);
  CHECK(worst(Band("all", 0.3, 100), 2, 10000) < 1e-9);
  CHECK(worst(Band("triangle", 8, 12, 1, Spectrum::table({8, 10, 12}, {0, 1, 0})), 2, 10000) < 1e-9);
  CHECK(worst(Band("two", 3, 12, 1, Spectrum::table({3, 5, 5.1, 8, 8.1, 12}, {1, 1, 0, 0, 1, 1})), 2, 10000) < 1e-9);
}

TEST_CASE("the Planck table stays right at and beyond its ends", "[photon][planck]") {
  const Band band("lwir", 8, 12);
  const PlanckTable table(band, 0, 250, 320);
  for (const double K : {249.9999, 250.0, 320.0, 320.0001, 100.0, 5000.0, 1.0, 1e9}) {
    INFO("K " << K);
    CHECK(table(K) == Approx(band.planck(0, K)).epsilon(1e-9).margin(1e-300));
  }
  CHECK(table(0) == 0);
  CHECK(table(-5) == 0);
  CHECK(std::isnan(table(std::nan(""))));
  const PlanckTable point(band, 0, 300, 300);
  CHECK(point(300) == Approx(band.planck(0, 300)).epsilon(1e-12));
}
