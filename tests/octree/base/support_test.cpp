// The tests' own judges, against published tables and against samples that must and must not pass.
#include <catch2/catch.hpp>

#include "octree/base/random.h"
#include "tests/support/agree.h"
#include "tests/support/chi_square.h"

using namespace obscura;
using namespace obscura::test;

TEST_CASE("tails and quantiles are those of the printed tables", "[support]") {
  // Abramowitz & Stegun, tables 26.7, 26.8 and 26.10.
  CHECK(chi_square_tail(3.841458821, 1) == Approx(0.05).epsilon(1e-8));
  CHECK(chi_square_tail(18.307038053, 10) == Approx(0.05).epsilon(1e-8));
  CHECK(chi_square_tail(149.4492527, 100) == Approx(0.001).epsilon(1e-6));
  CHECK(chi_square_tail(5, 2) == Approx(std::exp(-2.5)).epsilon(1e-13));
  CHECK(chi_square_tail(0, 3) == 1);
  CHECK(student_two_sided_tail(12.706204736, 1) == Approx(0.05).epsilon(1e-9));
  CHECK(student_two_sided_tail(2.131449546, 15) == Approx(0.05).epsilon(1e-9));
  CHECK(student_two_sided_tail(-2.131449546, 15) == Approx(0.05).epsilon(1e-9));
  CHECK(student_limit(0.05) == Approx(1.959963985).epsilon(1e-9));
  CHECK(student_limit(1e-6) == Approx(4.891638476).epsilon(1e-9));
  CHECK(student_limit(0.01, 15) == Approx(2.946712883).epsilon(1e-8));
}

TEST_CASE("a mean agrees when it is near and known well enough", "[support][not_finite]") {
  CHECK(agree(1.0, 0.001, 1.0, {.resolution = 0.01}));
  CHECK(agree(1.004, 0.001, 1.0, {.resolution = 0.01}));
  CHECK_FALSE(agree(1.005, 0.001, 1.0, {.resolution = 0.01}));  // off by 5 errors
  CHECK_FALSE(agree(1.0, 0.002, 1.0, {.resolution = 0.01}));    // right by luck
  CHECK_FALSE(agree(1.0, 0.001, 1.0, {.resolution = 0.01, .reference_error = 0.002}));
  CHECK(agree(1.005, 0.001, 1.0, {.resolution = 0.02, .comparisons = 1000}));
  CHECK(agree(1.005, 0.001, 1.0, {.resolution = 0.02, .degrees_of_freedom = 15}));
  CHECK_FALSE(agree(std::nan(""), 0.001, 1.0));
  CHECK_FALSE(agree(1.0, std::nan(""), 1.0));
  CHECK(agree(2.0, 0.0, 2.0));
  CHECK_FALSE(agree(2.1, 0.0, 2.0));
}

TEST_CASE("the chi-square test passes fair samples and fails loaded ones", "[support]") {
  const auto die = [](double loading, std::uint64_t history) {
    Stream stream(1, history, 0);
    std::vector<double> observed(6), expected(6, 100000 / 6.0);
    for (int i = 0; i < 100000; ++i) {
      const double u = stream.uniform() * (1 + loading);
      ++observed[static_cast<std::size_t>(std::min(u * 6, 5.0))];
    }
    return chi_square(observed, expected);
  };
  CHECK(die(0, 1));
  CHECK_FALSE(die(0.03, 2));
  // Under the right law the p-value itself is uniform.
  std::vector<double> observed(10), expected(10, 30);
  for (std::uint64_t i = 0; i < 300; ++i) {
    ++observed[static_cast<std::size_t>(std::min(die(0, i).p_value * 10, 9.0))];
  }
  CHECK(chi_square(observed, expected));
}

TEST_CASE("samples where none is expected fail the chi-square test", "[support]") {
  CHECK_FALSE(chi_square({1000, 1000, 3}, {1000, 1000, 0}));
  CHECK(chi_square({1000, 1000, 0}, {1000, 1000, 0}));
  CHECK(chi_square({1000, 1000, 1, 2, 0, 3}, {1000, 1000, 2, 1, 1, 2}));
  CHECK_FALSE(chi_square({1000, 1000, 30, 40, 50, 60}, {1000, 1000, 2, 1, 1, 1}));
}

TEST_CASE("directions are tested against their density", "[support]") {
  const auto uniform = [](Stream& stream) {
    const double z = 2 * stream.uniform() - 1;
    const double phi = 2 * kPi * stream.uniform();
    const double sine = std::sqrt(1 - z * z);
    return Vec3d(sine * std::cos(phi), sine * std::sin(phi), z);
  };
  Stream a(1, 0, 0), b(1, 1, 0);
  CHECK(chi_square_directions([&] { return uniform(a); }, [](const Vec3d&) { return 0.25 / kPi; }, 100000));
  CHECK_FALSE(chi_square_directions([&] { return uniform(b); },
                                    [](const Vec3d& w) { return 0.25 / kPi * (1 + 0.1 * w.x); }, 100000));
}
