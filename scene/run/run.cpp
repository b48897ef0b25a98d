#include "scene/run/run.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <chrono>

#include "photon/paths/fluence.h"
#include "photon/paths/path_tracer.h"
#include "scene/goal/accuracy.h"
#include "scene/session/session.h"

namespace obscura {
namespace {

/// Directions of a probe's fluence.
constexpr int kProbeDirections = 8192;
/// Paths a side of a flux rectangle.
constexpr int kFluxPaths = 65536;

class Stages {
 public:
  /// Seconds since the last stage ended.
  void end(const char* stage) {
    const double now = since_begin();
    seconds_.emplace_back(stage, now - last_);
    last_ = now;
  }
  /// The stages of an image in passes, each of which is many stretches of time.
  void end(const Accuracy& accuracy) {
    for (const auto& [stage, seconds] :
         {std::pair("pilot", accuracy.pilot_s), {"photons", accuracy.photons_s}, {"image", accuracy.image_s}}) {
      seconds_.emplace_back(stage, seconds);
    }
    last_ = since_begin();
  }
  double since_begin() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }
  std::vector<std::pair<std::string, double>> take() { return std::move(seconds_); }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  double last_ = 0;
  std::vector<std::pair<std::string, double>> seconds_;
};

double total(const BatchTally& tally) { return pairwise_sum(tally); }

std::vector<ProbeReport> probe(Session& session) {
  const World& world = session.world();
  const Light& light = session.light();
  std::vector<ProbeReport> reports;
  std::uint64_t history = 0;
  for (const ProbeDescription& wish : session.scene().probes) {
    ProbeReport& report = reports.emplace_back();
    report.name = wish.name;
    for (const Band& band : world.bands()) report.bands.push_back({band.name(), {}});
    for (int i = 0; i < world.interval_count(); ++i) {
      FluenceReport& sum = report.bands[static_cast<std::size_t>(world.interval(i).band)].second;
      const PhotonMaps* maps = light.maps.empty() ? nullptr : &light.maps[static_cast<std::size_t>(i)];
      const BatchMean here =
          fluence(world, i, maps, session.plan().radiance, wish.position_m, kProbeDirections, history);
      sum.fluence += here.mean;
      sum.error = std::hypot(sum.error, here.standard_error);
    }
    ++history;
  }
  return reports;
}

std::vector<FluxReport> flux_by_paths(const Session& session) {
  const World& world = session.world();
  const RadianceSettings& radiance = session.plan().radiance;
  PathSettings settings;
  settings.specular_depth = radiance.specular_depth;
  settings.scattering_depth = radiance.scattering_depth;
  settings.seed = radiance.seed;
  std::vector<FluxReport> reports;
  for (std::size_t r = 0; r < session.rectangles().size(); ++r) {
    FluxReport& report = reports.emplace_back();
    report.name = session.scene().flux[r].name;
    for (const Band& band : world.bands()) report.bands.push_back({band.name(), {}});
    for (int i = 0; i < world.interval_count(); ++i) {
      CrossingReport& sum = report.bands[static_cast<std::size_t>(world.interval(i).band)].second;
      const PathFlux power = path_flux(world, i, settings, session.rectangles()[r], kFluxPaths, r);
      sum.forward += power.forward.mean;
      sum.backward += power.backward.mean;
      sum.error = std::hypot(sum.error, std::hypot(power.forward.standard_error, power.backward.standard_error));
    }
  }
  return reports;
}

std::vector<FluxReport> flux_of(const Session& session, const Light& light) {
  if (light.bands.empty()) return flux_by_paths(session);
  std::vector<FluxReport> reports;
  for (std::size_t r = 0; r < session.rectangles().size(); ++r) {
    FluxReport& report = reports.emplace_back();
    report.name = session.scene().flux[r].name;
    for (std::size_t b = 0; b < light.bands.size(); ++b) {
      const FluxTally& tally = light.bands[b].flux[r];
      // The error is that of the net power: batches are shares of the whole.
      BatchTally net;
      for (std::size_t k = 0; k < net.size(); ++k) net[k] = kBatches * (tally.forward[k] - tally.backward[k]);
      report.bands.push_back({session.world().bands()[b].name(),
                              {total(tally.forward), total(tally.backward), batch_mean(net).standard_error}});
    }
  }
  return reports;
}

/// Rays that were averaged by what asked for them, and those that decided.
std::vector<std::pair<std::string, std::uint64_t>> ray_report(const RayCounts& rays) {
  std::vector<std::pair<std::string, std::uint64_t>> report = {{"base", rays.base}, {"deciding", rays.deciding}};
  for (int c = 0; c < kCriteria; ++c) {
    const auto criterion = static_cast<Criterion>(c);
    if (criterion != Criterion::none) report.emplace_back(name(criterion), rays.asked[static_cast<std::size_t>(c)]);
  }
  return report;
}

Report make_report(const Description& scene, const Session& session, const Light& light, const Rendered& rendered) {
  Report report;
  report.version = OBSCURA_VERSION;
  report.scene = scene.name;
  report.hash = scene.hash;
  report.seed = scene.render.seed;
  report.plan = session.plan().effects;
  report.budget = session.plan().budget;
  report.method = {session.scene().render.method == MethodKind::path ? "path" : "photon",
                   session.plan().method.cheaper == MethodKind::path ? "path" : "photon", session.plan().method.reason};
  for (std::size_t b = 0; b < light.bands.size(); ++b) {
    const EnergyTally& energy = light.bands[b].energy;
    report.energy.push_back({session.world().bands()[b].name(),
                             {total(energy.emitted), total(energy.absorbed), total(energy.surface),
                              total(energy.escaped), total(energy.truncated)}});
  }
  report.photons = {light.emitted, light.stored, light.bytes};
  for (const OctreeRecord& octree : session.octrees()) {
    std::uint64_t leaves = 0;
    for (const std::uint64_t level : octree.statistics.leaves) leaves += level;
    report.octree.push_back({octree.name, leaves, octree.statistics.bytes, octree.statistics.bytes_dense,
                             octree.tolerance, octree.build.error_measured, octree.build.error_bound});
  }
  const FootprintCounts& footprint = rendered.counts.footprint;
  report.footprint = {footprint.rays, footprint.segments, footprint.coarse, footprint.voxels, footprint.error_bound};
  report.rays = ray_report(rendered.rays);
  WorkCounts work = light.work;
  work += rendered.counts.work;
  for (std::size_t w = 0; w < kWorkNames.size(); ++w) {
    report.work.emplace_back(kWorkNames[w], work[static_cast<Work>(w)]);
  }
  report.anomalies = {
      {"photons", light.anomalies}, {"radiance", rendered.counts.anomalies}, {"film", rendered.film.anomalies()}};
  report.flux = flux_of(session, light);
  report.warnings = scene.warnings;
  report.warnings.insert(report.warnings.end(), session.plan().warnings.begin(), session.plan().warnings.end());
  if (light.dropped_W > 0) {
    report.warnings.push_back("collisions of photons weaker than photon_power_min were not stored: " +
                              std::to_string(light.dropped_W) + " W of them");
  }
  for (const auto& [band, energy] : report.energy) {
    if (energy.truncated_W > 0 && scene.sensor.scattering_depth) {
      report.warnings.push_back("scattering_depth cuts off " + std::to_string(energy.truncated_W) + " W in band \"" +
                                band + "\": the image is too dark by at most that share of " +
                                std::to_string(energy.emitted_W) + " W");
    }
  }
  if (scene.render.directions == Directions::regular) {
    report.warnings.push_back(
        "directions are \"regular\": batches are no replicas, so the errors say nothing about photons");
  }
  report.partial = light.partial || rendered.film.partial();
  return report;
}

std::string percent(double fraction) { return fmt::format("{:.3g} %", 100 * fraction); }

void add_accuracy(const Accuracy& made, Report& report) {
  AccuracyReport& to = report.accuracy.emplace();
  to.target_error = made.goal.target_error;
  to.time_limit_s = made.goal.time_limit_s;
  to.error = made.error;
  to.interval = {made.low, made.high};
  to.noise = made.noise;
  to.bias = made.bias;
  to.dropped = made.goal.dropped;
  to.reached = made.reached();
  to.ended = made.ended;
  to.method = made.recipe.name();
  to.photons = made.recipe.method == MethodKind::path ? 0 : made.recipe.photons;
  to.samples = made.recipe.samples;
  to.passes = made.passes;
  for (const PilotTrial& trial : made.trials)
    to.trials.push_back({trial.recipe.text(), trial.seconds, trial.predicted_s, trial.predicted_error});
  if (!made.goal.target_error || to.reached) return;
  std::string warning = "target_error " + percent(*made.goal.target_error);
  warning += " was not reached: the image error is " + percent(made.error) + " (95 %: " + percent(made.low) + " to " +
             percent(made.high) + "); ";
  if (made.ended == "bias")
    warning += "the bias of method " + to.method + ", " + percent(made.bias) + ", does not let it";
  if (made.ended == "time") warning += "time_limit_s came first";
  if (made.ended == "cancelled") warning += "the run was stopped";
  report.warnings.push_back(std::move(warning));
}

ImageOrigin origin_of(const Description& scene, const Session& session, double time_s) {
  ImageOrigin origin;
  origin.camera = session.plan().camera;
  origin.seed = scene.render.seed;
  origin.scene_name = scene.name;
  origin.scene_hash = scene.hash;
  origin.method = session.scene().render.method == MethodKind::path ? "path" : "photon";
  origin.time_s = time_s;
  origin.has_bias = session.scene().render.method != MethodKind::path;
  origin.has_criterion = session.plan().sampling.adaptive.has_value();
  origin.has_atmosphere = session.has_atmosphere();
  origin.dropped_bound = session.plan().budget.dropped;
  return origin;
}

// The detector's channels, beside those that stay as they are.
void add_detector(const Session& session, double time_s, RunResult& result) {
  const Description& scene = session.scene();
  for (const DetectorTally& t :
       detect(result.image, session.world().bands(), scene.sensor.detector, {scene.render.seed, time_s})) {
    result.report.detector.push_back({t.band, {t.dead, t.above, t.below}});
    if (t.above + t.below == 0) continue;
    result.report.warnings.push_back("the detector's range cuts " + std::to_string(t.above) + " pixels above and " +
                                     std::to_string(t.below) + " below in band \"" + t.band + "\"");
  }
}

}  // namespace

