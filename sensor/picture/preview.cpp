#include "sensor/picture/preview.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sensor/picture/image_io.h"

namespace obscura {
namespace {

constexpr Colour kPaper{18, 19, 24}, kInk{222, 222, 226}, kFaint{120, 122, 132}, kNothing{38, 42, 54};
constexpr Colour kOuterLine{70, 150, 255}, kInnerLine{64, 230, 120};

// One panel's worth: values, what they are called, how they are shown.
struct Panel {
  std::string title;
  std::string unit;
  std::vector<float> values;  // NaN: nothing to show
  ColourMap colours = ColourMap::inferno;
  double low = 0, high = 1;
};

// Sensible without wavelength and below 2.5 um, where no ordinary thing glows.
bool looks_like_a_photograph(const Image& image, const std::string& band) {
  const auto found = image.metadata.find("obscura:band." + band + ".um_max");
  return found == image.metadata.end() || std::get<double>(found->second) < 2.5;
}

std::pair<std::string, std::string> split_name(const std::string& channel) {
  const std::size_t dot = channel.rfind('.');
  return dot == std::string::npos ? std::pair{std::string(), channel}
                                  : std::pair{channel.substr(0, dot), channel.substr(dot + 1)};
}

// The value below which the given share of the finite values lies; 0 where there are none.
double percentile(std::vector<float>& values, double share) {
  if (values.empty()) return 0;
  const auto rank =
      static_cast<std::ptrdiff_t>(std::lround(std::clamp(share, 0.0, 1.0) * static_cast<double>(values.size() - 1)));
  std::ranges::nth_element(values, values.begin() + rank);
  return values[static_cast<std::size_t>(rank)];
}

void set_range(Panel& panel, const PreviewSettings& settings) {
  std::vector<float> finite;
  std::ranges::copy_if(panel.values, std::back_inserter(finite), [](float v) { return std::isfinite(v); });
  panel.low = settings.low ? *settings.low : percentile(finite, settings.cut);
  panel.high = settings.high ? *settings.high : percentile(finite, 1 - settings.cut);
  // A flat picture is shown in the middle of its scale.
  if (const double width = panel.high - panel.low;
      !(width > 1e-6 * std::max(std::abs(panel.high), std::abs(panel.low)))) {
    const double margin = panel.high != 0 ? 0.01 * std::abs(panel.high) : 1;
    if (!settings.low) panel.low -= margin;
    if (!settings.high || panel.high <= panel.low) panel.high += margin;
  }
}

void hide_undone(const Image& image, std::vector<float>& values) {
  if (!image.has("rays.N")) return;
  const std::span<const float> rays = image.channel("rays.N");
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(rays[i] > 0)) values[i] = NAN;
  }
}

Panel channel_panel(const Image& image, const std::string& channel, PreviewSettings settings) {
  const auto [band, quantity] = split_name(channel);
  const bool grey_band = image.metadata.count("obscura:band." + band + ".um_max") == 0;
  Panel panel;
  const std::span<const float> values = image.channel(channel);
  panel.values.assign(values.begin(), values.end());
  hide_undone(image, panel.values);

  if (quantity == "temperature") {
    panel.title = band + " apparent temperature";
    panel.unit = "K";
    for (float& value : panel.values) {
      if (value == 0) value = NAN;  // no radiance, no temperature
    }
  } else if (quantity == "radiance" || quantity == "error" || quantity == "bias") {
    panel.title = band + (quantity == "error" ? " standard error" : " " + quantity);
    panel.unit = grey_band ? "" : "W/m2/sr";
  } else if (quantity.starts_with("transmission")) {
    panel.title = band + (quantity == "transmission" ? " transmission" : " transmission of the air");
    if (!settings.high) settings.high = 1;
    set_range(panel, settings);
    // From 0 on, unless the cloud is thin: the contrast of smoke is not the range of its noise.
    if (!settings.low) settings.low = panel.low > 0.5 && panel.low < 0.999 ? panel.low : 0;
  } else if (channel == "depth.Z") {
    panel.title = "depth";
    panel.unit = "m";
  } else {
    panel.title = channel;
  }

  if (settings.colours) {
    panel.colours = *settings.colours;
  } else if (quantity == "transmission" || quantity == "transmission_atmosphere") {
    panel.colours = ColourMap::grey;
  } else if (quantity == "radiance" && looks_like_a_photograph(image, band)) {
    panel.colours = ColourMap::grey;
    if (!settings.low) settings.low = 0;  // black is no light
  } else if (quantity != "radiance" && quantity != "temperature") {
    panel.colours = ColourMap::viridis;
  }
  set_range(panel, settings);
  return panel;
}

Panel relative_error_panel(const Image& image, const std::string& band) {
  const std::span<const float> radiance = image.channel(band + ".radiance");
  const std::span<const float> error = image.channel(band + ".error");
  Panel panel;
  panel.title = band + " relative error";
  panel.unit = "%";
  panel.colours = ColourMap::viridis;
  panel.values.resize(image.pixel_count());
  for (std::size_t i = 0; i < panel.values.size(); ++i) {
    panel.values[i] = radiance[i] != 0 ? 100 * error[i] / std::abs(radiance[i]) : NAN;
  }
  hide_undone(image, panel.values);
  PreviewSettings settings;
  settings.low = 0;
  set_range(panel, settings);
  return panel;
}

