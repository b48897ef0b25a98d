#include "photon/optics/spectrum.h"

#include <catch2/catch.hpp>
#include <limits>

#include "octree/base/error.h"

using namespace obscura;

TEST_CASE("a number is the same at all wavelengths", "[photon][spectrum]") {
  const Spectrum s = 0.25;
  CHECK(s.is_constant());
  CHECK(s.value(0.3) == 0.25);
  CHECK(s.value(1e9) == 0.25);
  CHECK(s.min(1, 2) == 0.25);
  CHECK(integral(s, 2, 6) == 1);
  CHECK(Spectrum().value(10) == 0);
  CHECK(Spectrum::constant(3) == Spectrum(3));
}

TEST_CASE("a table is linear in between and constant outside", "[photon][spectrum]") {
  const Spectrum s = Spectrum::table({8, 9, 12}, {0.1, 0.2, 0.15});
  CHECK_FALSE(s.is_constant());
  CHECK(s.value(1) == 0.1);
  CHECK(s.value(8) == 0.1);
  CHECK(s.value(8.5) == Approx(0.15).epsilon(1e-15));
  CHECK(s.value(9) == 0.2);
  CHECK(s.value(10.5) == Approx(0.175).epsilon(1e-15));
  CHECK(s.value(12) == 0.15);
  CHECK(s.value(100) == 0.15);
  CHECK(s.max(8.5, 8.75) == Approx(0.175).epsilon(1e-15));
  CHECK(s.max(8.5, 11) == 0.2);
  CHECK(s.min(8.5, 20) == Approx(0.15).epsilon(1e-15));
  CHECK(s.max() == 0.2);
  CHECK(s.min() == 0.1);
  CHECK(Spectrum::table({5}, {2}).value(7) == 2);
  CHECK(Spectrum::table({5, 6}, {2, 2}).is_constant());
}

TEST_CASE("integrals of spectra and their products are exact", "[photon][spectrum]") {
  const Spectrum ramp = Spectrum::table({0.5, 20}, {0.5, 20});  // the wavelength itself
  CHECK(integral(ramp, 2, 5) == Approx((25 - 4) / 2.0).epsilon(1e-15));
  CHECK(integral_of_product(ramp, ramp, 2, 5) == Approx((125 - 8) / 3.0).epsilon(1e-15));
  CHECK(first_moment(ramp, 2, 5) == Approx((125 - 8) / 3.0).epsilon(1e-15));
  CHECK(first_moment(Spectrum(2), 2, 5) == Approx(21).epsilon(1e-15));

  // A tent times a step down that falls in the tent's flank; the tails beyond the tables count.
  const Spectrum tent = Spectrum::table({8, 10, 12}, {0, 1, 0});
  const Spectrum edge = Spectrum::table({9, 11}, {1, 0});
  // By hand: [8,9] (um-8)/2 gives 1/4, [9,10] (um-8)(11-um)/4 gives 13/24, [10,11]
  // (12-um)(11-um)/4 gives 5/24.
  CHECK(integral_of_product(tent, edge, 8, 12) == Approx(1.0 / 4 + 13.0 / 24 + 5.0 / 24).epsilon(1e-15));
  CHECK(integral_of_product(edge, tent, 0.1, 50) == Approx(1.0).epsilon(1e-15));
  CHECK(integral(tent, 10, 10) == 0);
  CHECK(integral(edge, 1, 9) == 8);
}

TEST_CASE("a table that makes no sense is refused", "[photon][spectrum]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(Spectrum::table({}, {}), InputError);
  CHECK_THROWS_AS(Spectrum::table({1, 2}, {1}), InputError);
  CHECK_THROWS_AS(Spectrum::table({2, 1}, {1, 1}), InputError);
  CHECK_THROWS_AS(Spectrum::table({2, 2}, {1, 1}), InputError);
  CHECK_THROWS_AS(Spectrum::table({0, 2}, {1, 1}), InputError);
  CHECK_THROWS_AS(Spectrum::table({-1, 2}, {1, 1}), InputError);
  CHECK_THROWS_AS(Spectrum::table({1, nan}, {1, 1}), InputError);
  CHECK_THROWS_AS(Spectrum::table({1, 2}, {1, nan}), InputError);
}
