#include "scene/study/study_bench.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <ctime>

#include "scene/run/report.h"
#include "sensor/capture/render.h"

namespace obscura {
namespace {

/// Worlds that are kept, and the memory above which only the last is.
constexpr std::size_t kMostWorlds = 3;
constexpr double kMuchMemory = 512.0 * 1048576;
StudySeconds::Stage operator-(const StudySeconds::Stage& a, const StudySeconds::Stage& b) {
  return {a.cpu - b.cpu, a.wall - b.wall};
}

double film_bytes(double pixels, std::size_t bands) {
  return pixels * (static_cast<double>(bands) * Film::kBandValues + 4) * sizeof(float);
}

}  // namespace

StudyClock StudyClock::system() {
  return {[] { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); },
          [] {
            timespec t{};
            clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
            return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
          }};
}

SessionBench::SessionBench(Description scene, int pixels, StudyClock clock, const Progress& progress)
    : scene_(std::move(scene)), full_resolution_(scene_.sensor.resolution), clock_(std::move(clock)) {
  shrink_picture(scene_, pixels);
  StudySetting own;
  own.octree_tolerance = scene_.render.octree_tolerance;
  const Built& built = built_for(own, progress);
  warnings_ = scene_.warnings;
  const std::vector<std::string>& planned = built.session->plan().warnings;
  warnings_.insert(warnings_.end(), planned.begin(), planned.end());
  traits_ = traits_of(scene_, built.session->world(), built.session->plan().method);
}

Study SessionBench::describe() const {
  Study study;
  study.scene = scene_.name;
  study.hash = scene_.hash;
  study.threads = tbb::this_task_arena::max_concurrency();
  study.resolution = scene_.sensor.resolution;
  study.full_resolution = full_resolution_;
  for (const BandDescription& band : scene_.bands) {
    study.bands.push_back(band.name);
    study.grey.push_back(band.grey());
  }
  study.warnings = warnings_;
  return study;
}

SessionBench::Built& SessionBench::built_for(const StudySetting& setting, const Progress& progress) {
  const auto found =
      std::find_if(built_.begin(), built_.end(), [&](const Built& b) { return same_world(b.of, setting); });
  if (found != built_.end()) {
    built_.splice(built_.begin(), built_, found);
    return built_.front();
  }
  double bytes = 0;
  for (const Built& b : built_) bytes += b.octree_bytes;
  while (!built_.empty() && (built_.size() >= kMostWorlds || bytes > kMuchMemory)) {
    bytes -= built_.back().octree_bytes;
    built_.pop_back();
  }
  Description scene = scene_;
  if (!built_.empty() || !(setting.octree_tolerance == scene.render.octree_tolerance))
    scene.render.octree_tolerance = setting.octree_tolerance;
  for (BandDescription& band : scene.bands) {
    if (!band.grey() && setting.intervals > 0) band.samples = setting.intervals;
  }
  Built built;
  built.of = setting;
  const auto begin = now();
  built.session = std::make_unique<Session>(std::move(scene), scene_.time_s, progress,
                                            setting.everything ? std::optional(0.0) : std::nullopt);
  built.world = now() - begin;
  for (const OctreeRecord& octree : built.session->octrees())
    built.octree_bytes += static_cast<double>(octree.statistics.bytes);
  built_.push_front(std::move(built));
  return built_.front();
}

StudyPicture SessionBench::picture_of(const Built& built, const Rendered& rendered) const {
  StudyPicture result;
  result.picture = obscura::picture_of(rendered.film);
  result.seconds.world = built.world;
  result.bytes.octree = built.octree_bytes;
  result.bytes.film =
      film_bytes(static_cast<double>(rendered.film.columns()) * rendered.film.rows(), scene_.bands.size());
  result.peak_MiB = peak_memory_MiB();
  return result;
}

StudyPicture SessionBench::measure(const StudySetting& setting, std::uint64_t seed, const Progress& progress) {
  Built& built = built_for(setting, progress);
  Session& session = *built.session;
  const Method method = full_method(setting, session.scene());

  // A map that the session still holds costs what it did when it was made.
  const auto before = now();
  const Estimator estimator = session.estimator(method, seed, progress);
  const auto solved = now();
  if (progress.cancelled()) throw NumericalError("study", "stopped");
  EstimatorSettings settings;
  settings.seed = seed;
  const SolutionBasis basis = method.type->basis(method, settings);
  if (!built.solved || !(*built.solved == basis)) {
    built.solved = basis;
    built.map = solved - before;
  }

  SamplerSettings sampling = session.plan().sampling;
  sampling.max_oversampling = setting.rays;
  const Rendered rendered = session.render(session.plan().camera, sampling, method, seed, progress);
  StudyPicture result = picture_of(built, rendered);
  if (method.type->photons || method.type->cells) result.seconds.map = built.map;
  result.seconds.image = now() - solved;
  result.bytes.map = estimator.bytes;
  if (method.type->cells) {
    // The solver's own error and the scatter of the rays.
    Picture errors = result.picture;
    for (int b = 0; b < rendered.film.bands(); ++b) {
      const auto bias = rendered.film.values(b, Film::Value::bias), error = rendered.film.values(b, Film::Value::error);
      for (std::size_t p = 0; p < bias.size(); ++p)
        errors.bands[static_cast<std::size_t>(b)][p] = std::hypot(bias[p], error[p]);
    }
    result.errors = std::move(errors);
  }
  return result;
}

}  // namespace obscura