// Round numbers 1, 2, 5 x 10^n between the ends, `count` at most.
std::vector<double> ticks(double low, double high, int count) {
  const double rough = (high - low) / count;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough) {
      step = factor * power;
      break;
    }
  }
  std::vector<double> result;
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) {
    result.push_back(k == 0 ? 0 : k * step);
  }
  return result;
}

// Lines between pixels of different marks.
void draw_marks(const Image& image, const std::vector<std::uint8_t>& marks, int magnify, Raster& picture) {
  const auto at = [&](int x, int y) {
    return marks[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.columns()) + static_cast<std::size_t>(x)];
  };
  const int width = std::max(1, magnify / 4);
  for (int y = 0; y < image.rows(); ++y) {
    for (int x = 0; x < image.columns(); ++x) {
      for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
        const int nx = x + dx, ny = y + dy;
        if (nx < 0 || ny < 0 || nx >= image.columns() || ny >= image.rows() || at(nx, ny) <= at(x, y)) continue;
        const int left = x * magnify + (dx > 0 ? magnify - width : 0),
                  top = y * magnify + (dy > 0 ? magnify - width : 0);
        picture.fill(left, top, dx ? width : magnify, dy ? width : magnify, at(nx, ny) > 1 ? kInnerLine : kOuterLine);
      }
    }
  }
}

Raster draw(const Image& image, const Panel& panel, bool legend, int magnify,
            const std::vector<std::uint8_t>& outlines = {}) {
  const int width = image.columns() * magnify, height = image.rows() * magnify;
  Raster picture(width, height, kNothing);
  const double scale = 1 / (panel.high - panel.low);
  for (int y = 0; y < image.rows(); ++y) {
    for (int x = 0; x < image.columns(); ++x) {
      const float value = panel.values[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.columns()) +
                                       static_cast<std::size_t>(x)];
      if (!std::isfinite(value)) continue;
      picture.fill(x * magnify, y * magnify, magnify, magnify, colour(panel.colours, (value - panel.low) * scale));
    }
  }
  if (!outlines.empty()) draw_marks(image, outlines, magnify, picture);
  if (!legend) return picture;

  // Title above, scale to the right: a bar with ticks, its unit on top.
  const int dot = width >= 280 ? 2 : 1;
  const int letter = 7 * dot, margin = 6 * dot, bar = 8 * dot;
  const std::vector<double> marks = ticks(panel.low, panel.high, std::max(2, height / (3 * letter)));
  std::vector<std::string> labels;
  int label_width = 0;
  for (const double mark : marks) {
    labels.push_back(fmt::format("{:.6g}", mark));
    label_width = std::max(label_width, Raster::text_width(labels.back(), dot));
  }
  const int top = letter + 2 * margin, left = margin;
  const int bar_x = left + width + margin, label_x = bar_x + bar + 4 * dot;
  Raster sheet(label_x + label_width + margin, top + height + margin, kPaper);
  std::string title = panel.title;
  if (!panel.unit.empty()) title += " [" + panel.unit + "]";
  sheet.text(left, margin, title, kInk, dot);
  sheet.paste(picture, left, top);
  for (int y = 0; y < height; ++y) {
    sheet.fill(bar_x, top + y, bar, 1, colour(panel.colours, 1 - (y + 0.5) / height));
  }
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const int y = top + static_cast<int>(std::lround((1 - (marks[i] - panel.low) * scale) * (height - 1)));
    sheet.fill(bar_x + bar, y, 2 * dot, 1, kFaint);
    sheet.text(label_x, std::clamp(y - letter / 2, top, top + height - letter), labels[i], kInk, dot);
  }
  return sheet;
}

// Small images are enlarged towards the given width.
int magnification(const Image& image, int width) {
  return std::clamp(static_cast<int>(std::lround(static_cast<double>(width) / image.columns())), 1, 16);
}

}  // namespace

Raster preview(const Image& image, const std::string& channel, const PreviewSettings& settings) {
  const int magnify = settings.magnify > 0 ? settings.magnify : magnification(image, 640);
  return draw(image, channel_panel(image, channel, settings), settings.legend, magnify, settings.marks);
}

Raster preview_sheet(const Image& image, const std::string& band) {
  std::vector<Panel> panels;
  for (const char* quantity : {".temperature", ".radiance", ".transmission"}) {
    if (image.has(band + quantity)) panels.push_back(channel_panel(image, band + quantity, {}));
  }
  panels.push_back(relative_error_panel(image, band));

  std::vector<Raster> pictures;
  int width = 0, height = 0;
  for (const Panel& panel : panels) {
    pictures.push_back(draw(image, panel, true, magnification(image, 420)));
    width = std::max(width, pictures.back().columns());
    height = std::max(height, pictures.back().rows());
  }
  const int columns = pictures.size() == 4 ? 2 : static_cast<int>(pictures.size());
  const int rows = (static_cast<int>(pictures.size()) + columns - 1) / columns;
  Raster sheet(columns * width, rows * height, kPaper);
  for (int i = 0; i < static_cast<int>(pictures.size()); ++i) {
    sheet.paste(pictures[static_cast<std::size_t>(i)], i % columns * width, i / columns * height);
  }
  return sheet;
}

void write_preview(const std::filesystem::path& path, const Image& image, const std::string& channel,
                   const PreviewSettings& settings) {
  write_png(path, preview(image, channel, settings));
}

void write_preview_sheet(const std::filesystem::path& path, const Image& image, const std::string& band) {
  write_png(path, preview_sheet(image, band));
}

}  // namespace obscura
