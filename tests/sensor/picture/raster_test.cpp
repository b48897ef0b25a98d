// The picture that previews are drawn on.
#include "sensor/picture/raster.h"

#include <catch2/catch.hpp>

using namespace obscura;

namespace {

constexpr Colour kRed{255, 0, 0}, kBlack{0, 0, 0};

int count(const Raster& raster, Colour colour) {
  int result = 0;
  for (int y = 0; y < raster.rows(); ++y) {
    for (int x = 0; x < raster.columns(); ++x) result += raster.at(x, y) == colour;
  }
  return result;
}

}  // namespace

TEST_CASE("what is drawn outside a raster is cut off", "[sensor][raster]") {
  Raster raster(6, 4, kBlack);
  raster.fill(-2, -2, 4, 4, kRed);
  CHECK(count(raster, kRed) == 4);
  CHECK(raster.at(1, 1) == kRed);
  CHECK(raster.at(2, 1) == kBlack);
  raster.paste(Raster(3, 3, kRed), 5, 3);
  CHECK(count(raster, kRed) == 5);
  raster.text(-3, -3, "#", kRed);
  raster.text(100, 100, "#", kRed);
}

TEST_CASE("letters are dots in a box of five by seven", "[sensor][raster]") {
  Raster raster(20, 12, kBlack);
  raster.text(1, 1, "I", kRed);
  CHECK(count(raster, kRed) == 11);  // a bar of seven, two serifs of two
  for (int y = 1; y < 8; ++y) CHECK(raster.at(3, y) == kRed);
  Raster large(20, 20, kBlack);
  large.text(1, 1, "I", kRed, 2);
  CHECK(count(large, kRed) == 44);
  CHECK(Raster::text_width("abc") == 17);
  CHECK(Raster::text_width("") == 0);
  Raster other(20, 12, kBlack);
  other.text(1, 1, "\xc3\xa4", kRed);  // not ASCII: question marks
  CHECK(count(other, kRed) > 0);
}
