#include "photon/optics/band.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "octree/base/error.h"
#include "tests/support/planck_band.h"

using namespace obscura;

namespace {

double relative(double value, double reference) { return std::abs(value - reference) / std::abs(reference); }

const Spectrum kTent = Spectrum::table({8, 10, 12}, {0, 1, 0});

}  // namespace

TEST_CASE("a band of n samples is n equal intervals", "[photon][band]") {
  const Band band("lwir", 8, 12, 5);
  REQUIRE(band.interval_count() == 5);
  double weight = 0;
  for (int j = 0; j < 5; ++j) {
    const Interval& i = band.intervals()[j];
    CHECK(i.um_min == Approx(8 + 0.8 * j).epsilon(1e-15));
    CHECK(i.um_max == Approx(8 + 0.8 * (j + 1)).epsilon(1e-15));
    CHECK(i.um_effective == Approx(8.4 + 0.8 * j).epsilon(1e-15));
    CHECK(i.weight == Approx(0.2).epsilon(1e-14));
    weight += i.weight;
  }
  CHECK(weight == Approx(1).epsilon(1e-15));
  CHECK(band.um_min() == 8);
  CHECK(band.um_max() == 12);
  CHECK(band.intervals()[4].um_max == 12);
}

TEST_CASE("the intervals add up to the band's Planck radiance", "[photon][band]") {
  for (const Spectrum& response : {Spectrum(1), kTent, Spectrum::table({9, 9.3, 9.4}, {1, 0, 0.5})}) {
    const Band one("one", 8, 12, 1, response);
    for (const int n : {2, 3, 7, 64}) {
      const Band many("many", 8, 12, n, response);
      for (const double K : {5.0, 300.0, 9000.0}) {
        double sum = 0;
        for (int j = 0; j < n; ++j) sum += many.planck(j, K);
        CHECK(relative(sum, one.planck(0, K)) < 1e-13);
        CHECK(relative(many.planck(K), sum) < 1e-15);
        CHECK(relative(many.brightness_temperature(many.planck(K)), K) < 1e-12);
        CHECK(relative(many.planck_derivative(K), one.planck_derivative(K)) < 1e-13);
      }
    }
  }
  CHECK(relative(Band("lwir", 8, 12).planck(300), test::planck_band(8, 12, 300)) < 1e-15);
  CHECK(Band("lwir", 8, 12).planck(0) == 0);
  CHECK(Band("lwir", 8, 12).brightness_temperature(-1) == 0);
  // The response is not normalised: twice the response, twice the radiance.
  CHECK(relative(Band("b", 8, 12, 1, 2).planck(300), 2 * test::planck_band(8, 12, 300)) < 1e-15);
}

TEST_CASE("the effective wavelength is the mean weighted with the response", "[photon][band]") {
  const Band tent("tent", 8, 12, 1, kTent);
  CHECK(tent.intervals()[0].um_effective == Approx(10).epsilon(1e-15));
  const Band halves("halves", 8, 12, 2, kTent);
  // A triangle's centroid is at a third of its base from the tall side.
  CHECK(halves.intervals()[0].um_effective == Approx(10 - 2.0 / 3).epsilon(1e-15));
  CHECK(halves.intervals()[1].um_effective == Approx(10 + 2.0 / 3).epsilon(1e-15));
  CHECK(halves.intervals()[0].weight == Approx(0.5).epsilon(1e-15));
}

TEST_CASE("an interval without response has weight zero and harms nothing", "[photon][band]") {
  const Spectrum response = Spectrum::table({8, 9, 10, 12}, {1, 0, 0, 0});
  const Band band("band", 8, 12, 4, response);
  const Interval& dead = band.intervals()[2];
  CHECK(dead.weight == 0);
  CHECK(dead.um_effective == 10.5);
  CHECK(band.planck(2, 300) == 0);
  CHECK(band.integrate(2, 5) == 0);
  CHECK(band.optics(2, kTent) == Approx(0.75));
  CHECK(band.intervals()[0].weight == 1);
  CHECK(relative(band.planck(300), band.planck(0, 300)) < 1e-15);
  CHECK(relative(band.brightness_temperature(band.planck(300)), 300) < 1e-12);
}

TEST_CASE("spectral quantities are integrated with the response", "[photon][band]") {
  const Band band("band", 8, 12, 2, kTent);
  CHECK(band.integrate(0, 3) == Approx(3).epsilon(1e-15));
  CHECK(band.integrate(0, 3) + band.integrate(1, 3) == Approx(6).epsilon(1e-15));
  CHECK(band.integrate(0, kTent) == Approx(2.0 / 3).epsilon(1e-15));
  CHECK(band.optics(0, kTent) == Approx(2.0 / 3).epsilon(1e-15));
}

TEST_CASE("a grey band is one interval of the values themselves", "[photon][band]") {
  const Band grey("grey");
  CHECK(grey.grey());
  REQUIRE(grey.interval_count() == 1);
  CHECK(grey.intervals()[0].weight == 1);
  CHECK(grey.integrate(0, 2.5) == 2.5);
  CHECK(grey.optics(0, 0.7) == 0.7);
  CHECK_FALSE(Band("b", 3, 5).grey());
}

TEST_CASE("a band that makes no sense is refused", "[photon][band]") {
  CHECK_THROWS_AS(Band("b", 12, 8), InputError);
  CHECK_THROWS_AS(Band("b", 8, 8), InputError);
  CHECK_THROWS_AS(Band("b", 0, 8), InputError);
  CHECK_THROWS_AS(Band("b", std::nan(""), 8), InputError);
  CHECK_THROWS_AS(Band("b", 8, 12, 0), InputError);
  CHECK_THROWS_AS(Band("b", 8, 12, 1, 0), InputError);
  CHECK_THROWS_AS(Band("b", 8, 12, 1, -1), InputError);
  CHECK_THROWS_AS(Band("b", 8, 12, 1, Spectrum::table({1, 2}, {1, 0})), InputError);
}
