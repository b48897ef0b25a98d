// What an error of an image is relative to.
#pragma once

#include <algorithm>
#include <cmath>

namespace obscura {

/// Pixels darker than this share of the brightest count as if they were as bright.
inline constexpr double kDarkShare = 0.05;

/// The image error is the root mean square over pixels of (L - L_true) / error_scale(L_true, largest |L_true|).
inline double error_scale(double value, double largest) noexcept {
  return std::max(std::abs(value), kDarkShare * std::abs(largest));
}

}  // namespace obscura
