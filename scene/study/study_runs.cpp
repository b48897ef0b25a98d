// A study's loop: the reference and the runs that tell most for their time take turns, so that a stop leaves the best
// answer.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>

#include "scene/study/study_reference.h"
#include "scene/study/study_search.h"

namespace obscura {
namespace {

class Runs {
 public:
  Runs(StudyBench& bench, const StudySettings& settings, const Progress& progress)
      : bench_(bench),
        settings_(settings),
        outer_(progress),
        begin_s_(settings.clock.wall_s()),
        study_(described(bench, settings)),
        search_(study_, bench.traits()),
        reference_(study_, bench, settings) {
    const double late_s = begin_s_ + settings.budget_s * 1.03 + 1;
    watch_ = Progress(
        [this, late_s](std::string_view, std::uint64_t, std::uint64_t) {
          if (outer_.cancelled() || settings_.clock.wall_s() > late_s) stop_ = true;
          report();
        },
        &stop_);
  }

  Study run() {
    try_lowest_rungs();
    reference_.choose(search_);
    while (!stopped()) {
      evaluate(study_);
      if (reference_.is_due(spent_s()) && reference_pass()) continue;
      std::vector<StudyJob> jobs = search_.find_jobs();
      const auto cost = [](const StudyJob& job) { return job.predicted_s / job.worth; };
      std::stable_sort(jobs.begin(), jobs.end(),
                       [&](const StudyJob& a, const StudyJob& b) { return cost(a) < cost(b); });
      const auto fits = std::find_if(jobs.begin(), jobs.end(),
                                     [&](const StudyJob& job) { return job.predicted_s * kMisjudged <= left_s(); });
      if (fits != jobs.end()) {
        run_job(*fits);
      } else if (!(reference_.is_worth_more() && reference_pass())) {
        search_.leave_out(jobs, left_s());
        break;
      }
    }
    if (stopped()) {
      evaluate(study_);
      search_.leave_out(search_.find_jobs(), left_s());
    }
    study_.partial = outer_.cancelled();
    study_.spent_s = spent_s();
    study_.reference.what = reference_.text();
    if (study_.reference.picture.known()) evaluate(study_);
    return std::move(study_);
  }

 private:
  static Study described(const StudyBench& bench, const StudySettings& settings) {
    Study study = bench.describe();
    study.budget_s = settings.budget_s;
    return study;
  }

  double spent_s() const { return settings_.clock.wall_s() - begin_s_; }
  double left_s() const { return settings_.budget_s - spent_s(); }
  bool stopped() {
    if (outer_.cancelled() || left_s() <= 0) stop_ = true;
    return stop_;
  }
  void report() const {
    const double share = std::clamp(spent_s() / settings_.budget_s, 0.0, 1.0);
    outer_.report("study", static_cast<std::uint64_t>(share * 1000), 1000);
  }

  /// What the lowest rungs of the referee's method cost here.
  void try_lowest_rungs() {
    // Threads and caches get warm.
    if (!stopped()) run_job({{{first_rung(bench_.traits(), &kPathTracer), kWarmUp}}, 0, 1});
    climb(&kPathTracer, reference_.pass_s());
    if (search_.refused(&kPathTracer)) climb(&kOrdinates, kInfinity);
  }

  /// The first rungs, until a picture takes so long.
  void climb(const MethodType* method, double most_s) {
    const StudySearch::Ladder& ladder = search_.ladder(method);
    const auto last_s = [&] { return study_.runs[static_cast<std::size_t>(ladder.rungs.back())].seconds.image.wall; };
    while (!stopped() && ladder.ended.empty() && ladder.rungs.size() < StudySearch::kRungsFirst &&
           (ladder.rungs.empty() || last_s() < most_s)) {
      run_job({{{ladder.next, kLadder}}, 0, 1});
    }
  }

  bool reference_pass() {
    const bool made = reference_.pass(left_s(), watch_);
    if (made) report();
    return made;
  }

  void run_job(const StudyJob& job) {
    std::vector<std::vector<StudyPicture>> made(job.parts.size());
    for (int picture = 0; picture < kStudyPictures; ++picture) {
      for (std::size_t p = 0; p < job.parts.size(); ++p) {
        const StudySetting& setting = job.parts[p].setting;
        if (search_.failed(setting)) continue;
        try {
          const std::uint64_t seed = study_seed(settings_, static_cast<std::uint64_t>(picture));
          made[p].push_back(bench_.measure(setting, seed, watch_));
        } catch (const std::exception& error) {
          if (stopped_within()) return;
          search_.fail(job.parts[p], error);
        }
        if (stopped_within()) return;
        report();
      }
    }
    if (job.parts.front().purpose == kWarmUp) return;
    for (std::size_t p = 0; p < job.parts.size(); ++p) {
      if (!search_.failed(job.parts[p].setting)) add_run(job.parts[p], std::move(made[p]));
    }
    search_.finish(job);
  }

  /// A picture that was stopped is no picture.
  bool stopped_within() const { return stop_ || outer_.cancelled(); }

  void add_run(const StudyJob::Part& part, std::vector<StudyPicture> made) {
    StudyRun run;
    run.setting = part.setting;
    run.purpose = part.purpose;
    run.base = part.base;
    const double share = 1.0 / static_cast<double>(made.size());
    for (StudyPicture& picture : made) {
      const auto add = [&](StudySeconds::Stage& to, const StudySeconds::Stage& from) {
        to.cpu += share * from.cpu, to.wall += share * from.wall;
      };
      add(run.seconds.world, picture.seconds.world);
      add(run.seconds.map, picture.seconds.map);
      add(run.seconds.image, picture.seconds.image);
      run.bytes = picture.bytes;
      run.peak_MiB = picture.peak_MiB;
      run.pictures.push_back(std::move(picture.picture));
    }
    const double ratio = study_.pixel_ratio();
    run.full = run.seconds;
    run.full.image.cpu *= ratio;
    run.full.image.wall *= ratio;
    run.full_bytes = run.bytes;
    run.full_bytes.film *= ratio;
    study_.runs.push_back(std::move(run));
    search_.add_run(part);
    if (study_.reference.picture.known()) evaluate(study_);
    tell(study_.runs.back());
  }

  void tell(const StudyRun& run) const {
    if (!settings_.tell) return;
    const RootError& error = run.error.error;
    settings_.tell(fmt::format("[{:5.0f} s] {}: {}, {:.2f} s CPU", spent_s(), study_label(run.setting),
                               study_.reference.picture.known()
                                   ? fmt::format("{:.2f} +- {:.2f} %", 100 * error.value(), 100 * error.error())
                                   : std::string("error not known yet"),
                               run.seconds.cpu()));
  }

  StudyBench& bench_;
  const StudySettings& settings_;
  const Progress& outer_;
  Progress watch_;
  std::atomic<bool> stop_{false};
  double begin_s_;
  Study study_;
  StudySearch search_;
  ReferenceRuns reference_;
};

}  // namespace

Study run_study(StudyBench& bench, const StudySettings& settings, const Progress& progress) {
  return Runs(bench, settings, progress).run();
}

Study run_study(const Description& scene, const StudySettings& settings, const Progress& progress) {
  const double begin_s = settings.clock.wall_s();
  SessionBench bench(scene, settings.pixels, settings.clock, progress);
  StudySettings rest = settings;
  rest.budget_s = std::max(0.0, settings.budget_s - (settings.clock.wall_s() - begin_s));
  Study study = run_study(bench, rest, progress);
  study.budget_s = settings.budget_s;
  study.spent_s = settings.clock.wall_s() - begin_s;
  return study;
}

}  // namespace obscura
