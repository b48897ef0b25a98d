// Power laws in measured errors: the exponent and how well it is known.
#pragma once

#include <cmath>
#include <vector>

namespace obscura::test {

/// An error that was measured at a setting, with the standard error of its logarithm.
struct ErrorAt {
  double setting = 0;
  double error = 0;
  double doubt = 0;
};

struct Slope {
  double value = 0;
  double standard_error = 0;
};

/// Of log error in log setting, by weighted least squares. Where no doubts are given, from the scatter about the line.
inline Slope slope_of(const std::vector<ErrorAt>& measured) {
  double weights = 0, x = 0, y = 0;
  const auto weight = [](const ErrorAt& m) { return m.doubt > 0 ? 1 / (m.doubt * m.doubt) : 1.0; };
  for (const ErrorAt& m : measured) {
    weights += weight(m);
    x += weight(m) * std::log(m.setting);
    y += weight(m) * std::log(std::abs(m.error));
  }
  x /= weights;
  y /= weights;
  double xx = 0, xy = 0;
  for (const ErrorAt& m : measured) {
    const double dx = std::log(m.setting) - x;
    xx += weight(m) * dx * dx;
    xy += weight(m) * dx * (std::log(std::abs(m.error)) - y);
  }
  Slope slope{xy / xx, 1 / std::sqrt(xx)};
  if (measured.front().doubt > 0) return slope;
  double scatter = 0;
  for (const ErrorAt& m : measured) {
    const double off = std::log(std::abs(m.error)) - y - slope.value * (std::log(m.setting) - x);
    scatter += off * off;
  }
  slope.standard_error *= std::sqrt(scatter / std::max(1.0, static_cast<double>(measured.size()) - 2));
  return slope;
}

/// Whether the slope is the wanted one but for `most`, and known well enough to say so.
inline bool is_slope(const Slope& slope, double wanted, double most) {
  return std::abs(slope.value - wanted) < most && 3 * slope.standard_error < most;
}

}  // namespace obscura::test
