// Previews show the values that they are given: colours by place in the range, nothing where undone.
#include "sensor/picture/preview.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "sensor/picture/image_io.h"
#include "tests/support/scratch_folder.h"

using namespace obscura;

namespace {

// 20 x 10 pixels: temperature 300 to 319 by column, one undone pixel, depth infinite on the right.
Image example() {
  Image image(20, 10);
  const auto radiance = image.add("lwir.radiance"), error = image.add("lwir.error"),
             transmission = image.add("lwir.transmission"), kelvin = image.add("lwir.temperature"),
             depth = image.add("depth.Z"), rays = image.add("rays.N");
  for (std::size_t i = 0; i < 200; ++i) {
    const auto x = static_cast<float>(i % 20);
    radiance[i] = 10 + x;
    error[i] = 0.01f * radiance[i];
    transmission[i] = x / 19;
    kelvin[i] = 300 + x;
    depth[i] = x < 15 ? 100 + x : INFINITY;
    rays[i] = i == 25 ? 0.0f : 16.0f;
  }
  image.metadata["obscura:band.lwir.um_max"] = 12.0;
  return image;
}

PreviewSettings bare() {
  PreviewSettings settings;
  settings.legend = false;
  settings.magnify = 1;
  return settings;
}

}  // namespace

TEST_CASE("a preview's colours follow the values over their range", "[sensor][preview]") {
  const Raster picture = preview(example(), "lwir.temperature", bare());
  REQUIRE(picture.columns() == 20);
  REQUIRE(picture.rows() == 10);
  for (int x = 0; x < 20; ++x) {
    CHECK(picture.at(x, 4) == colour(ColourMap::inferno, x / 19.0));
  }
  PreviewSettings settings = bare();
  settings.low = 310;
  settings.high = 314;
  const Raster narrow = preview(example(), "lwir.temperature", settings);
  CHECK(narrow.at(3, 4) == colour(ColourMap::inferno, 0));
  CHECK(narrow.at(12, 4) == colour(ColourMap::inferno, 0.5));
  CHECK(narrow.at(19, 4) == colour(ColourMap::inferno, 1));
}

TEST_CASE("pixels never done and infinite depths have no colour of the map", "[sensor][preview]") {
  const Raster kelvin = preview(example(), "lwir.temperature", bare());
  const Raster depth = preview(example(), "depth.Z", bare());
  const Colour nothing = kelvin.at(5, 1);
  CHECK(nothing != kelvin.at(5, 2));
  CHECK(depth.at(17, 3) == nothing);
  CHECK(depth.at(3, 3) != nothing);
}

TEST_CASE("thermal bands glow, others look like photographs", "[sensor][preview]") {
  Image image = example();
  CHECK(preview(image, "lwir.radiance", bare()).at(19, 3) == colour(ColourMap::inferno, 1));
  image.metadata["obscura:band.lwir.um_max"] = 0.7;
  CHECK(preview(image, "lwir.radiance", bare()).at(19, 3) == colour(ColourMap::grey, 1));
  CHECK(preview(image, "lwir.transmission", bare()).at(19, 3) == Colour{255, 255, 255});
}

TEST_CASE("outliers do not darken the picture", "[sensor][preview]") {
  Image image(100, 100);
  const auto values = image.add("lwir.radiance");
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i % 100);
  values[777] = 1e9f;
  CHECK(preview(image, "lwir.radiance", bare()).at(99, 50)[0] > 240);
}

TEST_CASE("a flat picture, a picture of nothing and a single pixel are drawn", "[sensor][preview]") {
  for (const float value : {0.0f, 5.0f, -1e-30f, 3e38f, INFINITY}) {
    Image image(3, 2);
    for (float& v : image.add("lwir.radiance")) v = value;
    for (float& v : image.add("lwir.error")) v = value;
    CHECK(preview(image, "lwir.radiance").columns() > 3);
    CHECK(preview_sheet(image, "lwir").columns() > 6);
  }
  Image pixel(1, 1);
  pixel.add("grey.radiance")[0] = 1;
  CHECK(preview(pixel, "grey.radiance").rows() > 1);
}

TEST_CASE("the legend adds to the picture and leaves it whole", "[sensor][preview]") {
  PreviewSettings settings = bare();
  const Raster plain = preview(example(), "lwir.temperature", settings);
  settings.legend = true;
  const Raster framed = preview(example(), "lwir.temperature", settings);
  REQUIRE(framed.columns() > plain.columns());
  REQUIRE(framed.rows() > plain.rows());
  int found = 0;  // the picture is in it, at one place
  for (int dy = 0; dy + plain.rows() <= framed.rows(); ++dy) {
    for (int dx = 0; dx + plain.columns() <= framed.columns(); ++dx) {
      bool same = true;
      for (int y = 0; same && y < plain.rows(); ++y) {
        for (int x = 0; same && x < plain.columns(); ++x) {
          same = framed.at(x + dx, y + dy) == plain.at(x, y);
        }
      }
      found += same;
    }
  }
  CHECK(found == 1);
}

TEST_CASE("marks are outlined on the side of the smaller one and cover nothing of their own", "[sensor][preview]") {
  PreviewSettings settings = bare();
  settings.magnify = 4;
  const Raster plain = preview(example(), "lwir.temperature", settings);
  settings.marks.assign(200, 0);
  settings.marks[5 * 20 + 6] = 1;
  settings.marks[5 * 20 + 7] = 2;
  const Raster marked = preview(example(), "lwir.temperature", settings);
  const auto differs = [&](int x, int y) { return marked.at(x, y) != plain.at(x, y); };
  int changed = 0;
  for (int y = 0; y < marked.rows(); ++y) {
    for (int x = 0; x < marked.columns(); ++x) changed += differs(x, y) ? 1 : 0;
  }
  // Six outer sides and the one between the two, four screen pixels each.
  CHECK(changed == 7 * 4);
  CHECK(differs(6 * 4 - 1, 5 * 4));
  CHECK(differs(7 * 4 - 1, 5 * 4));
  CHECK_FALSE(differs(7 * 4, 5 * 4));
  CHECK(marked.at(7 * 4 - 1, 5 * 4) == marked.at(8 * 4, 5 * 4));
  CHECK(marked.at(6 * 4 - 1, 5 * 4) != marked.at(8 * 4, 5 * 4));
}

TEST_CASE("a channel that is not there is bad input", "[sensor][preview]") {
  CHECK_THROWS_AS(preview(example(), "mwir.radiance"), InputError);
  CHECK_THROWS_AS(preview_sheet(example(), "mwir"), InputError);
}

TEST_CASE("previews are written as PNG", "[sensor][preview]") {
  const obscura::test::ScratchFolder folder;
  const auto path = folder / "sheet.png";
  write_preview_sheet(path, example(), "lwir");
  const Raster sheet = preview_sheet(example(), "lwir");
  const Image back = read_image(path);
  CHECK(back.columns() == sheet.columns());
  CHECK(back.rows() == sheet.rows());
  write_preview(path, example(), "lwir.radiance", bare());
  CHECK(read_image(path).columns() == 20);
}
