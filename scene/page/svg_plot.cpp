#include "scene/page/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "scene/page/html_page.h"

namespace obscura {
namespace {

using detail::html_escaped;

/// Told apart on light and dark paper, and by most who confuse red and green.
constexpr std::array<const char*, 6> kPalette{"#e08214", "#2b83d6", "#1a9850", "#a35bd1", "#d6446c", "#7a7d87"};
constexpr double kLeft = 78, kRight = 18, kBottom = 52, kTitle = 30, kLegendLine = 20;
constexpr double kFewDecades = 0.8;  // below which every digit has a tick
constexpr double kLetter = 7.2;      // mean width at 13 px

std::string colour(int number) {
  return number < 0 ? "var(--ink)" : kPalette[static_cast<std::size_t>(number) % kPalette.size()];
}

std::string shape(PlotMarker marker, double x, double y, double size, const std::string& ink, bool hollow) {
  const std::string paint = hollow ? fmt::format("fill=\"var(--paper)\" stroke=\"{}\" stroke-width=\"1.3\"", ink)
                                   : fmt::format("fill=\"{}\" stroke=\"{}\" stroke-width=\"1\"", ink, ink);
  switch (marker) {
    case PlotMarker::none:
      return {};
    case PlotMarker::circle:
      return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\" {}", x, y, size, paint);
    case PlotMarker::square:
      return fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" {}", x - 0.9 * size,
                         y - 0.9 * size, 1.8 * size, 1.8 * size, paint);
    case PlotMarker::triangle:
      return fmt::format("<path d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}L{:.1f} {:.1f}Z\" {}", x, y - 1.2 * size,
                         x + 1.1 * size, y + 0.8 * size, x - 1.1 * size, y + 0.8 * size, paint);
    case PlotMarker::diamond:
      break;
  }
  return fmt::format("<path d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}L{:.1f} {:.1f}L{:.1f} {:.1f}Z\" {}", x, y - 1.3 * size,
                     x + 1.3 * size, y, x, y + 1.3 * size, x - 1.3 * size, y, paint);
}

std::string drawn(PlotMarker marker, double x, double y, double size, const std::string& ink, bool hollow,
                  const std::string& title) {
  const std::string open = shape(marker, x, y, size, ink, hollow);
  if (open.empty()) return {};
  std::string text = open;
  text += title.empty()
              ? std::string("/>\n")
              : fmt::format("><title>{}</title></{}>\n", html_escaped(title), open.substr(1, open.find(' ') - 1));
  return text;
}

/// A range that holds what there is, with some air; a decade around 1 where there is nothing.
std::array<double, 2> range_of(const std::vector<double>& values) {
  double low = INFINITY, high = 0;
  for (const double v : values) {
    if (v > 0 && std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  }
  if (!(high > 0)) return {0.3, 3};
  const double air = std::max(std::pow(high / low, 0.06), high / low < 1.5 ? 1.6 : 1.12);
  return {low / air, high * air};
}

std::string number_text(double value) {
  if (value >= 1e6 || value < 1e-4) return fmt::format("{:.0e}", value);
  return fmt::format("{:.6g}", value);
}

/// Places and texts of ticks below an axis, those of round numbers first, as far as they do not touch.
template <class ToX>
std::vector<std::pair<double, std::string>> labels_that_fit(const std::vector<LogTick>& ticks, const ToX& to_x) {
  std::vector<std::pair<double, std::string>> labels;
  for (const std::string_view digits : {"1", "25", "346789"}) {
    for (const LogTick& tick : ticks) {
      const char first = fmt::format("{:.0e}", tick.value).front();
      if (!tick.labelled || digits.find(first) == std::string_view::npos) continue;
      const double x = to_x(tick.value);
      const std::string text = number_text(tick.value);
      const bool free = std::all_of(labels.begin(), labels.end(), [&](const auto& other) {
        return std::abs(other.first - x) > 0.5 * kLetter * static_cast<double>(text.size() + other.second.size()) + 6;
      });
      if (free) labels.emplace_back(x, text);
    }
  }
  return labels;
}

const char* const kStandalone =
    "<style>svg { --ink: #1c1d22; --paper: #ffffff; --faint: #6b6d78; --line: #dcdde3; }\n"
    "@media (prefers-color-scheme: dark) { svg { --ink: #e4e4ea; --paper: #16171c; --faint: #9a9ca8; --line: #34363f; "
    "} }</style>\n";

}  // namespace

