// A study's plots: error against time and memory, bias and noise apart.
#include <fmt/format.h>

#include <algorithm>

#include "scene/study/study_table.h"

namespace obscura {
namespace {

constexpr std::array<PlotMarker, 4> kMarkers{PlotMarker::circle, PlotMarker::square, PlotMarker::triangle,
                                             PlotMarker::diamond};

PlotPoint point_of(const Study& study, const StudyRun& run, double x) {
  const RootError& error = run.error.error;
  PlotPoint point;
  point.x = x;
  point.y = error.value();
  point.y_low = error.value() - error.error();
  point.y_high = error.value() + error.error();
  point.faint = run.purpose != kLadder;
  point.title = study_label(run.setting) + ": " + detail::percent_text(error);
  point.title +=
      fmt::format("; {} CPU for {} x {}, {} for {} x {}; {}", detail::seconds_text(run.seconds.cpu()),
                  study.resolution[0], study.resolution[1], detail::seconds_text(run.full.cpu()),
                  study.full_resolution[0], study.full_resolution[1], detail::memory_text(run.full_bytes.total()));
  return point;
}

template <class X>
SvgPlot error_plot(const Study& study, PlotSettings settings, bool front, const X& x_of) {
  settings.y_label = "image error";
  settings.y_scale = 100;
  settings.y_unit = " %";
  SvgPlot plot(std::move(settings));
  const double own = study.reference.error.value();
  if (own > 0) plot.add(PlotBand{own * 1e-6, own, "error of the reference itself"});
  for (const MethodType* method : methods()) {
    const auto number = index_of(*method);
    PlotSeries series;
    series.name = method->name;
    series.colour = static_cast<int>(number);
    series.marker = kMarkers[number];
    for (const StudyRun& run : study.runs) {
      if (run.setting.method.type == method) series.points.push_back(point_of(study, run, x_of(run)));
    }
    if (!series.points.empty()) plot.add(std::move(series));
  }
  if (front && study.front.size() > 1) {
    PlotSeries series;
    series.name = "Pareto front";
    series.colour = -1;
    series.marker = PlotMarker::none;
    series.dashed = series.steps = true;
    for (const int r : study.front) {
      const StudyRun& run = study.runs[static_cast<std::size_t>(r)];
      PlotPoint point;
      point.x = x_of(run);
      point.y = run.error.error.value();
      series.points.push_back(std::move(point));
    }
    plot.add(std::move(series));
  }
  return plot;
}

}  // namespace

namespace detail {

SvgPlot time_plot(const Study& study) {
  PlotSettings settings;
  settings.title = "Error against time";
  settings.x_label = fmt::format("CPU seconds of a {} x {} picture, World and map included", study.full_resolution[0],
                                 study.full_resolution[1]);
  settings.width = 960;
  settings.height = 520;
  return error_plot(study, std::move(settings), true, [](const StudyRun& run) { return run.full.cpu(); });
}

SvgPlot memory_plot(const Study& study) {
  PlotSettings settings;
  settings.title = "Error against memory";
  settings.x_label = fmt::format("MiB of octrees, photon map and film of a {} x {} picture", study.full_resolution[0],
                                 study.full_resolution[1]);
  settings.width = 960;
  settings.height = 420;
  return error_plot(study, std::move(settings), false,
                    [](const StudyRun& run) { return run.full_bytes.total() / 1048576; });
}

SvgPlot parts_plot(const Study& study, const MethodType* method) {
  PlotSettings settings;
  settings.title = method->name;
  settings.x_label = fmt::format("CPU seconds of map and image, {} x {}", study.resolution[0], study.resolution[1]);
  settings.y_label = "image error";
  settings.y_scale = 100;
  settings.y_unit = " %";
  settings.width = 470;
  settings.height = 380;
  SvgPlot plot(std::move(settings));
  const auto number = index_of(*method);
  const auto add = [&](const char* name, int colour, PlotMarker marker, bool dashed, const auto& part) {
    PlotSeries series;
    series.name = name;
    series.colour = colour;
    series.marker = marker;
    series.dashed = dashed;
    for (const StudyRun& run : study.runs) {
      if (run.setting.method.type != method || run.purpose != kLadder) continue;
      const RootError& root = part(run.error);
      // What cannot be told from 0 is an upper end only.
      const bool seen = root.square > (marker == PlotMarker::none ? 0 : 2) * root.square_error;
      PlotPoint point;
      point.x = run.seconds.map.cpu + run.seconds.image.cpu;
      point.y = seen ? root.value() : root.value() + root.error();
      point.y_low = seen ? root.value() - root.error() : 0;
      point.y_high = root.value() + root.error();
      point.faint = !seen;
      point.title = fmt::format("{}: {} {}", study_label(run.setting), name, percent_text(root));
      series.points.push_back(std::move(point));
    }
    plot.add(std::move(series));
  };
  add("error", -1, PlotMarker::none, false, [](const PictureError& e) -> const RootError& { return e.error; });
  add("noise", static_cast<int>(number), kMarkers[number], false,
      [](const PictureError& e) -> const RootError& { return e.noise; });
  add("bias", 4, PlotMarker::diamond, true, [](const PictureError& e) -> const RootError& { return e.bias; });
  return plot;
}

}  // namespace detail

std::string study_svg(const Study& study) { return detail::time_plot(study).svg(true); }

}  // namespace obscura
