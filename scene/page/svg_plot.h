// A plot on two logarithmic axes as SVG: points with error bars, lines, bands. Knows nothing of what it shows.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace obscura {

struct PlotPoint {
  double x = 0, y = 0;
  double y_low = 0, y_high = 0;  ///< ends of the error bar; both 0: none
  std::string title = {};        ///< shown where the pointer rests on it
  bool faint = false;            ///< small and hollow
};

enum class PlotMarker { circle, square, triangle, diamond, none };

struct PlotSeries {
  std::string name;  ///< in the legend; empty: not there
  int colour = 0;    ///< number in the palette; negative: the ink's
  PlotMarker marker = PlotMarker::circle;
  bool line = true;  ///< joins the points that are not faint
  bool dashed = false;
  bool steps = false;  ///< a line of a staircase: level up to the next point's x
  std::vector<PlotPoint> points = {};
};

/// Values of y between which the plot is shaded.
struct PlotBand {
  double low = 0, high = 0;
  std::string label;
};

struct PlotSettings {
  std::string title, x_label, y_label;
  int width = 720, height = 440;
  double y_scale = 1;       ///< y is shown times this (100: per cent)
  std::string y_unit = {};  ///< behind every number of the y axis
  std::optional<std::array<double, 2>> x_range = std::nullopt, y_range = std::nullopt;  ///< none: what holds all points
};

/// Places of ticks on a logarithmic axis, in increasing order: 1, 2, 5 in each decade, fewer where there
/// are many decades, every digit where there is none.
struct LogTick {
  double value = 0;
  bool labelled = true;
};
std::vector<LogTick> log_ticks(double low, double high);

/// The part of a line inside a rectangle {left, top, right, bottom}; nothing where none is (Liang & Barsky 1984).
std::optional<std::array<double, 4>> clipped(std::array<double, 4> line, const std::array<double, 4>& box);

class SvgPlot {
 public:
  explicit SvgPlot(PlotSettings settings) : settings_(std::move(settings)) {}

  void add(PlotSeries series) { series_.push_back(std::move(series)); }
  void add(PlotBand band) { bands_.push_back(std::move(band)); }

  /// What is not positive or outside the range is not drawn.
  /// @param standalone a file of its own, with its colours; else for a page that has --ink, --paper, --faint, --line
  std::string svg(bool standalone = false) const;

 private:
  PlotSettings settings_;
  std::vector<PlotSeries> series_;
  std::vector<PlotBand> bands_;
};

}  // namespace obscura
