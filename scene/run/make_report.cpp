#include "scene/run/make_report.h"

#include <fmt/format.h>

#include <cmath>

#include "octree/base/statistics.h"

namespace obscura {
namespace {

double total(const BatchTally& tally) { return pairwise_sum(tally); }

/// Batches are independent replicas of a sixteenth of the photons each: their sum has the variance of all.
double error_of(const BatchTally& tally) {
  Moments batches;
  for (const double value : tally) batches.add(value);
  return std::sqrt(kBatches * batches.variance());
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

std::string percent(double fraction) { return fmt::format("{:.3g} %", 100 * fraction); }

void add_accuracy(const Accuracy& made, Report& report) {
  AccuracyReport& to = report.accuracy.emplace();
  const bool kelvin = made.goal.target_error && made.goal.target_error->unit == ErrorUnit::kelvin;
  if (made.goal.target_error) to.target_error = made.goal.target_error->value;
  to.unit = kelvin ? "K" : "fraction";
  to.time_limit_s = made.goal.time_limit_s;
  to.error = made.error;
  to.interval = {made.low, made.high};
  to.noise = made.noise;
  to.bias = made.bias;
  to.dropped = made.dropped;
  to.reached = made.reached();
  to.ended = made.ended;
  to.method = made.recipe.method.type->name;
  to.photons = made.recipe.method.type->photons ? made.recipe.method.photons : 0;
  to.samples = made.recipe.method.samples;
  to.passes = made.passes;
  for (const PilotTrial& trial : made.trials)
    to.trials.push_back({trial.recipe.text(), trial.seconds, trial.predicted_s, trial.predicted_error});
  if (!made.goal.target_error || to.reached) return;
  const auto told = [&](double error) { return kelvin ? fmt::format("{:.3g} K", error) : percent(error); };
  std::string warning = "target_error " + told(*to.target_error);
  warning += (kelvin ? " was not reached: 95 % of the pixels are within " : " was not reached: the image error is ") +
             told(made.error) + " (95 %: " + told(made.low) + " to " + told(made.high) + "); ";
  if (made.ended == "bias") warning += "the bias of method " + to.method + ", " + told(made.bias) + ", does not let it";
  if (made.ended == "time") warning += "time_limit_s came first";
  if (made.ended == "cancelled") warning += "the run was stopped";
  report.warnings.push_back(std::move(warning));
}

}  // namespace

Report make_report(Session& session, const AccurateImage& made) {
  const Description& scene = session.scene();
  const Plan& plan = session.plan();
  const Light& light = made.light;
  const Rendered& rendered = made.rendered;
  Report report;
  report.version = OBSCURA_VERSION;
  report.scene = scene.name;
  report.hash = scene.hash;
  report.seed = scene.render.seed;
  report.plan = plan.effects;
  report.budget = plan.budget;
  report.method = {std::string(made.method.type->word), std::string(plan.choice.cheaper->word), plan.choice.reason};
  for (std::size_t b = 0; b < light.bands.size(); ++b) {
    const EnergyTally& energy = light.bands[b].energy;
    report.energy.push_back({session.world().bands()[b].name(),
                             {total(energy.emitted),
                              total(energy.absorbed),
                              total(energy.surface),
                              total(energy.escaped),
                              total(energy.truncated),
                              {error_of(energy.emitted), error_of(energy.absorbed), error_of(energy.surface),
                               error_of(energy.escaped), error_of(energy.truncated)}}});
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
  report.warnings = scene.warnings;
  report.warnings.insert(report.warnings.end(), plan.warnings.begin(), plan.warnings.end());
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
  for (int b = 0; b < rendered.film.bands(); ++b) {
    if (const std::uint64_t dark = rendered.film.too_dark(b); dark > 0) {
      report.warnings.push_back(
          fmt::format("{} pixels of band \"{}\" are darker than an image can hold, {:.2g} W/m2/sr: they have radiance "
                      "and temperature 0, and that error",
                      dark, session.world().bands()[static_cast<std::size_t>(b)].name(), Film::kLeast));
    }
  }
  report.partial = light.partial || rendered.film.partial();
  if (!made.accuracy.ended.empty()) add_accuracy(made.accuracy, report);
  return report;
}

}  // namespace obscura
