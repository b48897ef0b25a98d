#include "octree/base/statistics.h"

namespace obscura {
namespace {

/// Regularised incomplete beta function I_x(a, b): continued fraction by Lentz's method (Abramowitz & Stegun
/// 26.5.8; Press et al., Numerical Recipes, 2007, 6.4).
double beta_share(double a, double b, double x) {
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  if (x > (a + 1) / (a + b + 2)) return 1 - beta_share(b, a, 1 - x);
  double c = 1, d = 1 / (1 - (a + b) * x / (a + 1)), fraction = d;
  for (int m = 1; m < 10000; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    d = 1 / (1 + even * d);
    c = 1 + even / c;
    fraction *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    d = 1 / (1 + odd * d);
    c = 1 + odd / c;
    fraction *= d * c;
    if (std::abs(d * c - 1) < 1e-15) break;
  }
  return fraction *
         std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x)) / a;
}

}  // namespace

BatchMean batch_mean(std::span<const double> batches) noexcept {
  if (batches.empty()) return {};
  const double count = static_cast<double>(batches.size());
  const double mean = pairwise_sum(batches) / count;
  if (batches.size() < 2) return {mean, std::numeric_limits<double>::infinity()};
  double squares = 0;
  for (const double x : batches) squares += (x - mean) * (x - mean);
  return {mean, std::sqrt(squares / (count * (count - 1)))};
}

double student_tail(double t, double degrees_of_freedom) {
  if (std::isinf(degrees_of_freedom)) return std::erfc(std::abs(t) / std::sqrt(2.0));
  return beta_share(0.5 * degrees_of_freedom, 0.5, degrees_of_freedom / (degrees_of_freedom + t * t));
}

double student_limit(double probability, double degrees_of_freedom) {
  double low = 0, high = 1;
  while (student_tail(high, degrees_of_freedom) > probability && high < 1e150) high *= 2;
  for (int i = 0; i < 200 && high - low > 1e-12 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (student_tail(middle, degrees_of_freedom) > probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double pairwise_sum(std::span<const double> values) noexcept {
  if (values.size() <= 32) {
    double sum = 0;
    for (const double x : values) sum += x;
    return sum;
  }
  const std::size_t half = values.size() / 2;
  return pairwise_sum(values.first(half)) + pairwise_sum(values.subspan(half));
}

}  // namespace obscura
