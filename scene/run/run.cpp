#include "scene/run/run.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "scene/run/make_report.h"
#include "scene/run/origin.h"
#include "scene/run/places.h"
#include "scene/run/stages.h"

namespace obscura {
namespace {

/// As the scene's settings say, or to its goal.
AccurateImage make_image(Session& session, Stages& stages, const Progress& progress) {
  const RenderDescription& render = session.scene().render;
  if (render.target_error || render.time_limit_s) {
    const AccuracyGoal goal{render.target_error, render.time_limit_s, session.plan().budget.dropped};
    AccurateImage made = render_to_goal(
        session, goal, [&stages] { return stages.since_begin(); }, progress);
    stages.end(made.accuracy);
    return made;
  }
  const Method& method = session.plan().method;
  const Estimator estimator = session.estimator(method, render.seed, progress);
  Light light;
  if (estimator.light) light.add_tallies(*estimator.light);
  stages.end("photons");
  Rendered rendered = session.render(progress);
  stages.end("image");
  return {std::move(rendered), method, render.seed, std::move(light), {}};
}

/// Where a run has chosen its method itself, some photons tell where power goes whatever it has chosen.
void tell_balance(Session& session, AccurateImage& made, const Progress& progress) {
  const bool photons = made.method.type->photons || session.scene().render.method.empty();
  if (!photons || made.light.emitted > 0 || progress.cancelled()) return;
  EstimatorSettings settings = session.plan().estimator;
  settings.again = false;
  settings.rectangles.clear();
  const Estimator balance = make_estimator(session.world(), method_of(session.scene(), kPhotonMap), settings, progress);
  made.light.add_tallies(*balance.light);
}

/// Where the image's method does not know powers through rectangles.
void flux_by_paths(Session& session, const AccurateImage& made, const Progress& progress, Report& report) {
  const Method paths = method_of(session.scene(), kPathTracer);
  const std::string without = std::string("flux: method ") + made.method.type->word + " does not know it: ";
  if (const auto refusal = unfit(session.world(), paths, session.plan().estimator)) {
    report.warnings.push_back(without + "it is left out, since paths cannot find it: " + refusal->what());
    return;
  }
  report.flux = fluxes(session, session.estimator(paths, made.seed, progress));
  report.warnings.push_back(without + "it was found by paths");
}

/// The detector's channels, beside those that stay as they are.
void add_detector(Session& session, double time_s, RunResult& result) {
  const Description& scene = session.scene();
  for (const DetectorTally& t :
       detect(result.image, session.world().bands(), scene.sensor.detector, {scene.render.seed, time_s})) {
    result.report.detector.push_back({t.band, {t.dead, t.above, t.below}});
    if (t.above + t.below == 0) continue;
    result.report.warnings.push_back("the detector's range cuts " + std::to_string(t.above) + " pixels above and " +
                                     std::to_string(t.below) + " below in band \"" + t.band + "\"");
  }
}

/// Why the numbers cannot be trusted: too many values that should never be.
std::optional<std::string> failure_of(const Report& report, const AccurateImage& made) {
  std::uint64_t anomalies = 0;
  for (const auto& [kind, count] : report.anomalies) anomalies += count;
  const RadianceCounts& counts = made.rendered.counts;
  const std::uint64_t done = made.light.emitted + counts.rays + counts.work[Work::scattering];
  if (static_cast<double>(anomalies) <= 1e-6 * static_cast<double>(done)) return std::nullopt;
  return std::to_string(anomalies) + " impossible values in " + std::to_string(done) +
         " rays and photons: more than one in a million";
}

}  // namespace

RunResult run_scene(const Description& scene, const RunOptions& options, const Progress& progress) {
  const auto threads =
      static_cast<std::size_t>(options.threads > 0 ? options.threads : tbb::this_task_arena::max_concurrency());
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  const double time_s = options.time_s.value_or(scene.time_s);
  Stages stages;

  Session session(scene, time_s, progress);
  stages.end("world");
  AccurateImage made = make_image(session, stages, progress);
  tell_balance(session, made, progress);
  Report report = make_report(session, made);
  if (!progress.cancelled()) {
    const Estimator estimator = session.estimator(made.method, made.seed, progress);
    report.flux = made.method.type->photons ? fluxes(session, made.light) : fluxes(session, estimator);
    if (report.flux.empty() && !scene.flux.empty()) flux_by_paths(session, made, progress, report);
    report.probes = probe(session, made.method, estimator);
  }
  stages.end("report");

  const ImageOrigin origin = origin_of(session, made.method, made.rendered.counts, scene.render.seed, time_s);
  RunResult result{develop(made.rendered.film, session.world().bands(), origin), std::move(report), {}};
  add_detector(session, time_s, result);
  if (result.report.partial) result.image.metadata["obscura:partial"] = 1;
  result.report.time_s = stages.take();
  result.report.peak_MiB = peak_memory_MiB();
  result.failure = failure_of(result.report, made);
  return result;
}

}  // namespace obscura
