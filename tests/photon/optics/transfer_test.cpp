// Segment functions against the reference table h1 (50-digit values).
#include "photon/optics/transfer.h"

#include <catch2/catch.hpp>

#include "octree/base/math.h"
#include "tests/support/places.h"
#include "tests/support/verified.h"

using namespace obscura;

namespace {

// Relative, and absolute where the true value is below the smallest normal number.
bool close(double value, double reference) {
  return std::abs(value - reference) <= 1e-13 * std::abs(reference) + 5e-324;
}

double w_near(double tau) { return linear_source_weights(tau).near; }
double w_far(double tau) { return linear_source_weights(tau).far; }

}  // namespace

TEST_CASE("segment functions keep 1e-13 from 1e-300 to 1e300", "[photon][transfer]") {
  const test::Csv csv(test::data_file("reference/h1_exp_functions.csv"));
  REQUIRE(csv.size() > 25);
  test::Verified verified("h1_exp_functions.csv", "segment functions",
                          "all four functions of every row, tau from 1e-300 to 1e300", "1e-13");
  for (std::size_t i = 0; i < csv.size(); ++i) {
    const double tau = csv.number(i, "tau");
    INFO("tau " << tau);
    for (const auto& [value, column] :
         {std::pair(one_minus_exp(tau), "one_minus_exp"), std::pair(mean_transmission(tau), "mean_trans"),
          std::pair(w_far(tau), "w_far"), std::pair(w_near(tau), "w_near")}) {
      if (csv.number(i, column) > 1e-307) verified.within(value, csv.number(i, column), 1e-13);
    }
    CHECK(close(one_minus_exp(tau), csv.number(i, "one_minus_exp")));
    CHECK(close(mean_transmission(tau), csv.number(i, "mean_trans")));
    CHECK(close(w_far(tau), csv.number(i, "w_far")));
    CHECK(close(w_near(tau), csv.number(i, "w_near")));
  }
}

TEST_CASE("segment functions are exact at both limits", "[photon][transfer]") {
  CHECK(one_minus_exp(0) == 0);
  CHECK(mean_transmission(0) == 1);
  CHECK(w_near(0) == 0);
  CHECK(w_far(0) == 0);
  CHECK(one_minus_exp(5e-324) == 5e-324);
  CHECK(mean_transmission(5e-324) == 1);
  CHECK(one_minus_exp(kInfinity) == 1);
  CHECK(mean_transmission(kInfinity) == 0);
  CHECK(w_near(kInfinity) == 1);
  CHECK(w_far(kInfinity) == 0);
}

TEST_CASE("both weights add up to the loss, also where the formula changes", "[photon][transfer]") {
  for (double tau = 0.001; tau < 20; tau *= 1.01) {
    CHECK(close(w_near(tau) + w_far(tau), one_minus_exp(tau)));
  }
  CHECK(w_near(std::nextafter(1.0, 0)) == Approx(w_near(1)).epsilon(1e-15));
  CHECK(w_far(std::nextafter(1.0, 0)) == Approx(w_far(1)).epsilon(1e-15));
}

TEST_CASE("a segment gains what the transfer equation says", "[photon][transfer][not_finite]") {
  // Thin: emission times length; thick: the source function; none: the length itself.
  CHECK(3 * effective_length(0, 7) == 21);
  CHECK(3 * effective_length(1e-300, 7) == 21);
  CHECK(3 * effective_length(5e-324, 7) == 21);
  CHECK(3 * effective_length(2, kInfinity) == 1.5);
  CHECK(3 * effective_length(2, 1e300) == 1.5);
  CHECK(3 * effective_length(1e300, 1e300) == Approx(3e-300));
  CHECK(3 * effective_length(2, 0) == 0);
  CHECK(effective_length(0, kInfinity) == kInfinity);
  CHECK(close(effective_length(0.5, 2), 2 * (1 - std::exp(-1.0))));

  // Two segments in a row are one: gain and transmission compose.
  for (const double k : {1e-9, 0.1, 1.0, 50.0}) {
    const double whole = 3 * effective_length(k, 2);
    const double parts = 3 * effective_length(k, 0.7) + std::exp(-0.7 * k) * 3 * effective_length(k, 1.3);
    CHECK(close(whole, parts));
  }
}
