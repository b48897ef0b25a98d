// Planck's law against the reference tables g1 to g5 (40-digit arithmetic, CODATA 2018; metres).
#include "photon/optics/planck.h"

#include <catch2/catch.hpp>

#include "octree/base/math.h"
#include "photon/optics/band.h"
#include "photon/optics/planck_table.h"
#include "tests/support/places.h"
#include "tests/support/planck_band.h"
#include "tests/support/verified.h"

using namespace obscura;
using test::Csv;
using test::planck_band;

namespace {

const std::string kFolder = test::data_file("reference/");

double relative(double value, double reference) { return std::abs(value - reference) / std::abs(reference); }

// Brute force in extended precision and another variable: Boole's rule (Abramowitz &
// Stegun 25.4.14) over ln(um), on steps so short that e^-x changes by less than 2 % each.
long double brute_band(double um_min, double um_max, double K) {
  const long double h = 6.62607015e-34L, c = 299792458.0L, k = 1.380649e-23L;
  const auto integrand = [&](long double y) {
    const long double m = std::exp(y) * 1e-6L;
    return 2 * h * c * c / (m * m * m * m * std::expm1(h * c / (m * k * K)));
  };
  long double sum = 0;
  long double y = std::log(static_cast<long double>(um_min));
  const long double end = std::log(static_cast<long double>(um_max));
  while (y < end) {
    const long double x = h * c / (std::exp(y) * 1e-6L * k * K);
    const long double step = std::min(end - y, 0.02L / std::max(1.0L, x));
    sum += step / 90 *
           (7 * (integrand(y) + integrand(y + step)) + 12 * integrand(y + step / 2) +
            32 * (integrand(y + step / 4) + integrand(y + 3 * step / 4)));
    y += step;
  }
  return sum;
}

double planck_band_derivative(double um_min, double um_max, double K) {
  return test::band(um_min, um_max).derivative(K);
}

double brightness_temperature(double um_min, double um_max, double radiance) {
  return test::band(um_min, um_max).brightness_temperature(radiance);
}

}  // namespace

TEST_CASE("band radiance is right to 1e-10 from 1 K to 100,000 K", "[photon][planck]") {
  const Csv csv(kFolder + "g1_planck_band.csv");
  REQUIRE(csv.size() > 40);
  test::Verified verified("g1_planck_band.csv", "Planck", "band radiance and slope, every row above 1e-300",
                          "1e-12, slope 1e-11");
  for (std::size_t i = 0; i < csv.size(); ++i) {
    const double K = csv.number(i, "T_K");
    const double a = csv.number(i, "l1_m") * 1e6;
    const double b = csv.number(i, "l2_m") * 1e6;
    const double radiance = csv.number(i, "L_band");
    const double slope = csv.number(i, "dLdT");
    INFO("K " << K << ", " << a << " to " << b << " um");
    if (radiance < 1e-300) {
      CHECK(planck_band(a, b, K) == 0);
    } else {
      CHECK(relative(planck_band(a, b, K), radiance) < 1e-12);
      verified.within(planck_band(a, b, K), radiance, 1e-12);
      verified.within(planck_band_derivative(a, b, K), slope, 1e-11);
      CHECK(relative(planck_band_derivative(a, b, K), slope) < 1e-11);
    }
  }
}

TEST_CASE("band radiance is right to 1e-10 over the whole range", "[photon][planck]") {
  for (const double K : {2.0, 5.0, 20.0, 70.0, 72.0, 300.0, 2500.0, 10000.0}) {
    for (const auto& [a, b] : {std::pair{0.3, 0.32},
                               {0.4, 0.7},
                               {1.0, 1.001},
                               {2.0, 3.0},
                               {3.0, 5.0},
                               {8.0, 12.0},
                               {9.0, 30.0},
                               {20.0, 100.0},
                               {99.0, 100.0}}) {
      // Where e^-x changes fast the brute force takes long, and the result is 0 anyway.
      if (14388 / (b * K) > 750) continue;
      const long double reference = brute_band(std::max(a, 14388 / K / (14388 / (b * K) + 60)), b, K);
      const double value = planck_band(a, b, K);
      INFO("K " << K << ", " << a << " to " << b << " um");
      if (reference < 1e-300L) {
        CHECK(value == 0);
      } else {
        const double error = static_cast<double>(std::abs(value / reference - 1));
        CHECK(error < 1e-11);
      }
    }
  }
}

