#include "scene/study/study_reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>

#include "octree/base/error.h"

namespace obscura {
namespace {

/// Of the time spent, what the reference gets; passes that its share is made of, and their time at least.
constexpr double kShare = 1.0 / 3;
constexpr double kPasses = 32;
constexpr double kShortPass_s = 0.3;
/// The share that it gets while its error is more than so much of the least measured.
constexpr double kPoor = 0.7, kPoorShare = 0.5;
/// It is worth more time than its share while its error is more than so much of the least measured.
constexpr double kWorthMore = 0.2;
/// Rays of a pixel in one of its passes.
constexpr int kMostRays = 64;
/// Its octree is this much finer than the scene's.
constexpr double kFinerOctree = 0.1;

}  // namespace

double ReferenceRuns::pass_s() const { return std::max(kShortPass_s, kShare * settings_.budget_s / kPasses); }

void ReferenceRuns::choose(const StudySearch& search) {
  const StudyTraits& traits = bench_.traits();
  const bool by_paths = !search.refused(&kPathTracer);
  setting_ = first_rung(traits, by_paths ? &kPathTracer : &kOrdinates);
  if (by_paths) {
    const StudySearch::Ladder& ladder = search.ladder(&kPathTracer);
    if (!ladder.rungs.empty()) {
      const StudyRun& last = study_.runs[static_cast<std::size_t>(ladder.rungs.back())];
      const double factor = std::clamp(pass_s() / std::max(last.seconds.image.wall, 1e-6), 1.0, 65536.0);
      setting_ = scaled(traits, last.setting, factor);
    }
    int& rays = setting_.rays;
    if (traits.scatters)
      rays = std::clamp(std::min(setting_.method.samples, kMostRays), rays, std::max(rays, kMostRays));
    if (traits.spectral) setting_.intervals = std::max(8, 2 * traits.most_intervals);
  } else {
    const StudyForecast forecast(study_.runs);
    for (const int cells : {16, 24, 32}) {
      StudySetting finer = setting_;
      finer.method.cells = cells;
      // Beside the finest solution there are coarser ones.
      if (cells == 16 || 2 * forecast.picture_s(finer) < kShare * settings_.budget_s) setting_.method.cells = cells;
    }
  }
  setting_.octree_tolerance = traits.given.octree_tolerance * kFinerOctree;
  setting_.everything = true;
  study_.reference.method = setting_.method.type->name;
}

bool ReferenceRuns::is_due(double spent_s) const {
  const StudyReference& reference = study_.reference;
  if (!reference.picture.known()) return true;
  double least = std::numeric_limits<double>::infinity();
  for (const StudyRun& run : study_.runs) least = std::min(least, run.error.error.value() + run.error.error.error());
  const bool poor = reference.error.value() > kPoor * std::max(least, kLeastStudyError);
  return reference.seconds.wall < (poor ? kPoorShare : kShare) * spent_s;
}

bool ReferenceRuns::is_worth_more() const {
  double least = std::numeric_limits<double>::infinity();
  for (const StudyRun& run : study_.runs) least = std::min(least, std::max(run.error.error.value(), kLeastStudyError));
  return by_paths() && study_.reference.error.value() > kWorthMore * least;
}

bool ReferenceRuns::pass(double left_s, const Progress& watch) {
  StudyReference& reference = study_.reference;
  if (!by_paths() && reference.picture.known()) return false;
  const double last_s = passes_ > 0 ? reference.seconds.wall / passes_ : 0;
  if (reference.picture.known() && last_s * kMisjudged > left_s) return false;
  const double cpu = settings_.clock.cpu_s(), wall = settings_.clock.wall_s();
  const std::uint64_t seed = study_seed(settings_, kReferenceSeeds + static_cast<std::uint64_t>(passes_));
  try {
    StudyPicture made = bench_.measure(setting_, seed, watch);
    if (watch.cancelled()) return false;
    if (by_paths()) {
      reference.picture.add(made.picture);
    } else {
      reference.picture = ReferencePicture(std::move(made.picture), std::move(*made.errors));
    }
  } catch (const ResourceError&) {
    if (watch.cancelled()) return false;
    throw;
  } catch (const NumericalError& error) {
    if (watch.cancelled()) return false;
    std::string why = "no referee serves the scene: ";
    for (const auto& [method, reason] : study_.refusals) why += fmt::format("{}: {}; ", method->name, reason);
    throw NumericalError("study", why + error.what());
  }
  ++passes_;
  reference.seconds.cpu += settings_.clock.cpu_s() - cpu;
  reference.seconds.wall += settings_.clock.wall_s() - wall;
  return true;
}

std::string ReferenceRuns::text() const {
  if (!by_paths()) {
    return fmt::format(
        "{} cells along the longest side, S{}, octree tolerance {:.4g}, errors as the solver states them",
        setting_.method.cells, setting_.method.order, setting_.octree_tolerance);
  }
  std::string text =
      fmt::format("{} independent passes of {} samples a pixel over at most {} rays, octree tolerance {:.4g}", passes_,
                  setting_.method.samples, setting_.rays, setting_.octree_tolerance);
  if (setting_.intervals > 0) text += fmt::format(", {} intervals a band", setting_.intervals);
  return text;
}

}  // namespace obscura
