// Each kernel against quadrature over its ball.
#include "photon/map/kernel.h"

#include <catch2/catch.hpp>

using namespace obscura;

namespace {

/// At a squared distance in units of the radius.
double kernel_value(Kernel kernel, double u) { return detail::kernel_norm(kernel) * detail::kernel_shape(kernel, u); }

}  // namespace

TEST_CASE("each kernel is normalised on its ball and falls to its rim", "[photon][kernel]") {
  const auto kernel = GENERATE(Kernel::constant, Kernel::epanechnikov, Kernel::cone, Kernel::gaussian);
  const int steps = 20000;
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const double t = (i + 0.5) / steps;
    sum += kernel_value(kernel, t * t) * 4 * std::numbers::pi * t * t / steps;
  }
  CHECK(sum == Approx(1).epsilon(1e-8));
  CHECK(kernel_value(kernel, 0.999) > 0);
  CHECK(kernel_value(kernel, 0.999) <= kernel_value(kernel, 0));
}

TEST_CASE("kernels fall with the distance, each in its own way", "[photon][kernel]") {
  const double pi = std::numbers::pi;
  CHECK(kernel_value(Kernel::constant, 0.25) == Approx(3 / (4 * pi)));
  CHECK(kernel_value(Kernel::epanechnikov, 0.25) == Approx(15 / (8 * pi) * 0.75));
  CHECK(kernel_value(Kernel::cone, 0.25) == Approx(3 / pi * 0.5));
  CHECK(kernel_value(Kernel::gaussian, 0.25) / kernel_value(Kernel::gaussian, 0) == Approx(std::exp(-0.5)));
}
