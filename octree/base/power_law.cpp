#include "octree/base/power_law.h"

#include <algorithm>
#include <cmath>

namespace obscura {

std::optional<PowerLaw> fit_power_law(std::span<const double> x, std::span<const double> y,
                                      std::span<const double> y_error) {
  constexpr double kLeastError = 0.01;
  const auto each = [&](const auto& visit) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (!(x[i] > 0) || !(y[i] > 0)) continue;
      const double error = std::max(kLeastError, y_error[i] / y[i]);
      visit(std::log(x[i]), std::log(y[i]), 1 / (error * error));
    }
  };
  double weight = 0, mean_x = 0, mean_y = 0;
  PowerLaw law;
  each([&](double u, double v, double w) {
    weight += w;
    mean_x += w * u;
    mean_y += w * v;
    ++law.points;
  });
  if (law.points < 2) return std::nullopt;
  mean_x /= weight;
  mean_y /= weight;
  double xx = 0, xy = 0;
  each([&](double u, double v, double w) {
    xx += w * (u - mean_x) * (u - mean_x);
    xy += w * (u - mean_x) * (v - mean_y);
  });
  if (!(xx > 1e-12 * weight)) return std::nullopt;
  law.exponent = xy / xx;
  law.factor = std::exp(mean_y - law.exponent * mean_x);
  double chi2 = 0;
  each([&](double u, double v, double w) {
    const double off = v - mean_y - law.exponent * (u - mean_x);
    chi2 += w * off * off;
  });
  const double excess = law.points > 2 ? std::max(1.0, chi2 / (law.points - 2)) : 1.0;
  law.exponent_error = std::sqrt(excess / xx);
  return law;
}

}  // namespace obscura