std::vector<LogTick> log_ticks(double low, double high) {
  std::vector<LogTick> ticks;
  if (!(low > 0) || !(high > low)) return ticks;
  const double decades = std::log10(high / low);
  const int every = std::max(1, static_cast<int>(std::ceil(decades / 12)));
  const auto first = static_cast<int>(std::floor(std::log10(low) - 1e-9)),
             last = static_cast<int>(std::ceil(std::log10(high) + 1e-9));
  for (int e = first; e <= last; ++e) {
    for (const int m : {1, 2, 3, 4, 5, 6, 7, 8, 9}) {
      if (m != 1 && m != 2 && m != 5 && decades > kFewDecades) continue;
      // A power from its text is the number that the text says.
      const double value = std::stod(fmt::format("{}e{}", m, e));
      if (value < low * (1 - 1e-12) || value > high * (1 + 1e-12)) continue;
      if (m == 1 && e % every != 0) continue;
      if (m != 1 && decades > 6) continue;
      ticks.push_back({value, m == 1 || decades <= 2.2});
    }
  }
  return ticks;
}

std::optional<std::array<double, 4>> clipped(std::array<double, 4> line, const std::array<double, 4>& box) {
  double begin = 0, end = 1;
  const double dx = line[2] - line[0], dy = line[3] - line[1];
  const auto cut = [&](double p, double q) {
    if (p == 0) return q >= 0;
    const double t = q / p;
    if (p < 0)
      begin = std::max(begin, t);
    else
      end = std::min(end, t);
    return begin <= end;
  };
  if (!cut(-dx, line[0] - box[0]) || !cut(dx, box[2] - line[0]) || !cut(-dy, line[1] - box[1]) ||
      !cut(dy, box[3] - line[1]))
    return std::nullopt;
  return std::array<double, 4>{line[0] + begin * dx, line[1] + begin * dy, line[0] + end * dx, line[1] + end * dy};
}

