// What clouds hide as one page that needs no other file: pictures with and without the clouds, and the tables.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ostream>

#include "scene/hiding/obscuration_table.h"
#include "scene/page/html_page.h"
#include "sensor/picture/preview.h"
#include "sensor/picture/whole_file_io.h"

namespace obscura {

using namespace detail;

namespace {

/// A rectangle of pixels: left, top, columns, rows.
using Box = std::array<int, 4>;

std::size_t at(int x, int y, int columns) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x);
}

/// 1: surroundings, 2: the object.
std::vector<std::uint8_t> marks_of(const ObjectMask& mask) {
  std::vector<std::uint8_t> marks(mask.share.size());
  for (std::size_t i = 0; i < marks.size(); ++i) marks[i] = mask.share[i] > 0 ? 2 : mask.ring[i] ? 1 : 0;
  return marks;
}

/// Object and surroundings with a margin.
Box box_of(const ObjectMask& mask) {
  int x0 = mask.columns, y0 = mask.rows, x1 = 0, y1 = 0;
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.columns; ++x) {
      const std::size_t i = at(x, y, mask.columns);
      if (!(mask.share[i] > 0) && !mask.ring[i]) continue;
      x0 = std::min(x0, x), x1 = std::max(x1, x + 1), y0 = std::min(y0, y), y1 = std::max(y1, y + 1);
    }
  }
  const int margin = std::max(2, mask.width / 2);
  x0 = std::max(0, x0 - margin), y0 = std::max(0, y0 - margin);
  x1 = std::min(mask.columns, x1 + margin), y1 = std::min(mask.rows, y1 + margin);
  return {x0, y0, x1 - x0, y1 - y0};
}

template <class T>
std::vector<T> cut(std::span<const T> values, int columns, const Box& box) {
  std::vector<T> result;
  for (int y = box[1]; y < box[1] + box[3]; ++y) {
    for (int x = box[0]; x < box[0] + box[2]; ++x) result.push_back(values[at(x, y, columns)]);
  }
  return result;
}

Image cut(const Image& image, const std::string& channel, const Box& box) {
  Image part(box[2], box[3]);
  part.metadata = image.metadata;
  for (const std::string& name : {channel, std::string("rays.N")}) {
    const std::vector<float> values = cut(image.channel(name), image.columns(), box);
    std::copy(values.begin(), values.end(), part.add(name).begin());
  }
  return part;
}

/// One scale for the pictures with and without the cloud: it leaves out the same few of both.
void share_scale(const Obscuration& obscuration, const std::string& channel, const Box& box,
                 PreviewSettings& settings) {
  std::vector<float> values;
  for (const Image* image : {&*obscuration.with, &*obscuration.without}) {
    const std::vector<float> part = cut(image->channel(channel), image->columns(), box);
    // 0 K is no temperature.
    std::copy_if(part.begin(), part.end(), std::back_inserter(values),
                 [&](float v) { return std::isfinite(v) && (v > 0 || !channel.ends_with(".temperature")); });
  }
  if (values.empty()) return;
  std::sort(values.begin(), values.end());
  const auto rank = [&](double share) {
    return static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)));
  };
  double low = values[rank(settings.cut)], high = values[rank(1 - settings.cut)];
  const double least = 1e-4 * std::max(std::abs(low), std::abs(high));
  if (high - low < least) low -= least, high += least;
  settings.low = low;
  settings.high = high;
}

std::string pictures(const Obscuration& obscuration, const std::string& band, bool grey, const Box& box,
                     const std::vector<std::uint8_t>& marks) {
  const Image& with = *obscuration.with;
  std::string html = "<div class=\"pictures\">\n";
  PreviewSettings settings;
  settings.marks = cut(std::span<const std::uint8_t>(marks), with.columns(), box);
  settings.magnify = std::clamp(static_cast<int>(std::lround(480.0 / std::max(box[2], box[3]))), 1, 16);
  const bool thermal = !grey && with.has(band + ".temperature") &&
                       std::get<double>(with.metadata.at("obscura:band." + band + ".um_max")) > kThermal_um;
  std::string shown = band;
  shown += thermal ? ".temperature" : ".radiance";
  share_scale(obscuration, shown, box, settings);
  const auto add = [&](const std::string& title, const Image& image, const std::string& channel) {
    html += fmt::format("<figure>{}<figcaption>{}</figcaption></figure>\n",
                        html_picture(title, preview(cut(image, channel, box), channel, settings)), html_escaped(title));
  };
  add("with the cloud", with, shown);
  add("without the cloud", *obscuration.without, shown);
  settings.low = 0;
  settings.high = 1;
  add("transmission of the cloud", with, band + ".transmission");
  return html + "</div>\n";
}

