// A power law through measured points: how an error falls with work.
#pragma once

#include <optional>
#include <span>

namespace obscura {

/// y = factor x^exponent.
struct PowerLaw {
  double exponent = 0;
  double exponent_error = 0;  ///< standard error
  double factor = 1;
  int points = 0;  ///< that it was fitted to
};

/// Least squares of logarithms, weighted by the relative errors of y (at least 1 %); the standard error is that of the
/// errors, or of the scatter about the line where that is larger. Points that are not positive are left out.
/// @param y_error standard errors of y, as many; 0: 1 %
/// @returns nothing for fewer than two different x
std::optional<PowerLaw> fit_power_law(std::span<const double> x, std::span<const double> y,
                                      std::span<const double> y_error);

}  // namespace obscura
