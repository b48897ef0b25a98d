#include "scene/study/study_bench.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <ctime>

#include "photon/ordinates/ordinates_referee.h"
#include "photon/paths/path_tracer.h"
#include "scene/run/report.h"
#include "scene/verify/verify.h"
#include "sensor/capture/render.h"

namespace obscura {
namespace {

/// Worlds that are kept, and the memory above which only the last is.
constexpr std::size_t kMostWorlds = 3;
constexpr double kMuchMemory = 512.0 * 1048576;
/// More is refused by the ordinates.
constexpr double kOrdinatesMiB = 2048;

StudySeconds::Stage operator-(const StudySeconds::Stage& a, const StudySeconds::Stage& b) {
  return {a.cpu - b.cpu, a.wall - b.wall};
}

bool uses_maps(const StudySetting& s) { return s.method == StudyMethod::photon || s.method == StudyMethod::gather; }

double film_bytes(double pixels, std::size_t bands) {
  return pixels * (static_cast<double>(bands) * Film::kBandValues + 4) * sizeof(float);
}

/// The ordinates' own choice of cells, with another number along the longest side.
Vec3i cells_of(const World& world, int longest) {
  Vec3i cells = OrdinatesGrid(world, 0, Vec3i(0), std::nullopt, 1).cells();
  const double factor = static_cast<double>(longest) / std::max({cells.x, cells.y, cells.z});
  for (int axis = 0; axis < 3; ++axis) cells[axis] = std::max(1, static_cast<int>(std::lround(cells[axis] * factor)));
  return cells;
}

/// What the solver holds while it iterates: about 26 vectors of eight moments' expansions a cell
/// (ordinates_solver.cpp).
double solver_bytes(const OrdinatesSolution& solution, int order) {
  const double degree = std::min(solution.grid().phase_degree(order), order - 1);
  return 26 * 8 * sizeof(double) * static_cast<double>(solution.grid().size()) * (degree + 1) * (degree + 1);
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
  traits_ = traits_of(scene_, built.session->world(), built.session->plan().radiance.gather_bounces > 0);
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
  study.warnings = scene_.warnings;
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
  if (setting.method == StudyMethod::ordinates) return by_ordinates(setting, seed, false, progress);
  Built& built = built_for(setting, progress);
  Session& session = *built.session;
  if (setting.method == StudyMethod::path) refuse_unfit_paths(session.world());
  Description scene = session.scene();
  apply(setting, scene);
  scene.render.seed = seed;
  session.look_from(scene.sensor);
  session.set_render(scene.render);

  StudySeconds seconds;
  const auto before = now();
  const Light& light = session.light(progress);
  const auto lit = now();
  if (uses_maps(setting)) {
    if (built.map_of.photons != setting.photons || built.map_seed != seed || !uses_maps(built.map_of)) {
      built.map = lit - before;
      built.map_seed = seed;
    }
    built.map_of = setting;
    seconds.map = built.map;
  } else {
    built.map_of = {};
  }
  StudyPicture result = picture_of(built, session.render(progress));
  result.seconds.map = seconds.map;
  result.seconds.image = now() - lit;
  result.bytes.map = static_cast<double>(light.bytes);
  return result;
}

StudyPicture SessionBench::ordinates_reference(const StudySetting& setting, std::uint64_t seed,
                                               const Progress& progress) {
  return by_ordinates(setting, seed, true, progress);
}

StudyPicture SessionBench::by_ordinates(const StudySetting& setting, std::uint64_t seed, bool with_error,
                                        const Progress& progress) {
  Built& built = built_for(setting, progress);
  const World& world = built.session->world();
  const auto before = now();
  OrdinatesSettings settings;
  settings.cells = cells_of(world, setting.cells);
  settings.order = setting.order;
  settings.memory_MiB = kOrdinatesMiB;
  std::vector<OrdinatesReferee> referees;
  std::vector<OrdinatesSolution> solutions;
  for (int i = 0; i < world.interval_count() && !progress.cancelled(); ++i) {
    if (with_error) {
      referees.emplace_back(world, i, settings, progress);
    } else {
      solutions.push_back(solve_ordinates(world, i, settings, progress));
    }
  }
  const auto solved = now();
  if (progress.cancelled()) throw NumericalError("ordinates", "stopped");

  const Estimator estimator = [&](int interval, double, std::span<const Ray> rays, std::span<const std::uint64_t>,
                                  std::span<Incoming> incoming) {
    const auto i = static_cast<std::size_t>(interval);
    if (with_error) {
      std::vector<OrdinatesEstimate> estimates(rays.size());
      referees[i].radiance(rays, estimates, incoming);
      for (std::size_t r = 0; r < rays.size(); ++r) {
        incoming[r].direct = estimates[r].value;
        incoming[r].bias = estimates[r].error;
      }
    } else {
      solutions[i].radiance(rays, incoming);
    }
    RadianceCounts counts;
    counts.rays = rays.size();
    return counts;
  };
  SamplerSettings sampling = built.session->plan().sampling;
  sampling.max_oversampling = setting.rays;
  sampling.samples = 0;
  sampling.seed = seed;
  const Rendered rendered = obscura::render(world, estimator, Camera(built.session->plan().camera), sampling, progress);
  StudyPicture result = picture_of(built, rendered);
  result.seconds.map = solved - before;
  result.seconds.image = now() - solved;
  if (with_error) {
    // The solver's own error and the scatter of the rays.
    Picture errors = result.picture;
    for (int b = 0; b < rendered.film.bands(); ++b) {
      const auto bias = rendered.film.values(b, Film::Value::bias), error = rendered.film.values(b, Film::Value::error);
      for (std::size_t p = 0; p < bias.size(); ++p)
        errors.bands[static_cast<std::size_t>(b)][p] = std::hypot(bias[p], error[p]);
    }
    result.errors = std::move(errors);
  }
  for (const OrdinatesSolution& solution : solutions)
    result.bytes.map = std::max(result.bytes.map, solver_bytes(solution, setting.order));
  return result;
}

}  // namespace obscura
