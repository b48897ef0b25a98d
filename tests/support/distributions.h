// Tails and quantiles of the normal, Student's t and chi-square laws, for tests that judge samples.
#pragma once

#include <cmath>
#include <limits>

namespace obscura::test {

namespace detail {

/// Regularised incomplete gamma function Q(a, x), upper tail: series and continued fraction
/// (Abramowitz & Stegun 6.5.29, 6.5.31; Lentz's method).
inline double gamma_tail(double a, double x) {
  if (x <= 0) return 1;
  const double scale = std::exp(a * std::log(x) - x - std::lgamma(a));
  if (x < a + 1) {
    double term = 1 / a, sum = term;
    for (int n = 1; n < 100000 && term > sum * 1e-17; ++n) sum += term *= x / (a + n);
    return 1 - sum * scale;
  }
  double b = x + 1 - a, c = 1e300, d = 1 / b, h = d;
  for (int n = 1; n < 100000; ++n) {
    const double an = -n * (n - a);
    b += 2;
    d = 1 / (an * d + b);
    c = b + an / c;
    h *= d * c;
    if (std::abs(d * c - 1) < 1e-15) break;
  }
  return scale * h;
}

/// Regularised incomplete beta function I_x(a, b) (Abramowitz & Stegun 26.5.8).
inline double beta_share(double a, double b, double x) {
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  if (x > (a + 1) / (a + b + 2)) return 1 - beta_share(b, a, 1 - x);
  const double scale =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x)) / a;
  double c = 1, d = 1 / (1 - (a + b) * x / (a + 1)), h = d;
  for (int m = 1; m < 10000; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    d = 1 / (1 + even * d);
    c = 1 + even / c;
    h *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    d = 1 / (1 + odd * d);
    c = 1 + odd / c;
    h *= d * c;
    if (std::abs(d * c - 1) < 1e-15) break;
  }
  return scale * h;
}

}  // namespace detail

/// Probability of a chi-square variable above `statistic`.
inline double chi_square_tail(double statistic, double degrees_of_freedom) {
  return detail::gamma_tail(0.5 * degrees_of_freedom, 0.5 * statistic);
}

/// Probability of |t| above the given value; infinite degrees of freedom: the normal law.
inline double student_two_sided_tail(double t, double degrees_of_freedom) {
  if (std::isinf(degrees_of_freedom)) return std::erfc(std::abs(t) / std::sqrt(2.0));
  return detail::beta_share(0.5 * degrees_of_freedom, 0.5, degrees_of_freedom / (degrees_of_freedom + t * t));
}

/// The |t| that is exceeded with the given probability.
inline double student_limit(double probability, double degrees_of_freedom = std::numeric_limits<double>::infinity()) {
  double low = 0, high = 1;
  while (student_two_sided_tail(high, degrees_of_freedom) > probability) high *= 2;
  for (int i = 0; i < 200 && high - low > 1e-12 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (student_two_sided_tail(middle, degrees_of_freedom) > probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace obscura::test
