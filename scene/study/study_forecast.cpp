#include "scene/study/study_forecast.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace obscura {
namespace {

/// Of a setting of which nothing is known.
constexpr double kUnknown_s = 1;

/// What the map's making takes where it grows from the work of `a` to that of `b`.
double map_share(double seconds, const StudyWork& a, const StudyWork& b) {
  return a.map > 0 ? seconds * b.map / a.map : 0.0;
}

}  // namespace

const StudyRun* StudyForecast::nearest_run(const StudySetting& setting) const {
  const StudyRun* best = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const StudyRun& run : *runs_) {
    if (run.setting.method.type != setting.method.type) continue;
    const StudyWork a = work_of(run.setting), b = work_of(setting);
    const double far =
        std::abs(std::log((b.map + 1) / (a.map + 1))) + std::abs(std::log((b.image + 1) / (a.image + 1)));
    if (far < least) least = far, best = &run;
  }
  return best;
}

double StudyForecast::world_s(const StudySetting& setting) const {
  double most = 0;
  for (const StudyRun& run : *runs_) {
    if (same_world(run.setting, setting)) return 0;
    most = std::max(most, run.seconds.world.wall);
  }
  return most;
}

double StudyForecast::picture_s(const StudySetting& setting) const {
  const StudyRun* run = nearest_run(setting);
  if (!run) return kUnknown_s;
  const StudyWork a = work_of(run->setting), b = work_of(setting);
  return map_share(run->seconds.map.wall, a, b) + run->seconds.image.wall * b.image / a.image;
}

double StudyForecast::full_cpu_s(const StudySetting& setting) const {
  const StudyRun* run = nearest_run(setting);
  if (!run) return std::numeric_limits<double>::infinity();
  const StudyWork a = work_of(run->setting), b = work_of(setting);
  return run->full.world.cpu + map_share(run->full.map.cpu, a, b) + run->full.image.cpu * b.image / a.image;
}

}  // namespace obscura
