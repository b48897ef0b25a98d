#include "scene/page/svg_plot.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace obscura;

namespace {

std::vector<double> labelled(double low, double high) {
  std::vector<double> values;
  for (const LogTick& tick : log_ticks(low, high)) {
    if (tick.labelled) values.push_back(tick.value);
  }
  return values;
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

SvgPlot plot() {
  PlotSettings settings;
  settings.title = "a < b";
  settings.x_label = "seconds";
  settings.y_label = "error";
  return SvgPlot(settings);
}

}  // namespace

TEST_CASE("ticks are 1, 2 and 5 of each decade inside the range", "[svg_plot]") {
  CHECK(labelled(1, 10) == std::vector<double>{1, 2, 5, 10});
  CHECK(labelled(0.003, 0.3) == std::vector<double>{0.005, 0.01, 0.02, 0.05, 0.1, 0.2});
  CHECK(labelled(0.85, 2.1) == std::vector<double>{0.9, 1, 2});
}

TEST_CASE("many decades have fewer labels, and no range has none", "[svg_plot]") {
  CHECK(labelled(1, 1e4) == std::vector<double>{1, 10, 100, 1000, 10000});
  CHECK(log_ticks(1, 1e4).size() == 13);
  CHECK(labelled(1e-9, 1e9).size() <= 12);
  CHECK(log_ticks(0, 1).empty());
  CHECK(log_ticks(2, 1).empty());
}

TEST_CASE("lines end at the frame", "[svg_plot]") {
  const std::array<double, 4> box{0, 0, 10, 10};
  CHECK(clipped({1, 1, 9, 9}, box) == std::array<double, 4>{1, 1, 9, 9});
  CHECK(clipped({-10, 5, 20, 5}, box) == std::array<double, 4>{0, 5, 10, 5});
  CHECK(clipped({5, -5, 5, 5}, box) == std::array<double, 4>{5, 0, 5, 5});
  CHECK(clipped({-5, 0, 5, 10}, box) == std::array<double, 4>{0, 5, 5, 10});
  CHECK_FALSE(clipped({-5, -1, 20, -1}, box));
  CHECK_FALSE(clipped({-10, 5, 5, 20}, box));
}

TEST_CASE("points outside the range and not positive ones are not drawn", "[svg_plot]") {
  PlotSettings settings;
  settings.x_range = {1.0, 100.0};
  settings.y_range = {1.0, 100.0};
  SvgPlot drawn(settings);
  PlotSeries series;
  series.line = false;
  for (const auto& [x, y] :
       std::vector<std::pair<double, double>>{{10, 10}, {1000, 10}, {10, 0.1}, {0, 10}, {10, -1}}) {
    PlotPoint point;
    point.x = x;
    point.y = y;
    series.points.push_back(point);
  }
  drawn.add(series);
  const std::string svg = drawn.svg();
  std::size_t circles = 0;
  for (std::size_t at = svg.find("<circle"); at != std::string::npos; at = svg.find("<circle", at + 1)) ++circles;
  CHECK(circles == 1);
  // The middle of both ranges is the middle of the frame.
  CHECK(contains(svg, "<circle cx=\"390.0\""));
  CHECK_FALSE(contains(svg, "nan"));
  CHECK_FALSE(contains(svg, "inf"));
}

TEST_CASE("a plot without points is a plot", "[svg_plot]") {
  const std::string svg = plot().svg();
  CHECK(contains(svg, "a &lt; b"));
  CHECK_FALSE(contains(svg, "nan"));
  CHECK_FALSE(contains(svg, "http"));
  CHECK(contains(plot().svg(true), "xmlns"));
}

TEST_CASE("a single point stands amid its axes", "[svg_plot]") {
  SvgPlot drawn = plot();
  PlotSeries series;
  series.name = "one";
  PlotPoint point;
  point.x = 3, point.y = 0.01, point.y_low = 0.009, point.y_high = 0.011;
  point.title = "the \"one\"";
  series.points.push_back(point);
  drawn.add(series);
  const std::string svg = drawn.svg();
  CHECK(contains(svg, "&quot;one&quot;"));
  CHECK(contains(svg, "cx=\"390.0\""));
}
