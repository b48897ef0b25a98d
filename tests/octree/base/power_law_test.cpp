#include "octree/base/power_law.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "octree/base/random.h"
#include "octree/base/statistics.h"

using namespace obscura;

TEST_CASE("a power law is found from points on it", "[power_law]") {
  const std::vector<double> x{1, 4, 16, 64}, errors(4, 0.0);
  std::vector<double> y;
  for (const double v : x) y.push_back(3 * std::pow(v, -0.5));
  const auto law = fit_power_law(x, y, errors);
  REQUIRE(law);
  CHECK(law->exponent == Approx(-0.5));
  CHECK(law->factor == Approx(3));
  CHECK(law->points == 4);
}

TEST_CASE("points that are not positive are left out, and one place says nothing", "[power_law]") {
  const std::vector<double> x{1, 2, 4, 8}, y{2, 0, 8, 16}, errors(4, 0.1);
  const auto law = fit_power_law(x, y, errors);
  REQUIRE(law);
  CHECK(law->points == 3);
  CHECK(law->exponent == Approx(1));
  const std::vector<double> same{5, 5, 5, 5};
  CHECK_FALSE(fit_power_law(same, y, errors));
  CHECK_FALSE(fit_power_law(std::vector<double>{1}, std::vector<double>{1}, std::vector<double>{0}));
}

TEST_CASE("the exponent's standard error is its scatter", "[power_law]") {
  Moments exponents, claimed;
  for (std::uint64_t trial = 0; trial < 400; ++trial) {
    Stream random(1, trial, 0);
    std::vector<double> x, y, errors;
    for (int i = 0; i < 6; ++i) {
      x.push_back(std::pow(4, i));
      // A sum of twelve uniform numbers less 6 is nearly normal with variance 1.
      double normal = -6;
      for (int k = 0; k < 12; ++k) normal += random.uniform();
      const double law = 0.2 * std::pow(x.back(), -0.5);
      y.push_back(law * std::exp(0.1 * normal));
      errors.push_back(0.1 * y.back());
    }
    const auto law = fit_power_law(x, y, errors);
    exponents.add(law->exponent);
    claimed.add(law->exponent_error);
  }
  CHECK(std::abs(exponents.mean() + 0.5) < 5 * exponents.standard_error());
  // Where the scatter is by chance larger than the errors say it counts: a little more on the average.
  CHECK(claimed.mean() > 0.9 * std::sqrt(exponents.variance()));
  CHECK(claimed.mean() < 1.4 * std::sqrt(exponents.variance()));
}