std::string SvgPlot::svg(bool standalone) const {
  std::vector<double> xs, ys;
  for (const PlotSeries& series : series_) {
    for (const PlotPoint& p : series.points) {
      if (!(p.x > 0) || !(p.y > 0)) continue;
      xs.push_back(p.x);
      ys.push_back(p.y);
      if (p.y_high > 0) ys.push_back(p.y_high);
      // A bar that reaches to 0 does not stretch the axis for it.
      if (p.y_low > 0.2 * p.y) ys.push_back(p.y_low);
    }
  }
  const std::array<double, 2> xr = settings_.x_range.value_or(range_of(xs));
  std::array<double, 2> yr = settings_.y_range.value_or(range_of(ys));
  for (double& y : yr) y *= settings_.y_scale;

  // The legend takes as many lines as it needs.
  struct Entry {
    const PlotSeries* series;
    double x, y;
  };
  std::vector<Entry> legend;
  double at = kLeft, line = kTitle + 16;
  for (const PlotSeries& series : series_) {
    if (series.name.empty()) continue;
    const double width = 30 + kLetter * static_cast<double>(series.name.size()) + 22;
    if (at + width > settings_.width - kRight && at > kLeft) at = kLeft, line += kLegendLine;
    legend.push_back({&series, at, line});
    at += width;
  }
  const double top = (legend.empty() ? kTitle : line) + 14;
  const std::array<double, 4> box{kLeft, top, settings_.width - kRight, settings_.height - kBottom};
  const auto to_x = [&](double v) {
    return box[0] + (box[2] - box[0]) * std::log(v / xr[0]) / std::log(xr[1] / xr[0]);
  };
  const auto to_y = [&](double v) {
    return box[3] - (box[3] - box[1]) * std::log(v * settings_.y_scale / yr[0]) / std::log(yr[1] / yr[0]);
  };
  const auto inside = [&](double x, double y) { return x >= box[0] && x <= box[2] && y >= box[1] && y <= box[3]; };

  std::string s = fmt::format(
      "<svg {}viewBox=\"0 0 {} {}\" width=\"{}\" height=\"{}\" font-family=\"system-ui, sans-serif\" font-size=\"13\" "
      "role=\"img\">\n",
      standalone ? "xmlns=\"http://www.w3.org/2000/svg\" " : "", settings_.width, settings_.height, settings_.width,
      settings_.height);
  if (standalone) {
    s += kStandalone;
    s += fmt::format("<rect width=\"{}\" height=\"{}\" fill=\"var(--paper)\"/>\n", settings_.width, settings_.height);
  }
  s += fmt::format("<text x=\"{}\" y=\"20\" fill=\"var(--ink)\" font-size=\"15\" font-weight=\"600\">{}</text>\n",
                   kLeft, html_escaped(settings_.title));

  for (const PlotBand& band : bands_) {
    const double low = std::max(band.low * settings_.y_scale, yr[0]),
                 high = std::min(band.high * settings_.y_scale, yr[1]);
    if (!(high > low)) continue;
    const double y0 = to_y(high / settings_.y_scale), y1 = to_y(low / settings_.y_scale);
    s += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"var(--faint)\" opacity=\"0.16\"/>\n",
        box[0], y0, box[2] - box[0], y1 - y0);
    if (y1 - y0 > 16) {
      s += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" fill=\"var(--faint)\" font-size=\"12\">{}</text>\n", box[0] + 6,
                       std::min(y0 + 14, box[3] - 4), html_escaped(band.label));
    }
  }
  for (const LogTick& tick : log_ticks(xr[0], xr[1])) {
    const double x = to_x(tick.value);
    s += fmt::format(
        "<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1:.1f}\" y2=\"{2:.1f}\" stroke=\"var(--line)\" "
        "stroke-width=\"{3}\"/>\n",
        x, box[1], box[3], tick.labelled ? 1.0 : 0.5);
  }
  for (const auto& [x, text] : labels_that_fit(log_ticks(xr[0], xr[1]), to_x)) {
    s += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" fill=\"var(--faint)\" text-anchor=\"middle\">{}</text>\n", x,
                     box[3] + 18, text);
  }
  for (const LogTick& tick : log_ticks(yr[0], yr[1])) {
    const double y = to_y(tick.value / settings_.y_scale);
    s += fmt::format(
        "<line x1=\"{1:.1f}\" x2=\"{2:.1f}\" y1=\"{0:.1f}\" y2=\"{0:.1f}\" stroke=\"var(--line)\" "
        "stroke-width=\"{3}\"/>\n",
        y, box[0], box[2], tick.labelled ? 1.0 : 0.5);
    if (tick.labelled) {
      s += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" fill=\"var(--faint)\" text-anchor=\"end\">{}{}</text>\n",
                       box[0] - 7, y + 4.5, number_text(tick.value), html_escaped(settings_.y_unit));
    }
  }
  s += fmt::format(
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"none\" stroke=\"var(--faint)\"/>\n",
      box[0], box[1], box[2] - box[0], box[3] - box[1]);
  s += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" fill=\"var(--ink)\" text-anchor=\"middle\">{}</text>\n",
                   (box[0] + box[2]) / 2, box[3] + 40, html_escaped(settings_.x_label));
  s += fmt::format(
      "<text transform=\"translate(18 {:.1f}) rotate(-90)\" fill=\"var(--ink)\" text-anchor=\"middle\">{}</text>\n",
      (box[1] + box[3]) / 2, html_escaped(settings_.y_label));

  const auto stroke = [&](std::array<double, 4> ends, const std::string& ink, double width, bool dashed) {
    const auto part = clipped(ends, box);
    if (!part) return;
    s += fmt::format(
        "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" stroke-width=\"{}\"{}/>\n",
        (*part)[0], (*part)[1], (*part)[2], (*part)[3], ink, width, dashed ? " stroke-dasharray=\"6 4\"" : "");
  };
  for (const PlotSeries& series : series_) {
    const std::string ink = colour(series.colour);
    const PlotPoint* last = nullptr;
    for (const PlotPoint& p : series.points) {
      if (!(p.x > 0) || !(p.y > 0) || p.faint) continue;
      if (last && series.line) {
        if (series.steps) {
          stroke({to_x(last->x), to_y(last->y), to_x(p.x), to_y(last->y)}, ink, 1, series.dashed);
          stroke({to_x(p.x), to_y(last->y), to_x(p.x), to_y(p.y)}, ink, 1, series.dashed);
        } else {
          stroke({to_x(last->x), to_y(last->y), to_x(p.x), to_y(p.y)}, ink, 1.8, series.dashed);
        }
      }
      last = &p;
    }
  }
  for (const bool faint : {true, false}) {
    for (const PlotSeries& series : series_) {
      const std::string ink = colour(series.colour);
      for (const PlotPoint& p : series.points) {
        if (p.faint != faint || !(p.x > 0) || !(p.y > 0)) continue;
        const double x = to_x(p.x), y = to_y(p.y);
        if (p.y_high > p.y_low && x >= box[0] && x <= box[2]) {
          const double down = p.y_low > 0 ? to_y(p.y_low) : box[3] + 1;
          stroke({x, to_y(p.y_high), x, down}, ink, faint ? 0.8 : 1.2, false);
        }
        if (inside(x, y)) s += drawn(series.marker, x, y, faint ? 3.0 : 4.6, ink, faint, p.title);
      }
    }
  }
  for (const Entry& entry : legend) {
    const std::string ink = colour(entry.series->colour);
    if (entry.series->line) {
      s += fmt::format(
          "<line x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" stroke-width=\"{}\"{}/>\n",
          entry.x, entry.x + 24, entry.y - 4, entry.y - 4, ink, entry.series->steps ? 1.0 : 1.8,
          entry.series->dashed ? " stroke-dasharray=\"6 4\"" : "");
    }
    s += drawn(entry.series->marker, entry.x + 12, entry.y - 4, 4.6, ink, false, {});
    s += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" fill=\"var(--ink)\">{}</text>\n", entry.x + 30, entry.y,
                     html_escaped(entry.series->name));
  }
  return s + "</svg>\n";
}

}  // namespace obscura
