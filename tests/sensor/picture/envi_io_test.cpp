// ENVI files, read as the format's description has it.
#include "sensor/picture/envi_io.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>

#include "tests/support/scratch_folder.h"

using namespace obscura;
using obscura::test::ScratchFolder;

namespace {

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

using Header = std::map<std::string, std::string>;

Header read_header(const std::filesystem::path& path) {
  Header header;
  std::istringstream lines(text_of(path));
  std::string line;
  REQUIRE(std::getline(lines, line));
  REQUIRE(line == "ENVI");
  while (std::getline(lines, line)) {
    const auto equals = line.find(" = ");
    REQUIRE(equals != std::string::npos);
    header[line.substr(0, equals)] = line.substr(equals + 3);
  }
  return header;
}

// Byte by byte, whatever machine this is.
float value_at(const std::string& bytes, std::size_t index) {
  std::uint32_t bits = 0;
  for (std::size_t k = 0; k < 4; ++k)
    bits |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes.at(4 * index + k))) << 8 * k;
  float value = 0;
  std::memcpy(&value, &bits, 4);
  return value;
}

Image example() {
  Image image(5, 3);
  float value = -1.25f;
  for (const char* name : {"lwir.radiance", "mwir.radiance", "lwir.temperature", "mwir.temperature"}) {
    for (float& v : image.add(name)) v = value += 0.7f;
  }
  std::ranges::fill(image.add("rays.N"), 4.0f);
  image.metadata["obscura:band.lwir.um_min"] = 8.0;
  image.metadata["obscura:band.lwir.um_max"] = 12.5;
  image.metadata["obscura:band.mwir.um_min"] = 3.0;
  image.metadata["obscura:band.mwir.um_max"] = 5.0;
  image.metadata["obscura:scene"] = std::string("a {scene}, at night");
  return image;
}

}  // namespace

TEST_CASE("an ENVI header says where each number of its data is", "[sensor][envi_io]") {
  const ScratchFolder folder;
  const Image image = example();
  write_envi(folder / "a.hdr", image);
  CHECK(folder.file_count() == 2);
  Header header = read_header(folder / "a.hdr");
  CHECK(header["samples"] == "5");
  CHECK(header["lines"] == "3");
  CHECK(header["bands"] == "2");
  CHECK(header["header offset"] == "0");
  CHECK(header["data type"] == "4");
  CHECK(header["interleave"] == "bsq");
  CHECK(header["byte order"] == "0");
  CHECK(header["file type"] == "ENVI Standard");
  CHECK(header["band names"] == "{lwir.radiance, mwir.radiance}");
  CHECK(header["wavelength units"] == "Micrometers");
  CHECK(header["wavelength"] == "{10.25, 4}");
  CHECK(header["fwhm"] == "{4.5, 2}");
  CHECK(header["description"] == "{Obscura, radiance: a _scene__ at night}");
  CHECK(header["data ignore value"] == "-9999");
  const std::string bytes = text_of(folder / "a.img");
  REQUIRE(bytes.size() == 4 * 5 * 3 * 2);
  int wrong = 0;
  for (std::size_t i = 0; i < 15; ++i) {
    wrong += value_at(bytes, i) != image.channel("lwir.radiance")[i];
    wrong += value_at(bytes, 15 + i) != image.channel("mwir.radiance")[i];
  }
  CHECK(wrong == 0);

  write_envi(folder / "a.hdr", image, "temperature");  // replaced, both files
  CHECK(read_header(folder / "a.hdr")["band names"] == "{lwir.temperature, mwir.temperature}");
  CHECK(value_at(text_of(folder / "a.img"), 16) == image.channel("mwir.temperature")[1]);
  CHECK(folder.file_count() == 2);
}

TEST_CASE("pixels that are not there are told apart from dark ones", "[sensor][envi_io]") {
  const ScratchFolder folder;
  Image image(4, 1);
  std::ranges::copy(std::vector<float>{0, 0, 1, std::numeric_limits<float>::infinity()},
                    image.add("g.radiance").begin());
  std::ranges::copy(std::vector<float>{1, 0, 1, 1}, image.add("rays.N").begin());
  write_envi(folder / "a.hdr", image);
  const std::string bytes = text_of(folder / "a.img");
  CHECK(value_at(bytes, 0) == 0);
  CHECK(value_at(bytes, 1) == kEnviIgnore);
  CHECK(value_at(bytes, 2) == 1);
  CHECK(value_at(bytes, 3) == kEnviIgnore);
  CHECK(read_header(folder / "a.hdr").count("wavelength") == 0);  // a grey band has none
}

TEST_CASE("an image without the bands asked for leaves no file", "[sensor][envi_io]") {
  const ScratchFolder folder;
  CHECK_THROWS_AS(write_envi(folder / "a.hdr", example(), "counts"), InputError);
  Image empty(2, 2);
  empty.add("depth.Z");
  CHECK_THROWS_AS(write_envi(folder / "a.hdr", empty), InputError);
  CHECK_THROWS_AS(write_envi(folder / "absent" / "a.hdr", example()), ResourceError);
  CHECK(folder.file_count() == 0);
}

TEST_CASE("numpy reads the data where the header says", "[sensor][envi_io]") {
  if (std::system("/usr/bin/python3 -c 'import numpy' >/dev/null 2>&1") != 0) {
    WARN("SKIPPED: there is no numpy");
    return;
  }
  const ScratchFolder folder;
  const Image image = example();
  write_envi(folder / "a.hdr", image);
  folder.write("read.py",
               "import re, sys, numpy\n"
               "text = open('a.hdr').read()\n"
               "h = dict(re.findall(r'^([a-z ]+?) = (.*)$', text, re.M))\n"
               "shape = [int(h[k]) for k in ('bands', 'lines', 'samples')]\n"
               "data = numpy.fromfile('a.img', '<f4').reshape(shape)\n"
               "print('%.9g' % data[1, 2, 3])\n");
  REQUIRE(std::system(("cd '" + folder.path().string() + "' && /usr/bin/python3 read.py > out").c_str()) == 0);
  CHECK(std::stof(text_of(folder / "out")) == image.channel("mwir.radiance")[2 * 5 + 3]);
}
