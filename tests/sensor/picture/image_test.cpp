// What the film developed into: names, order, values and metadata of the image.
#include "sensor/picture/image.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace obscura;

namespace {

// Two pixels: one of a 300 K blackbody, one without radiance.
Film two_pixels(const Band& band) {
  Film film({.resolution = {2, 1}, .bands = 2});
  FilmTile tile = film.tile(0);
  PixelSum pixel(2);
  RaySample sample(2);
  sample.bands[0].direct = band.planck(300.0);
  sample.bands[0].transmission = 0.25;
  sample.bands[1].direct = 3;
  sample.bands[1].bias = 0.125;
  sample.depth_m = 12;
  pixel.add(sample);
  tile.put(0, 0, pixel, 4);
  pixel.reset();
  sample.reset();
  sample.bands[0].direct = -1;
  pixel.add(sample);
  tile.put(1, 0, pixel, 0);
  film.put(std::move(tile));
  return film;
}

}  // namespace

TEST_CASE("channels have the names and the order of the interface", "[sensor][image]") {
  const std::vector<Band> bands{Band("lwir", 8, 12, 2), Band("grey")};
  const Film film = two_pixels(bands[0]);
  ImageOrigin origin;
  CHECK(develop(film, bands, origin).channels() ==
        std::vector<std::string>{"lwir.radiance", "lwir.error", "lwir.transmission", "lwir.temperature",
                                 "grey.radiance", "grey.error", "grey.transmission", "depth.Z", "object.id", "rays.N"});
  origin.has_bias = true;
  origin.has_atmosphere = true;
  CHECK(develop(film, bands, origin).channels() ==
        std::vector<std::string>{"lwir.radiance", "lwir.error", "lwir.bias", "lwir.transmission",
                                 "lwir.transmission_atmosphere", "lwir.temperature", "grey.radiance", "grey.error",
                                 "grey.bias", "grey.transmission", "grey.transmission_atmosphere", "depth.Z",
                                 "object.id", "rays.N"});
}

TEST_CASE("values land in their channels", "[sensor][image]") {
  const std::vector<Band> bands{Band("lwir", 8, 12, 2), Band("grey")};
  ImageOrigin origin;
  origin.has_bias = true;
  const Image image = develop(two_pixels(bands[0]), bands, origin);
  const auto value = [&](const char* name, std::size_t pixel) { return image.channel(name)[pixel]; };
  CHECK(value("lwir.radiance", 0) == static_cast<float>(bands[0].planck(300.0)));
  CHECK(value("lwir.temperature", 0) == Approx(300).epsilon(1e-6));
  CHECK(value("lwir.temperature", 1) == 0);  // radiance below 0 has none
  CHECK(value("lwir.transmission", 0) == 0.25f);
  CHECK(value("lwir.transmission", 1) == 1);
  CHECK(value("grey.radiance", 0) == 3);
  CHECK(value("grey.bias", 0) == 0.125f);
  CHECK(value("depth.Z", 0) == 12);
  CHECK(value("depth.Z", 1) == std::numeric_limits<float>::infinity());
  CHECK(value("object.id", 0) == 4);
  CHECK(value("rays.N", 1) == 1);
  CHECK(band_names(image) == std::vector<std::string>{"lwir", "grey"});
  CHECK_THROWS_AS(image.channel("lwir.flux"), InputError);
}

TEST_CASE("bands have the scene's order in a file that sorted them", "[sensor][image]") {
  Image image(1, 1);
  for (const char* name : {"a.radiance", "aa.radiance", "b.radiance", "b.error"}) image.add(name);
  CHECK(band_names(image) == std::vector<std::string>{"a", "aa", "b"});
  image.metadata["obscura:bands"] = std::string("b, aa, a");
  CHECK(band_names(image) == std::vector<std::string>{"b", "aa", "a"});
}

TEST_CASE("the image tells what made it", "[sensor][image]") {
  const std::vector<Band> bands{Band("lwir", 8, 12, 2), Band("grey")};
  ImageOrigin origin;
  origin.seed = 18446744073709551615u;
  origin.scene_hash = "abc";
  origin.camera.fov_deg = 12.5;
  const Image image = develop(two_pixels(bands[0]), bands, origin);
  const auto text = [&](const char* key) { return std::get<std::string>(image.metadata.at(key)); };
  CHECK(std::get<double>(image.metadata.at("obscura:band.lwir.um_min")) == 8);
  CHECK(std::get<double>(image.metadata.at("obscura:band.lwir.um_max")) == 12);
  CHECK(image.metadata.count("obscura:band.grey.um_min") == 0);
  CHECK(text("obscura:seed") == "18446744073709551615");
  CHECK(text("obscura:scene_hash") == "abc");
  CHECK(text("obscura:camera").find("\"fov_deg\": 12.5") != std::string::npos);
  CHECK(!text("obscura:version").empty());
  CHECK(std::get<int>(image.metadata.at("obscura:partial")) == 0);

  const Film undone({.resolution = {2, 1}, .bands = 2});
  CHECK(std::get<int>(develop(undone, bands, origin).metadata.at("obscura:partial")) == 1);
}
