#include "sensor/picture/rays_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "octree/base/error.h"
#include "photon/spot/spot.h"
#include "sensor/picture/preview.h"

namespace obscura {
namespace {

// In the order of Criterion. The first eight after `none` are those of Okabe and Ito, "Color universal design" (2008).
constexpr std::array<Colour, kCriteria> kColours = {{{24, 26, 32},
                                                     {230, 159, 0},
                                                     {86, 180, 233},
                                                     {0, 158, 115},
                                                     {240, 228, 66},
                                                     {0, 114, 178},
                                                     {213, 94, 0},
                                                     {204, 121, 167},
                                                     {150, 150, 150},
                                                     {120, 220, 160},
                                                     {190, 110, 255},
                                                     {255, 255, 255}}};
constexpr Colour kInk = {225, 225, 230};
constexpr Colour kPaper = {16, 18, 24};

}  // namespace

Raster rays_picture(const Image& image) {
  if (!image.has("rays.criterion")) {
    throw InputError("image", "has no channel rays.criterion", "render it with adaptive antialiasing (the default)");
  }
  const std::span<const float> criteria = image.channel("rays.criterion");
  std::array<std::size_t, kCriteria> pixels{};
  const auto criterion_of = [](float value) {
    return static_cast<std::size_t>(std::clamp(std::lround(value), 0L, kCriteria - 1L));
  };

  PreviewSettings settings;
  settings.low = 0;
  settings.cut = 0;
  settings.colours = ColourMap::viridis;
  const int magnify = std::clamp(static_cast<int>(std::lround(420.0 / image.columns())), 1, 16);
  settings.magnify = magnify;
  const Raster counts = preview(image, "rays.N", settings);

  const int width = image.columns() * magnify;
  const int dot = width >= 280 ? 2 : 1;
  const int line = 12 * dot, margin = 6 * dot, top = 7 * dot + 2 * margin;
  for (const float value : criteria) ++pixels[criterion_of(value)];
  const auto lines = static_cast<int>(pixels.size()) - static_cast<int>(std::ranges::count(pixels, std::size_t{0}));
  const int legend = Raster::text_width("transmission 99.9 %", dot) + line;
  Raster sheet(counts.columns() + width + legend + 3 * margin, std::max(counts.rows(), top + lines * line), kPaper);
  sheet.paste(counts, 0, 0);
  const int left = counts.columns() + margin;
  sheet.text(left, margin, "rays asked for by", kInk, dot);
  for (int y = 0; y < image.rows(); ++y) {
    for (int x = 0; x < image.columns(); ++x) {
      const float value = criteria[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.columns()) +
                                   static_cast<std::size_t>(x)];
      sheet.fill(left + x * magnify, top + y * magnify, magnify, magnify, kColours[criterion_of(value)]);
    }
  }
  int y = top;
  for (int c = 0; c < kCriteria; ++c) {
    const std::size_t count = pixels[static_cast<std::size_t>(c)];
    if (count == 0) continue;
    const int x = left + width + margin;
    sheet.fill(x, y, 7 * dot, 7 * dot, kColours[static_cast<std::size_t>(c)]);
    const double share = 100.0 * static_cast<double>(count) / static_cast<double>(image.pixel_count());
    sheet.text(x + line, y, fmt::format("{} {:.1f} %", name(static_cast<Criterion>(c)), share), kInk, dot);
    y += line;
  }
  return sheet;
}

}  // namespace obscura
