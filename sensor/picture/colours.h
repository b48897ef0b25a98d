// Colour maps for previews: evenly perceived steps, dark to bright, told apart by the colour-blind.
#pragma once

#include <array>
#include <cstdint>

namespace obscura {

/// `grey` is what a camera would show: brightness in proportion, encoded for a screen (sRGB).
/// `balance` is for differences: blue below the middle, nearly white there, red above.
enum class ColourMap { inferno, viridis, grey, balance };

using Colour = std::array<std::uint8_t, 3>;

/// @param place 0 (dark) to 1 (bright); beyond, the ends; NaN is dark
Colour colour(ColourMap map, double place) noexcept;

}  // namespace obscura
