// Files: what is written is read again to the bit, failures are named and leave nothing behind.
#include "sensor/picture/image_io.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <thread>

#include "tests/support/scratch_folder.h"

using namespace obscura;
using obscura::test::ScratchFolder;
namespace fs = std::filesystem;

namespace {

Image example() {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  Image image(5, 130);  // more rows than are written in one go
  int channel = 0;
  for (const char* name : {"z.radiance", "z.error", "a.radiance", "a.transmission_atmosphere", "depth.Z", "object.id",
                           "rays.N", "lwir.temperature"}) {
    float value = 0.1f + static_cast<float>(++channel);
    for (float& v : image.add(name)) v = value = value * 1.01f;
  }
  Image result(5, 130);
  for (const std::string& name : image.channels()) {
    const auto to = result.add(name);
    std::ranges::copy(image.channel(name), to.begin());
    if (name == "depth.Z") to[7] = to[649] = infinity;
    if (name == "z.radiance") {
      to[0] = std::numeric_limits<float>::denorm_min();
      to[1] = std::numeric_limits<float>::max();
      to[2] = -0.0f;
    }
  }
  result.metadata["obscura:seed"] = std::string("18446744073709551615");
  result.metadata["obscura:partial"] = 1;
  result.metadata["obscura:band.lwir.um_min"] = 8.1;
  result.metadata["obscura:camera"] = std::string(R"({"position_m": [0, 1e+07, 0.1]})");
  return result;
}

bool same_bits(std::span<const float> a, std::span<const float> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

void spoil(const fs::path& path, std::uintmax_t size) { fs::resize_file(path, size); }

}  // namespace

TEST_CASE("an image comes back from its file to the bit", "[sensor][image_io]") {
  const ScratchFolder folder;
  const Image image = example();
  write_image(folder / "a.exr", image);
  CHECK(folder.file_count() == 1);  // no temporary file stays
  const Image back = read_image(folder / "a.exr");
  CHECK(back.columns() == 5);
  CHECK(back.rows() == 130);
  REQUIRE(back.channels().size() == image.channels().size());
  for (const std::string& name : image.channels()) {
    INFO(name);
    REQUIRE(back.has(name));
    CHECK(same_bits(back.channel(name), image.channel(name)));
  }
  // A twin: one changed bit is seen.
  Image other(5, 130);
  const auto changed = other.add("depth.Z");
  std::ranges::copy(image.channel("depth.Z"), changed.begin());
  changed[3] = std::nextafter(changed[3], 1e9f);
  CHECK(!same_bits(back.channel("depth.Z"), other.channel("depth.Z")));
}

TEST_CASE("the same image makes the same bytes at any time", "[sensor][image_io]") {
  const ScratchFolder folder;
  write_image(folder / "a.exr", example());
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  write_image(folder / "b.exr", example());
  const auto bytes = [&](const char* name) {
    std::ifstream file(folder / name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  CHECK(bytes("a.exr") == bytes("b.exr"));
  CHECK(bytes("a.exr").size() > 5 * 130 * 4);
}

TEST_CASE("the metadata comes back with the file", "[sensor][image_io]") {
  const ScratchFolder folder;
  write_image(folder / "a.exr", example());
  const Metadata metadata = read_image(folder / "a.exr").metadata;
  for (const auto& [key, value] : example().metadata) {
    INFO(key);
    REQUIRE(metadata.count(key) == 1);
    CHECK(metadata.at(key) == value);
  }
}

TEST_CASE("a file that is no image is bad input, by name", "[sensor][image_io]") {
  const ScratchFolder folder;
  const auto message = [&](const fs::path& path) -> std::string {
    try {
      read_image(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  CHECK(message(folder / "missing.exr").find("missing.exr: no such image") != std::string::npos);
  std::ofstream(folder / "text.exr") << "this is a letter";
  CHECK(message(folder / "text.exr").find("is not an image") != std::string::npos);
  std::ofstream(folder / "empty.exr");
  CHECK(message(folder / "empty.exr").find("is not an image") != std::string::npos);
  CHECK(message(folder.path()).find("no such image") != std::string::npos);

  write_image(folder / "cut.exr", example());
  const auto size = fs::file_size(folder / "cut.exr");
  for (const auto share : {size / 2, size - 20}) {
    spoil(folder / "cut.exr", share);
    CHECK(message(folder / "cut.exr").find("cut.exr") != std::string::npos);
  }
}

TEST_CASE("what cannot be written is a failure of the world and loses nothing", "[sensor][image_io]") {
  const ScratchFolder folder;
  CHECK_THROWS_AS(write_image(folder / "no such folder" / "a.exr", example()), ResourceError);
  fs::create_directories(folder / "taken.exr" / "inside");
  CHECK_THROWS_AS(write_image(folder / "taken.exr", example()), ResourceError);
  CHECK(folder.file_count() == 1);

  // A disk that fills up leaves the old image whole.
  std::ofstream(folder / "old.exr") << "old";
  if (fs::exists("/dev/full")) {
    CHECK_THROWS_AS(write_image("/dev/full/a.exr", example()), ResourceError);
  }
  CHECK(fs::file_size(folder / "old.exr") == 3);
  write_image(folder / "old.exr", example());
  CHECK(read_image(folder / "old.exr").columns() == 5);
}

TEST_CASE("a PNG holds the raster", "[sensor][image_io]") {
  const ScratchFolder folder;
  Raster raster(3, 70);
  for (int i = 0; i < 210; ++i) {
    const auto shade = [i](int k) { return static_cast<std::uint8_t>(i * k); };
    raster.set(i % 3, i / 3, {shade(7), shade(11), shade(13)});
  }
  write_png(folder / "a.png", raster);
  const Image back = read_image(folder / "a.png");
  REQUIRE(back.columns() == 3);
  REQUIRE(back.rows() == 70);
  const char* names[] = {"R", "G", "B"};
  int wrong = 0;
  for (std::size_t i = 0; i < 210; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      wrong += std::lround(back.channel(names[c])[i] * 255) != raster.rgb()[3 * i + c];
    }
  }
  CHECK(wrong == 0);
  // In memory it is the same file.
  std::ifstream stream(folder / "a.png", std::ios::binary);
  const std::vector<std::uint8_t> file{std::istreambuf_iterator<char>(stream), {}};
  CHECK(png_bytes(raster) == file);
}