TEST_CASE("spectral radiance is right", "[photon][planck]") {
  const Csv csv(kFolder + "g2_planck_spectral.csv");
  test::Verified verified("g2_planck_spectral.csv", "Planck", "spectral radiance, every row above 1e-300", "1e-12");
  for (std::size_t i = 0; i < csv.size(); ++i) {
    const double K = csv.number(i, "T_K");
    const double um = csv.number(i, "lambda_m") * 1e6;
    const double per_um = csv.number(i, "B_lambda") * 1e-6;
    INFO("K " << K << ", " << um << " um");
    if (per_um >= 1e-300) verified.within(planck_spectral(um, K), per_um, 1e-12);
    if (per_um < 1e-300)
      CHECK(planck_spectral(um, K) == 0);
    else
      CHECK(relative(planck_spectral(um, K), per_um) < 1e-12);
  }
}

TEST_CASE("the inverses give back the temperature", "[photon][planck]") {
  test::Verified verified_mono("g3_brightness_temperature_mono.csv", "Planck", "every row", "1e-13");
  test::Verified verified_band("g4_brightness_temperature_band.csv", "Planck", "every row", "1e-13");
  const Csv mono(kFolder + "g3_brightness_temperature_mono.csv");
  for (std::size_t i = 0; i < mono.size(); ++i) {
    const double um = mono.number(i, "lambda_m") * 1e6;
    const double per_um = mono.number(i, "L_lambda") * 1e-6;
    INFO(um << " um, " << per_um);
    verified_mono.within(brightness_temperature(um, per_um), mono.number(i, "T_b_K"), 1e-13);
    CHECK(relative(brightness_temperature(um, per_um), mono.number(i, "T_b_K")) < 1e-13);
  }
  const Csv band(kFolder + "g4_brightness_temperature_band.csv");
  for (std::size_t i = 0; i < band.size(); ++i) {
    const double a = band.number(i, "l1_m") * 1e6;
    const double b = band.number(i, "l2_m") * 1e6;
    INFO(a << " to " << b << " um, " << band.number(i, "L_band"));
    verified_band.within(brightness_temperature(a, b, band.number(i, "L_band")), band.number(i, "T_b_K"), 1e-13);
    CHECK(relative(brightness_temperature(a, b, band.number(i, "L_band")), band.number(i, "T_b_K")) < 1e-13);
  }
}

TEST_CASE("radiance and temperature are inverse over the whole range", "[photon][planck]") {
  for (const double K : {2.0, 3.0, 10.0, 77.0, 250.0, 300.0, 1000.0, 3000.0, 10000.0, 1e6}) {
    for (const auto& [a, b] : {std::pair{0.3, 100.0},
                               {0.3, 0.31},
                               {3.0, 5.0},
                               {8.0, 12.0},
                               {10.0, 10.0001},
                               {50.0, 100.0},
                               {0.3, 0.3000001}}) {
      INFO("K " << K << ", " << a << " to " << b << " um");
      const double radiance = planck_band(a, b, K);
      if (radiance == 0) continue;
      CHECK(relative(brightness_temperature(a, b, radiance), K) < 1e-12);
    }
  }
  for (double K = 2; K < 1e6; K *= 1.07) {
    const double radiance = planck_band(0.3, 100, K);
    CHECK(relative(brightness_temperature(0.3, 100, radiance), K) < 1e-13);
  }
  CHECK(brightness_temperature(8, 12, 0.0) == 0);
  CHECK(brightness_temperature(8, 12, -1.0) == 0);
  CHECK(brightness_temperature(10.0, 0.0) == 0);
  CHECK(brightness_temperature(8, 12, 5e-324) > 0);
  CHECK(brightness_temperature(8, 12, kInfinity) == kInfinity);
}

TEST_CASE("the whole spectrum adds up to Stefan and Boltzmann's law", "[photon][planck]") {
  const Csv csv(kFolder + "g5_stefan_boltzmann.csv");
  test::Verified verified("g5_stefan_boltzmann.csv", "Planck", "sigma T^4, and the band that is the whole spectrum",
                          "1e-14");
  for (std::size_t i = 0; i < csv.size(); ++i) {
    const double K = csv.number(i, "T_K");
    const double exitance = csv.number(i, "exitance");
    CHECK(relative(kStefanBoltzmann * K * K * K * K, exitance) < 1e-14);
    // From x = 200 (e^-200 is nothing) to x = 1e-5 (what is missing is x^3 / 3).
    const double whole = kPi * planck_band(14387.76877 / K / 200, 14387.76877 / K * 1e5, K);
    CHECK(relative(whole, exitance) < 1e-14);
    verified.within(whole, exitance, 1e-14);
  }
}

