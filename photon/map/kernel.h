// Smoothing kernels of the density estimate, each normalised to 1 over its ball.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace obscura {

enum class Kernel : std::uint8_t { constant, epanechnikov, cone, gaussian };

namespace detail {

/// exp(-2 u) is a Gaussian of sigma = radius / 2, cut at two sigma.
inline constexpr double kGaussianExponent = 2.0;

/// Kernel up to its norm; u is (distance / radius)^2, below 1.
inline double kernel_shape(Kernel kernel, double u) noexcept {
  switch (kernel) {
    case Kernel::constant:
      return 1;
    case Kernel::epanechnikov:
      return 1 - u;
    case Kernel::cone:
      return 1 - std::sqrt(u);
    case Kernel::gaussian:
      return std::exp(-kGaussianExponent * u);
  }
  return 0;
}

/// 1 / integral of the shape over the unit ball. The Gaussian's integral is
/// 4 pi (sqrt(pi) erf(sqrt a) / (4 a^1.5) - exp(-a) / (2 a)) at a = kGaussianExponent.
constexpr double kernel_norm(Kernel kernel) noexcept {
  constexpr double pi = std::numbers::pi;
  switch (kernel) {
    case Kernel::constant:
      return 3 / (4 * pi);
    case Kernel::epanechnikov:
      return 15 / (8 * pi);
    case Kernel::cone:
      return 3 / pi;
    case Kernel::gaussian:
      return 0.6877784926532102;
  }
  return 0;
}

}  // namespace detail

}  // namespace obscura
