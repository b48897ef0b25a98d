#include "scene/study/study_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <optional>

#include "octree/base/error.h"

namespace obscura {
namespace {

/// A ladder ends where two rungs in a row have not lowered the error to this share of the one before.
constexpr double kStillImproves = 0.85;
/// A changed knob is taken where it makes error^2 x time this much smaller.
constexpr double kWorthTaking = 0.85;
/// Of the budget, what a method's other knobs may take at a time.
constexpr double kVariationsShare = 0.12;
/// Error above which other knobs wait for a higher rung.
constexpr double kTooMuchNoise = 0.2;
/// An interpolated setting is tried where it would take less than this share of the best one's time.
constexpr double kWorthTrying = 0.75;
/// Relative error above which an error says too little to find settings by it.
constexpr double kTold = 0.35;
/// Share of a rung's step within which a setting is that rung.
constexpr double kSameRung = 0.1;
/// Most interpolated settings for one target.
constexpr int kTriesPerTarget = 2;
/// Of the budget, what a single run of ordinates may take before others wait no more.
constexpr double kOtherShare = 0.03;
/// How much more useful a method's first rung is than others of its time.
constexpr double kWorthOfFirst = 50;
/// How much a job of a method that is far from the best may be put back.
constexpr double kLeastWorth = 0.1;

std::string purpose_of_target(double error) { return fmt::format("target {:.4g} %", 100 * error); }

}  // namespace

StudySearch::StudySearch(Study& study, const StudyTraits& traits)
    : study_(study), traits_(traits), forecast_(study.runs) {
  for (const MethodType* method : methods()) ladders_[method].next = first_rung(traits, method);
  if (!traits.scatters)
    refuse(&kFinalGather, "nothing scatters or reflects: there is nothing to gather");
  else if (traits.depth_limited)
    refuse(&kFinalGather,
           "scattering_depth is set: photons of the map may have scattered that often before the bounce");
}

bool StudySearch::refused(const MethodType* method) const {
  return std::any_of(study_.refusals.begin(), study_.refusals.end(), [&](const auto& r) { return r.first == method; });
}

bool StudySearch::failed(const StudySetting& setting) const {
  return std::find(failed_.begin(), failed_.end(), setting) != failed_.end();
}

int StudySearch::find(const StudySetting& setting) const {
  for (std::size_t r = 0; r < study_.runs.size(); ++r) {
    if (study_.runs[r].setting == setting) return static_cast<int>(r);
  }
  return -1;
}

StudySetting StudySearch::given() const {
  StudySetting s = first_rung(traits_, traits_.given.method.type);
  s.rays = traits_.given.rays;
  if (s.method.photons > 0)
    s.method.photons = traits_.given.method.photons, s.method.nearest = traits_.given.method.nearest;
  if (s.method.samples > 0) s.method.samples = traits_.given.method.samples;
  return s;
}

void StudySearch::refuse(const MethodType* method, const std::string& why) {
  const std::string own = std::string(method->name) + ": ";
  study_.refusals.emplace_back(method, why.starts_with(own) ? why.substr(own.size()) : why);
  ladders_[method].ended = why;
}

StudyJob StudySearch::job_of(std::vector<StudyJob::Part> parts, double worth) const {
  StudyJob job{std::move(parts), 0, worth};
  double map = 0;
  std::vector<StudySetting> worlds;
  for (const StudyJob::Part& part : job.parts) {
    job.predicted_s += kStudyPictures * forecast_.picture_s(part.setting);
    if (std::none_of(worlds.begin(), worlds.end(),
                     [&](const StudySetting& w) { return same_world(w, part.setting); })) {
      job.predicted_s += forecast_.world_s(part.setting);
      worlds.push_back(part.setting);
    }
    const StudyRun* run = forecast_.nearest_run(part.setting);
    // The parts of a job share their maps.
    if (run && run->seconds.map.wall > 0 && part.setting.method.type != &kOrdinates) {
      const double own = kStudyPictures * run->seconds.map.wall * work_of(part.setting).map / work_of(run->setting).map;
      if (map > 0) job.predicted_s -= own;
      map = own;
    }
  }
  return job;
}

bool StudySearch::improves(const Ladder& ladder) const {
  const std::size_t n = ladder.rungs.size();
  if (n == 0) return true;
  const auto error = [&](std::size_t back) { return run_at(ladder.rungs[n - back]).error.error.value(); };
  if (error(1) < kLeastStudyError) return false;
  if (n < 3) return true;
  return error(1) < kStillImproves * error(2) || error(2) < kStillImproves * error(3);
}

/// Rungs that were measured for another purpose.
void StudySearch::climb(Ladder& ladder) {
  for (int run = find(ladder.next); run >= 0 && ladder.ended.empty() && improves(ladder); run = find(ladder.next)) {
    if (std::find(ladder.rungs.begin(), ladder.rungs.end(), run) != ladder.rungs.end()) return;
    StudyRun& rung = study_.runs[static_cast<std::size_t>(run)];
    rung.purpose = kLadder;
    rung.base = -1;
    ladder.rungs.push_back(run);
    ladder.next = scaled(traits_, rung.setting, kRung);
  }
}

/// The other knobs, first around the best rung that leaves time for others; once more around the last best one.
void StudySearch::vary(const Ladder& ladder, bool up, std::vector<StudyJob>& jobs) const {
  if (ladder.varying >= 0) return add_variations(ladder, ladder.varying, jobs);
  if (up && !ladder.varied.empty()) return;
  const int best = best_rung(ladder);
  for (auto rung = ladder.rungs.rbegin(); rung != ladder.rungs.rend(); ++rung) {
    if (*rung > best) continue;
    // Where errors are huge, small ones cannot be seen.
    if (up && run_at(*rung).error.error.value() > kTooMuchNoise) return;
    if (ladder.varied.contains(*rung)) return;
    std::vector<StudyJob> around;
    add_variations(ladder, *rung, around);
    double all_s = 0;
    for (const StudyJob& job : around) all_s += job.predicted_s;
    if (all_s > kVariationsShare * study_.budget_s && *rung != ladder.rungs.front()) continue;
    jobs.insert(jobs.end(), around.begin(), around.end());
    return;
  }
}

/// The other knobs around a run. Those that only gather otherwise share its map.
void StudySearch::add_variations(const Ladder& ladder, int base, std::vector<StudyJob>& jobs) const {
  if (ladder.varied.contains(base)) return;
  std::vector<StudyJob::Part> shared;
  for (const StudyVariation& v : variations(traits_, run_at(base).setting)) {
    if (measured(v.setting)) continue;
    const StudyJob::Part part{v.setting, v.knob, base};
    const bool shares = v.setting.method.photons > 0 &&
                        v.setting.method.photons == run_at(base).setting.method.photons &&
                        same_world(v.setting, run_at(base).setting);
    if (shares) {
      shared.push_back(part);
    } else {
      jobs.push_back(job_of({part}, 0.7));
    }
  }
  if (!shared.empty()) jobs.push_back(job_of(std::move(shared), 2));
}

std::vector<StudyJob> StudySearch::find_jobs() {
  std::vector<StudyJob> jobs;
  for (const MethodType* method : methods()) {
    Ladder& ladder = ladders_.at(method);
    if (refused(method)) continue;
    climb(ladder);
    const bool up = ladder.ended.empty() && improves(ladder);
    if (up && !measured(ladder.next))
      jobs.push_back(job_of({{ladder.next, kLadder}}, ladder.rungs.empty() ? kWorthOfFirst : 1));
    if (ladder.rungs.size() >= kRungsFirst || (!up && !ladder.rungs.empty())) vary(ladder, up, jobs);
  }
  if (!refused(traits_.given.method.type) && !measured(given())) jobs.push_back(job_of({{given(), "scene"}}, 2));
  add_targets(jobs);
  let_poor_methods_wait(jobs);
  return jobs;
}

/// A method that is far from the best one's efficiency waits.
void StudySearch::let_poor_methods_wait(std::vector<StudyJob>& jobs) const {
  double best = std::numeric_limits<double>::infinity();
  for (const auto& [method, ladder] : ladders_) best = renders(method) ? std::min(best, efficiency(ladder)) : best;
  for (StudyJob& job : jobs) {
    const MethodType* method = job.parts.front().setting.method.type;
    // What cannot render is there to compare with.
    if (!renders(method) && job.predicted_s > kOtherShare * study_.budget_s) job.worth *= kLeastWorth;
    const double own = efficiency(ladders_.at(method));
    if (std::isfinite(own) && own > 0) job.worth *= std::clamp(best / own, kLeastWorth, 1.0);
  }
}

double StudySearch::efficiency(const Ladder& ladder) const {
  return ladder.rungs.empty() ? std::numeric_limits<double>::infinity() : error2_time(best_rung(ladder));
}

/// The rung with the least error^2 x time.
int StudySearch::best_rung(const Ladder& ladder) const {
  int best = ladder.rungs.front();
  for (const int r : ladder.rungs) {
    if (error2_time(r) <= error2_time(best)) best = r;
  }
  return best;
}

double StudySearch::error2_time(int run) const {
  const double error = std::max(run_at(run).error.error.value(), run_at(run).error.error.error());
  return error * error * run_at(run).full.cpu();
}

/// Settings between two rungs, that should just reach a target.
void StudySearch::add_targets(std::vector<StudyJob>& jobs) const {
  for (const StudyTarget& target : study_.targets) {
    if (tries_.contains(target.error) && tries_.at(target.error) >= kTriesPerTarget) continue;
    const double known = target.run >= 0 ? run_at(target.run).full.cpu() : std::numeric_limits<double>::infinity();
    std::optional<StudySetting> best;
    double least = kWorthTrying * known;
    for (const auto& [method, ladder] : ladders_) {
      if (!renders(method)) continue;
      for (std::size_t k = 1; k < ladder.rungs.size(); ++k) {
        const StudyRun &low = run_at(ladder.rungs[k - 1]), &high = run_at(ladder.rungs[k]);
        // With its standard error it is to be below the target.
        const RootError& upper = high.error.error;
        const double aim = 0.95 * target.error / (1 + upper.error() / std::max(upper.value(), 1e-12)),
                     from = low.error.error.value(), to = high.error.error.value();
        if (!(from > aim && to < aim && to > 0)) continue;
        if (low.error.error.error() > kTold * from || high.error.error.error() > kTold * to) continue;
        // From the upper rung down: it has the knobs that were found since.
        const double share = std::log(aim / to) / std::log(from / to);
        if (share < kSameRung || share > 1 - kSameRung) continue;
        const StudySetting setting = scaled(traits_, high.setting, std::pow(kRung, -share));
        const double cpu = forecast_.full_cpu_s(setting);
        if (cpu < least && !measured(setting)) least = cpu, best = setting;
      }
    }
    if (best) jobs.push_back(job_of({{*best, purpose_of_target(target.error)}}, 1.5));
  }
}

void StudySearch::add_run(const StudyJob::Part& part) {
  const int run = static_cast<int>(study_.runs.size()) - 1;
  if (part.setting == given()) study_.as_given = run;
  if (part.purpose == kLadder) ladders_.at(part.setting.method.type).rungs.push_back(run);
}

void StudySearch::fail(const StudyJob::Part& part, const std::exception& error) {
  failed_.push_back(part.setting);
  const bool known = dynamic_cast<const NumericalError*>(&error) || dynamic_cast<const InputError*>(&error) ||
                     dynamic_cast<const ResourceError*>(&error) || dynamic_cast<const std::bad_alloc*>(&error);
  if (!known) throw;
  Ladder& ladder = ladders_.at(part.setting.method.type);
  if (part.purpose != kLadder && part.purpose != kWarmUp) {
    study_.left_out.push_back(fmt::format("{}: {}", study_label(part.setting), error.what()));
  } else if (ladder.rungs.empty()) {
    refuse(part.setting.method.type, error.what());
  } else {
    ladder.ended = error.what();
    study_.left_out.push_back(fmt::format("{}: {}", study_label(part.setting), error.what()));
  }
}

void StudySearch::finish(const StudyJob& job) {
  for (const StudyJob::Part& part : job.parts) {
    if (part.purpose.starts_with("target")) {
      for (const double target : kStudyTargets) tries_[target] += part.purpose == purpose_of_target(target) ? 1 : 0;
    }
  }
  const StudyJob::Part& first = job.parts.front();
  Ladder& ladder = ladders_.at(first.setting.method.type);
  if (first.purpose == kLadder && !failed(first.setting)) ladder.next = scaled(traits_, first.setting, kRung);
  if (first.base < 0 || !study_.reference.picture.known()) return;
  take_best_knob(job, ladder);
  std::vector<StudyJob> open;
  add_variations(ladder, first.base, open);
  ladder.varying = open.empty() ? -1 : first.base;
  if (open.empty()) ladder.varied.insert(first.base);
}

/// The best value of the knob, where it is worth taking, goes into the next rung.
void StudySearch::take_best_knob(const StudyJob& job, Ladder& ladder) {
  const int base = job.parts.front().base;
  for (const StudyJob::Part& part : job.parts) {
    const int run = find(part.setting);
    if (run < 0) continue;
    double& best = taken_[{base, part.purpose}];
    if (best == 0) best = kWorthTaking * error2_time(base);
    // With its standard error: luck is not worth taking.
    const RootError& error = run_at(run).error.error;
    const double sure = std::pow(error.value() + error.error(), 2) * run_at(run).full.cpu();
    if (sure < best) {
      best = sure;
      ladder.next = with_knob(ladder.next, part.purpose, run_at(base).setting, part.setting);
    }
  }
}

void StudySearch::leave_out(const std::vector<StudyJob>& jobs, double left_s) {
  for (const StudyJob& job : jobs) {
    if (job.parts.size() == 1) {
      study_.left_out.push_back(fmt::format("{}: about {:.0f} s, when {:.0f} s were left",
                                            study_label(job.parts.front().setting), job.predicted_s,
                                            std::max(0.0, left_s)));
    } else {
      study_.left_out.push_back(fmt::format("{} other settings around {}: about {:.0f} s, when {:.0f} s were left",
                                            job.parts.size(), study_label(run_at(job.parts.front().base).setting),
                                            job.predicted_s, std::max(0.0, left_s)));
    }
  }
}

}  // namespace obscura
