// Tables of pixels: which pixels, and the numbers back again.
#include "sensor/picture/csv_io.h"

#include <catch2/catch.hpp>
#include <clocale>
#include <fstream>
#include <limits>
#include <sstream>

#include "tests/support/scratch_folder.h"

using namespace obscura;
using obscura::test::ScratchFolder;

namespace {

std::vector<std::string> lines_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

std::vector<float> numbers_of(const std::string& line) {
  std::vector<float> numbers;
  std::istringstream stream(line);
  for (std::string number; std::getline(stream, number, ',');) numbers.push_back(std::stof(number));
  return numbers;
}

}  // namespace

TEST_CASE("a region is read row by row", "[sensor][csv_io]") {
  const auto pixels = pixels_in_region(10, 8, {7, 5, 3, 2});
  REQUIRE(pixels.size() == 6);
  CHECK(pixels.front() == PixelPlace{7, 5});
  CHECK(pixels[1] == PixelPlace{8, 5});
  CHECK(pixels.back() == PixelPlace{9, 6});
  CHECK(pixels_in_region(10, 8, {0, 0, 10, 8}).size() == 80);
  for (const std::array<int, 4>& wrong : {std::array<int, 4>{-1, 0, 2, 2},
                                          {8, 0, 3, 1},
                                          {0, 7, 1, 2},
                                          {0, 0, 0, 1},
                                          {10, 0, 1, 1},
                                          {0, 0, 2147483647, 1},
                                          {5, 5, 2147483647, 2147483647}}) {
    CHECK_THROWS_AS(pixels_in_region(10, 8, wrong), InputError);
  }
}

TEST_CASE("a line goes from end to end without a gap, and back the same", "[sensor][csv_io]") {
  CHECK(pixels_on_line(10, 8, {3, 4, 3, 4}) == std::vector<PixelPlace>{{3, 4}});
  CHECK(pixels_on_line(10, 8, {0, 0, 4, 2}) == std::vector<PixelPlace>{{0, 0}, {1, 1}, {2, 1}, {3, 2}, {4, 2}});
  for (const std::array<int, 4>& line : {std::array<int, 4>{9, 7, 0, 0}, {2, 7, 3, 0}, {0, 3, 9, 3}}) {
    const auto pixels = pixels_on_line(10, 8, line);
    CHECK(pixels.front() == PixelPlace{line[0], line[1]});
    CHECK(pixels.back() == PixelPlace{line[2], line[3]});
    for (std::size_t i = 1; i < pixels.size(); ++i) {
      CHECK(std::max(std::abs(pixels[i][0] - pixels[i - 1][0]), std::abs(pixels[i][1] - pixels[i - 1][1])) == 1);
    }
  }
  CHECK_THROWS_AS(pixels_on_line(10, 8, {0, 0, 10, 0}), InputError);
  CHECK_THROWS_AS(pixels_on_line(10, 8, {0, -1, 3, 0}), InputError);
}

TEST_CASE("the numbers of a table are those of the image, to the bit and in any locale", "[sensor][csv_io]") {
  const ScratchFolder folder;
  Image image(3, 2);
  const auto radiance = image.add("lwir.radiance");
  const auto depth = image.add("depth.Z");
  image.add("odd,\"name\"");
  for (std::size_t i = 0; i < 6; ++i) {
    radiance[i] = 0.1f + static_cast<float>(i) / 3;
    depth[i] = i == 4 ? std::numeric_limits<float>::infinity() : 1e30f / static_cast<float>(i + 1);
  }
  std::setlocale(LC_ALL, "de_DE.UTF-8");  // where there is one: it writes 0,1
  write_csv(folder / "a.csv", image, pixels_in_region(3, 2, {1, 0, 2, 2}));
  std::setlocale(LC_ALL, "C");
  const auto lines = lines_of(folder / "a.csv");
  REQUIRE(lines.size() == 5);
  CHECK(lines[0] == "x,y,lwir.radiance,depth.Z,\"odd,\"\"name\"\"\"");
  const std::vector<std::size_t> pixels{1, 2, 4, 5};
  for (std::size_t k = 0; k < pixels.size(); ++k) {
    const auto numbers = numbers_of(lines[k + 1]);
    REQUIRE(numbers.size() == 5);
    CHECK(numbers[0] == static_cast<float>(pixels[k] % 3));
    CHECK(numbers[1] == static_cast<float>(pixels[k] / 3));
    CHECK(numbers[2] == image.channel("lwir.radiance")[pixels[k]]);
    CHECK(numbers[3] == image.channel("depth.Z")[pixels[k]]);
  }
  CHECK(lines[3].find(",inf,") != std::string::npos);
  CHECK(folder.file_count() == 1);
  CHECK_THROWS_AS(write_csv(folder / "absent" / "a.csv", image, {}), ResourceError);
}
