#include "sensor/picture/colours.h"

#include <algorithm>
#include <cmath>

namespace obscura {
namespace {

// Nine of the 256 colours of each map, by S. van der Walt and N. Smith (matplotlib, CC0 1.0).
constexpr std::array<std::uint32_t, 9> kInferno{0x000004, 0x1f0c48, 0x550f6d, 0x88226a, 0xba3655,
                                                0xe35933, 0xf98c0a, 0xf9c932, 0xfcffa4};
constexpr std::array<std::uint32_t, 9> kViridis{0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c,
                                                0x28ae80, 0x5ec962, 0xaddc30, 0xfde725};

// Nine classes of RdBu, reversed, by C. Brewer (colorbrewer2.org, Apache 2.0).
constexpr std::array<std::uint32_t, 9> kBalance{0x2166ac, 0x4393c3, 0x92c5de, 0xd1e5f0, 0xf7f7f7,
                                                0xfddbc7, 0xf4a582, 0xd6604d, 0xb2182b};

std::uint8_t to_byte(double value) noexcept {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

// A smooth curve through the nine (Catmull and Rom, 1974); the ends go on in a straight line.
Colour along(const std::array<std::uint32_t, 9>& stops, double place) noexcept {
  const double x = place * 8;
  const int i = std::min(7, static_cast<int>(x));
  const double t = x - i;
  Colour result;
  for (int c = 0; c < 3; ++c) {
    const auto stop = [&](int k) {
      return static_cast<double>(stops[static_cast<std::size_t>(k)] >> (16 - 8 * c) & 0xff);
    };
    const double b = stop(i), d = stop(i + 1);
    const double a = i > 0 ? stop(i - 1) : 2 * b - d;
    const double e = i < 7 ? stop(i + 2) : 2 * d - b;
    result[static_cast<std::size_t>(c)] =
        to_byte(b + 0.5 * t * (d - a + t * (2 * a - 5 * b + 4 * d - e + t * (3 * (b - d) + e - a))));
  }
  return result;
}

// Encoding of IEC 61966-2-1.
std::uint8_t encode_srgb(double linear) noexcept {
  return to_byte(255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055));
}

}  // namespace

Colour colour(ColourMap map, double place) noexcept {
  place = place > 0 ? std::min(place, 1.0) : 0.0;
  if (map == ColourMap::grey) {
    const std::uint8_t value = encode_srgb(place);
    return {value, value, value};
  }
  if (map == ColourMap::balance) return along(kBalance, place);
  return along(map == ColourMap::inferno ? kInferno : kViridis, place);
}

}  // namespace obscura