std::string cell(const std::optional<Confident>& c, bool told) {
  if (!c) return told ? "<td class=\"faint\">&ndash;</td>" : "<td></td>";
  return fmt::format("<td>{}</td>", confident_text(c));
}

std::string table(const BandObscuration& band, const ObscurationSettings& thresholds) {
  std::string html = fmt::format(
      "<div class=\"scroll\"><table><tr><th>{}</th><th>with the cloud</th><th>without</th><th>with / "
      "without</th></tr>\n",
      html_escaped(band.band));
  for (const ObscurationRow& row : obscuration_rows(band, thresholds)) {
    std::string name = row.quantity;
    if (!row.unit.empty()) name += " [" + row.unit + "]";
    html += fmt::format("<tr><td>{}</td>{}{}{}</tr>\n", html_escaped(name), cell(row.with, true),
                        cell(row.without, false), cell(row.ratio, false));
  }
  html += "</table></div>\n";
  for (const std::string& note : band.notes) html += fmt::format("<p class=\"about\">{}</p>\n", html_escaped(note));
  return html;
}

std::string page(const Obscuration& obscuration) {
  std::string html = fmt::format(
      "<h1>Obscura {}: what the clouds hide</h1>\n<p class=\"about\">{}; {} replicas, seed {}{}</p>\n", OBSCURA_VERSION,
      html_escaped(obscuration.scene.empty() ? "scene " + obscuration.hash : obscuration.scene), obscuration.replicas,
      obscuration.seed, obscuration.partial ? "; <span class=\"differ\">stopped before the end</span>" : "");
  html +=
      "<p class=\"about\">Objects are outlined in green, their surroundings in blue. Numbers stand with their 95 % "
      "intervals. The pictures with "
      "and without the cloud have one colour scale. Transmission is that of the clouds between the sensor and the "
      "object.</p>\n";
  const bool pictured = obscuration.with && obscuration.without;
  if (pictured && !obscuration.objects.empty()) {
    html += "<h2>The picture</h2>\n";
    std::vector<std::uint8_t> marks(obscuration.with->pixel_count());
    for (const ObjectObscuration& object : obscuration.objects) {
      const std::vector<std::uint8_t> own = marks_of(object.mask);
      for (std::size_t i = 0; i < marks.size(); ++i) marks[i] = std::max(marks[i], own[i]);
    }
    for (const BandObscuration& band : obscuration.objects.front().bands) {
      html += pictures(obscuration, band.band, band.grey, {0, 0, obscuration.with->columns(), obscuration.with->rows()},
                       marks);
    }
  }
  for (const ObjectObscuration& object : obscuration.objects) {
    html += fmt::format("<h2>{}</h2>\n<p class=\"about\">{}</p>\n", html_escaped(object.name),
                        html_escaped(object_text(object)));
    for (const std::string& note : object.notes) html += fmt::format("<p class=\"about\">{}</p>\n", html_escaped(note));
    const std::vector<std::uint8_t> marks = marks_of(object.mask);
    for (const BandObscuration& band : object.bands) {
      if (pictured) html += pictures(obscuration, band.band, band.grey, box_of(object.mask), marks);
      html += table(band, obscuration.wish.thresholds);
    }
  }
  if (!obscuration.left_out.empty() || !obscuration.warnings.empty()) {
    html += "<h2>Beside</h2>\n<ul class=\"what\">\n";
    for (const std::string& text : obscuration.left_out)
      html += fmt::format("<li>left out: {}</li>\n", html_escaped(text));
    for (const std::string& text : obscuration.warnings) html += fmt::format("<li>{}</li>\n", html_escaped(text));
    html += "</ul>\n";
  }
  return html_page("Obscura: what the clouds hide", html);
}

}  // namespace

void write_obscuration_html(const std::filesystem::path& file, const Obscuration& obscuration) {
  write_whole_stream(file, [&](std::ostream& stream) { stream << page(obscuration); });
}

}  // namespace obscura
