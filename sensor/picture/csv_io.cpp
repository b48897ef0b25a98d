#include "sensor/picture/csv_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <ostream>
#include <string>

#include "sensor/picture/whole_file_io.h"

namespace obscura {
namespace {

// A field with a comma or a quotation mark stands in quotation marks (RFC 4180).
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

[[noreturn]] void refuse(const char* what, std::string problem, int columns, int rows) {
  throw InputError(what, std::move(problem), fmt::format("x is from 0 to {}, y from 0 to {}", columns - 1, rows - 1));
}

}  // namespace

std::vector<PixelPlace> pixels_in_region(int columns, int rows, const std::array<int, 4>& r) {
  const auto [x, y, width, height] = r;
  if (width < 1 || height < 1) refuse("region", "it is empty", columns, rows);
  if (x < 0 || y < 0 || x >= columns || y >= rows || width > columns - x || height > rows - y) {
    refuse("region", fmt::format("it leaves the image of {} x {} pixels", columns, rows), columns, rows);
  }
  std::vector<PixelPlace> pixels;
  for (int j = y; j < y + height; ++j) {
    for (int i = x; i < x + width; ++i) pixels.push_back({i, j});
  }
  return pixels;
}

std::vector<PixelPlace> pixels_on_line(int columns, int rows, const std::array<int, 4>& l) {
  for (const int end : {0, 2}) {
    const int x = l[static_cast<std::size_t>(end)], y = l[static_cast<std::size_t>(end) + 1];
    if (x < 0 || y < 0 || x >= columns || y >= rows) {
      refuse("line", fmt::format("({}, {}) is outside the image of {} x {} pixels", x, y, columns, rows), columns,
             rows);
    }
  }
  const int dx = l[2] - l[0], dy = l[3] - l[1];
  const int steps = std::max(std::abs(dx), std::abs(dy));
  std::vector<PixelPlace> pixels = {{l[0], l[1]}};
  for (int k = 1; k <= steps; ++k) {
    const double share = static_cast<double>(k) / steps;
    pixels.push_back(
        {l[0] + static_cast<int>(std::lround(dx * share)), l[1] + static_cast<int>(std::lround(dy * share))});
  }
  return pixels;
}

void write_csv(const std::filesystem::path& path, const Image& image, std::span<const PixelPlace> pixels) {
  std::vector<std::span<const float>> planes;
  for (const std::string& name : image.channels()) planes.push_back(image.channel(name));
  write_whole_stream(path, [&](std::ostream& out) {
    std::string text = "x,y";
    for (const std::string& name : image.channels()) text += ',' + field(name);
    text += '\n';
    for (const auto& [x, y] : pixels) {
      fmt::format_to(std::back_inserter(text), "{},{}", x, y);
      const std::size_t i =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(image.columns()) + static_cast<std::size_t>(x);
      for (const auto plane : planes) fmt::format_to(std::back_inserter(text), ",{:.9g}", plane[i]);
      text += '\n';
      if (text.size() > 1u << 16) {
        out << text;
        text.clear();
      }
    }
    out << text;
  });
}

}  // namespace obscura
