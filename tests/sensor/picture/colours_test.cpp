// Colour maps: right at their known colours, brighter all the way.
#include "sensor/picture/colours.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

using namespace obscura;

namespace {

// CIE lightness L* of an sRGB colour.
double lightness(const Colour& c) {
  const auto linear = [](double v) {
    v /= 255;
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  };
  const double y = 0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2]);
  return y > 0.008856 ? 116 * std::cbrt(y) - 16 : 903.3 * y;
}

}  // namespace

TEST_CASE("the maps begin and end in their colours", "[sensor][colours]") {
  CHECK(colour(ColourMap::inferno, 0) == Colour{0x00, 0x00, 0x04});
  CHECK(colour(ColourMap::inferno, 0.5) == Colour{0xba, 0x36, 0x55});
  CHECK(colour(ColourMap::inferno, 1) == Colour{0xfc, 0xff, 0xa4});
  CHECK(colour(ColourMap::viridis, 0) == Colour{0x44, 0x01, 0x54});
  CHECK(colour(ColourMap::viridis, 1) == Colour{0xfd, 0xe7, 0x25});
  CHECK(colour(ColourMap::grey, 1) == Colour{255, 255, 255});
  CHECK(colour(ColourMap::grey, 0.214041) == Colour{127, 127, 127});  // sRGB's middle
}

TEST_CASE("more is brighter, in even steps", "[sensor][colours]") {
  for (const ColourMap map : {ColourMap::inferno, ColourMap::viridis}) {
    const double dark = lightness(colour(map, 0)), bright = lightness(colour(map, 1));
    for (int i = 0; i < 64; ++i) {
      const double step = lightness(colour(map, (i + 1) / 64.0)) - lightness(colour(map, i / 64.0));
      CHECK(step > 0.2 * (bright - dark) / 64);
      CHECK(step < 2.0 * (bright - dark) / 64);
    }
  }
}

TEST_CASE("places beyond the ends, and none, have the ends' colours", "[sensor][colours]") {
  for (const ColourMap map : {ColourMap::inferno, ColourMap::viridis, ColourMap::grey}) {
    CHECK(colour(map, -3) == colour(map, 0));
    CHECK(colour(map, 7) == colour(map, 1));
    CHECK(colour(map, std::numeric_limits<double>::infinity()) == colour(map, 1));
    CHECK(colour(map, std::numeric_limits<double>::quiet_NaN()) == colour(map, 0));
  }
}

TEST_CASE("the map of differences is palest in its middle and darkens to both ends", "[sensor][colours]") {
  CHECK(colour(ColourMap::balance, 0) == Colour{0x21, 0x66, 0xac});
  CHECK(colour(ColourMap::balance, 0.5) == Colour{0xf7, 0xf7, 0xf7});
  CHECK(colour(ColourMap::balance, 1) == Colour{0xb2, 0x18, 0x2b});
  for (int i = 0; i < 32; ++i) {
    CHECK(lightness(colour(ColourMap::balance, (i + 1) / 64.0)) > lightness(colour(ColourMap::balance, i / 64.0)));
    CHECK(lightness(colour(ColourMap::balance, 1 - (i + 1) / 64.0)) >
          lightness(colour(ColourMap::balance, 1 - i / 64.0)));
  }
}