TEST_CASE("a band is the sum of its parts, however narrow", "[photon][planck]") {
  for (const double K : {20.0, 300.0, 5000.0}) {
    const double whole = planck_band(8, 12, K);
    double sum = 0;
    for (int i = 0; i < 1000; ++i) sum += planck_band(8 + 0.004 * i, 8 + 0.004 * (i + 1), K);
    CHECK(relative(sum, whole) < 1e-12);
    // A band of 1e-9 of its wavelength: the spectral radiance times the width.
    const double a = 10, b = 10 * (1 + 0x1p-30);
    CHECK(relative(planck_band(a, b, K), planck_spectral(0.5 * (a + b), K) * (b - a)) < 1e-13);
  }
  CHECK(planck_band(8, 8, 300) == 0);
}

TEST_CASE("a very hot band follows Rayleigh and Jeans", "[photon][planck]") {
  // B = 2 c k T / lambda^4, with a relative remainder of x / 2.
  const double K = 1e14;
  const double band = 2 * kSpeedOfLight * kBoltzmannConstant * K / 3 * (std::pow(8e-6, -3) - std::pow(12e-6, -3));
  CHECK(relative(planck_band(8, 12, K), band) < 1e-10);
  CHECK(relative(planck_band_derivative(8, 12, K), band / K) < 1e-10);
  CHECK(relative(brightness_temperature(8, 12, band), K) < 1e-10);
}

TEST_CASE("what is below 1e-300 is zero", "[photon][planck]") {
  CHECK(planck_band(8, 12, brightness_temperature(8, 12, 1.01e-300)) > 0);
  CHECK(planck_band(8, 12, brightness_temperature(8, 12, 0.99e-300)) == 0);
  CHECK(planck_spectral(10, brightness_temperature(10, 1.01e-300)) > 0);
  CHECK(planck_spectral(10, brightness_temperature(10, 0.99e-300)) == 0);
}

TEST_CASE("no temperature gives no radiance", "[photon][planck]") {
  for (const double K : {0.0, -1.0, -kInfinity, 1e-300}) {
    CHECK(planck_band(8, 12, K) == 0);
    CHECK(planck_band_derivative(8, 12, K) == 0);
    CHECK(planck_spectral(10, K) == 0);
  }
}

TEST_CASE("the derivative is the slope of the radiance", "[photon][planck]") {
  for (const double K : {10.0, 300.0, 3000.0}) {
    const double h = 1e-5 * K;
    const auto five_point = [&](auto f) {
      return (8 * (f(K + h) - f(K - h)) - (f(K + 2 * h) - f(K - 2 * h))) / (12 * h);
    };
    CHECK(relative(planck_band_derivative(3, 5, K), five_point([](double t) { return planck_band(3, 5, t); })) < 1e-8);
  }
}

TEST_CASE("a linear response is weighted exactly", "[photon][planck]") {
  // Brute force: the response as 20,000 steps, second order in their width.
  const Spectrum response = Spectrum::table({8, 9, 9.5, 12}, {0, 1, 0.2, 0});
  const WeightedPlanck weighted(7.5, 12.5, response);
  for (const double K : {40.0, 300.0, 4000.0}) {
    double steps = 0;
    const int n = 20000;
    for (int i = 0; i < n; ++i) {
      const double a = 8 + 4.0 * i / n, b = 8 + 4.0 * (i + 1) / n;
      steps += response.value(0.5 * (a + b)) * planck_band(a, b, K);
    }
    CHECK(relative(weighted.radiance(K), steps) < 1e-7);

    // Exact: a triangle up and its mirror image down add up to a box.
    const double up = WeightedPlanck(8, 12, Spectrum::table({8, 12}, {0, 1})).radiance(K);
    const double down = WeightedPlanck(8, 12, Spectrum::table({8, 12}, {1, 0})).radiance(K);
    CHECK(relative(up + down, planck_band(8, 12, K)) < 1e-13);
    // A cut where the response has no kink changes nothing.
    const Spectrum cut = Spectrum::table({8, 8.1, 12}, {0, 0.025, 1});
    CHECK(relative(WeightedPlanck(8, 12, cut).radiance(K), up) < 1e-13);

    CHECK(relative(weighted.brightness_temperature(weighted.radiance(K)), K) < 1e-12);
  }
  CHECK(WeightedPlanck(8, 12, Spectrum(0)).radiance(300) == 0);
  CHECK(WeightedPlanck(8, 12, Spectrum(0)).brightness_temperature(1) == 0);
}