namespace {

/// As the scene's settings say, or to its goal: the accuracy's end then is not empty.
AccurateImage make_image(Session& session, Stages& stages, const Progress& progress) {
  const RenderDescription& wish = session.scene().render;
  if (wish.target_error || wish.time_limit_s) {
    const AccuracyGoal goal{wish.target_error, wish.time_limit_s, session.plan().budget.dropped};
    AccurateImage made = render_to_goal(
        session, goal, [&stages] { return stages.since_begin(); }, progress);
    stages.end(made.accuracy);
    return made;
  }
  Light light;
  light.add_tallies(session.light(progress));
  stages.end("photons");
  Rendered rendered = session.render(progress);
  stages.end("image");
  return {std::move(rendered), std::move(light), {}};
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
  const AccurateImage made = make_image(session, stages, progress);
  const Light& light = made.light;
  const Rendered& rendered = made.rendered;
  Report report = make_report(scene, session, light, rendered);
  if (!made.accuracy.ended.empty()) add_accuracy(made.accuracy, report);
  if (!progress.cancelled()) report.probes = probe(session);
  stages.end("report");

  RunResult result{
      develop(rendered.film, session.world().bands(), origin_of(scene, session, time_s)), std::move(report), {}};
  add_detector(session, time_s, result);
  if (result.report.partial) result.image.metadata["obscura:partial"] = 1;
  result.report.time_s = stages.take();
  result.report.peak_MiB = peak_memory_MiB();
  std::uint64_t anomalies = 0;
  for (const auto& [kind, count] : result.report.anomalies) anomalies += count;
  const std::uint64_t work = light.emitted + rendered.counts.rays + rendered.counts.work[Work::scattering];
  if (static_cast<double>(anomalies) > 1e-6 * static_cast<double>(work)) {
    result.failure = std::to_string(anomalies) + " impossible values in " + std::to_string(work) +
                     " rays and photons: more than one in a million";
  }
  return result;
}

}  // namespace obscura
