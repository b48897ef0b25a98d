// The order of a study's runs: what is most useful for its time comes first, so that a stop leaves the best answer.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <new>
#include <set>

#include "octree/base/error.h"
#include "scene/study/study_bench.h"

namespace obscura {
namespace {

/// Pictures of a setting; bias and noise need two.
constexpr int kPictures = 2;
/// Of the time spent, what the reference gets; passes that its share is made of, and their time at least.
constexpr double kReferenceShare = 1.0 / 3;
constexpr double kReferencePasses = 32;
constexpr double kShortPass_s = 0.3;
/// The share that it gets while its error is more than so much of the least measured.
constexpr double kPoorReference = 0.7, kPoorReferenceShare = 0.5;
/// Rays of a pixel in one of its passes.
constexpr int kMostReferenceRays = 64;
/// The reference's octree is this much finer than the scene's.
constexpr double kFinerOctree = 0.1;
/// What a prediction may be wrong by: runs are started only where they fit with it.
constexpr double kMisjudged = 1.25;
/// A ladder ends where two rungs in a row have not lowered the error to this share of the one before.
constexpr double kStillImproves = 0.85;
/// A changed knob is taken where it makes error^2 x time this much smaller.
constexpr double kWorthTaking = 0.85;
/// Rungs before the other knobs are tried for the first time.
constexpr std::size_t kRungsFirst = 3;
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
/// Below this share of the lowest target no error is of interest.
constexpr double kFarBelow = 0.5;
/// Of the budget, what a single run of ordinates may take before others wait no more.
constexpr double kOtherShare = 0.03;
/// How much more useful a method's first rung is than others of its time.
constexpr double kWorthOfFirst = 50;
/// How much a job of a method that is far from the best may be put back.
constexpr double kLeastWorth = 0.1;
/// Settings that have not been predicted, in seconds.
constexpr double kUnknown_s = 1;

/// Runs one after the other on one map.
struct Job {
  struct Part {
    StudySetting setting;
    std::string purpose;
    int base = -1;
  };
  std::vector<Part> parts;
  double predicted_s = 0;  ///< wall time
  double worth = 1;        ///< how much more useful than a rung of the same time
};

class Runs {
 public:
  Runs(StudyBench& bench, const StudySettings& settings, const Progress& progress)
      : bench_(bench),
        settings_(settings),
        outer_(progress),
        begin_s_(settings.clock.wall_s()),
        study_(bench.describe()) {
    study_.budget_s = settings.budget_s;
    const double late_s = begin_s_ + settings.budget_s * 1.03 + 1;
    watch_ = Progress(
        [this, late_s](std::string_view, std::uint64_t, std::uint64_t) {
          if (outer_.cancelled() || settings_.clock.wall_s() > late_s) stop_ = true;
          report();
        },
        &stop_);
    for (const MethodType* method : methods()) {
      Ladder& ladder = ladders_[method];
      ladder.next = first_rung(bench.traits(), method);
    }
    if (!bench.traits().scatters)
      refuse(&kFinalGather, "nothing scatters or reflects: there is nothing to gather");
    else if (bench.traits().depth_limited)
      refuse(&kFinalGather,
             "scattering_depth is set: photons of the map may have scattered that often before the bounce");
  }

  Study run() {
    begin_reference();
    while (!stopped()) {
      evaluate(study_);
      if (reference_is_due() && reference_pass()) continue;
      std::vector<Job> jobs = find_jobs();
      const auto cost = [](const Job& job) { return job.predicted_s / job.worth; };
      std::stable_sort(jobs.begin(), jobs.end(), [&](const Job& a, const Job& b) { return cost(a) < cost(b); });
      const auto fits = std::find_if(jobs.begin(), jobs.end(),
                                     [&](const Job& job) { return job.predicted_s * kMisjudged <= left_s(); });
      if (fits != jobs.end()) {
        run_job(*fits);
      } else if (!(reference_is_worth_more() && reference_pass())) {
        tell_left_out(jobs);
        break;
      }
    }
    if (stopped()) {
      evaluate(study_);
      tell_left_out(find_jobs());
    }
    study_.partial = outer_.cancelled();
    study_.spent_s = spent_s();
    study_.reference.what = reference_text();
    if (study_.reference.picture.known()) evaluate(study_);
    return std::move(study_);
  }

 private:
  struct Ladder {
    StudySetting next;
    std::vector<int> rungs;  ///< runs
    int varying = -1;        ///< the run around which other knobs are being tried
    std::set<int> varied;    ///< runs around which they have been
    std::string ended;       ///< why there is no next rung; empty: there is
  };

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
  void tell(const std::string& line) const {
    if (settings_.tell) settings_.tell(line);
  }
  void refuse(const MethodType* method, const std::string& why) {
    const std::string own = std::string(method->name) + ": ";
    study_.refusals.emplace_back(method, why.starts_with(own) ? why.substr(own.size()) : why);
    ladders_[method].ended = why;
  }
  bool refused(const MethodType* method) const {
    return std::any_of(study_.refusals.begin(), study_.refusals.end(),
                       [&](const auto& r) { return r.first == method; });
  }
  std::uint64_t seed(int picture) const { return settings_.seed * 1000003 + static_cast<std::uint64_t>(picture); }
  std::uint64_t reference_seed(int pass) const {
    return settings_.seed * 1000003 + 500000 + static_cast<std::uint64_t>(pass);
  }

  // Predictions.

  const StudyRun* nearest_run(const StudySetting& setting) const {
    const StudyRun* best = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const StudyRun& run : study_.runs) {
      if (run.setting.method.type != setting.method.type) continue;
      const StudyWork a = work_of(run.setting), b = work_of(setting);
      const double far =
          std::abs(std::log((b.map + 1) / (a.map + 1))) + std::abs(std::log((b.image + 1) / (a.image + 1)));
      if (far < least) least = far, best = &run;
    }
    return best;
  }
  double world_s(const StudySetting& setting) const {
    for (const StudyRun& run : study_.runs) {
      if (same_world(run.setting, setting)) return 0;
    }
    return known_world_s_;
  }
  /// Wall time of one picture without its World.
  double predict_s(const StudySetting& setting) const {
    const StudyRun* run = nearest_run(setting);
    if (!run) return kUnknown_s;
    const StudyWork a = work_of(run->setting), b = work_of(setting);
    const double map = a.map > 0 ? run->seconds.map.wall * b.map / a.map : 0.0;
    return map + run->seconds.image.wall * b.image / a.image;
  }
  /// CPU time of the whole picture.
  double predict_full_cpu_s(const StudySetting& setting) const {
    const StudyRun* run = nearest_run(setting);
    if (!run) return std::numeric_limits<double>::infinity();
    const StudyWork a = work_of(run->setting), b = work_of(setting);
    return run->full.world.cpu + (a.map > 0 ? run->full.map.cpu * b.map / a.map : 0.0) +
           run->full.image.cpu * b.image / a.image;
  }

  // The reference.

  void begin_reference() {
    StudySetting& s = reference_setting_;
    const StudyTraits& traits = bench_.traits();
    s = first_rung(traits, &kPathTracer);
    const double pass_s = std::max(kShortPass_s, kReferenceShare * settings_.budget_s / kReferencePasses);
    // Threads and caches get warm.
    if (!stopped()) run_job({{{s, "warm up"}}, 0, 1});
    // The lowest rungs tell what a path costs here.
    Ladder& ladder = ladders_[&kPathTracer];
    while (!stopped() && ladder.ended.empty() && ladder.rungs.size() < kRungsFirst &&
           (ladder.rungs.empty() || last_image_s(ladder) < pass_s)) {
      s = ladder.next;
      run_job({{{s, "ladder"}}, 0, 1});
    }
    s.octree_tolerance = traits.given.octree_tolerance * kFinerOctree;
    s.everything = true;
    if (traits.spectral) s.intervals = std::max(8, 2 * traits.most_intervals);
    if (refused(&kPathTracer)) {
      study_.reference.method = kOrdinates.name;
      Ladder& ordinates = ladders_[&kOrdinates];
      while (!stopped() && ordinates.ended.empty() && ordinates.rungs.size() < kRungsFirst) {
        s = ordinates.next;
        run_job({{{s, "ladder"}}, 0, 1});
      }
      s = first_rung(traits, &kOrdinates);
      for (const int cells : {16, 24, 32}) {
        StudySetting finer = s;
        finer.method.cells = cells;
        // Beside the finest solution there are coarser ones.
        if (cells == 16 || 2 * predict_s(finer) < kReferenceShare * settings_.budget_s) s.method.cells = cells;
      }
      s.octree_tolerance = traits.given.octree_tolerance * kFinerOctree;
      s.everything = true;
      return;
    }
    study_.reference.method = kPathTracer.name;
    if (stopped()) return;
    const double factor = std::clamp(pass_s / std::max(last_image_s(ladder), 1e-6), 1.0, 65536.0);
    s = scaled(traits, s, factor);
    if (traits.scatters)
      s.rays = std::clamp(std::min(s.method.samples, kMostReferenceRays), s.rays, std::max(s.rays, kMostReferenceRays));
  }

  double last_image_s(const Ladder& ladder) const { return run_at(ladder.rungs.back()).seconds.image.wall; }

  bool reference_is_due() const {
    if (!study_.reference.picture.known()) return true;
    double least = std::numeric_limits<double>::infinity();
    for (const StudyRun& run : study_.runs) least = std::min(least, run.error.error.value() + run.error.error.error());
    const bool poor =
        study_.reference.error.value() > kPoorReference * std::max(least, kFarBelow * kStudyTargets.back());
    return study_.reference.seconds.wall < (poor ? kPoorReferenceShare : kReferenceShare) * spent_s();
  }
  /// While it is not much better than what it is held against.
  bool reference_is_worth_more() const {
    if (study_.reference.method != kPathTracer.name) return false;
    double least = std::numeric_limits<double>::infinity();
    for (const StudyRun& run : study_.runs)
      least = std::min(least, std::max(run.error.error.value(), kFarBelow * kStudyTargets.back()));
    return study_.reference.error.value() > 0.2 * least;
  }

  bool reference_pass() {
    StudyReference& reference = study_.reference;
    const bool by_paths = reference.method == kPathTracer.name;
    if (!by_paths && reference.picture.known()) return false;
    const double last_s = reference_passes_ > 0 ? reference.seconds.wall / reference_passes_ : 0;
    if (reference.picture.known() && last_s * kMisjudged > left_s()) return false;
    const double cpu = settings_.clock.cpu_s(), wall = settings_.clock.wall_s();
    try {
      StudyPicture made = bench_.measure(reference_setting_, reference_seed(reference_passes_), watch_);
      if (stop_) return false;
      if (by_paths) {
        reference.picture.add(made.picture);
      } else {
        reference.picture = ReferencePicture(std::move(made.picture), std::move(*made.errors));
      }
    } catch (const ResourceError&) {
      if (stop_) return false;
      throw;
    } catch (const NumericalError& error) {
      if (stop_) return false;
      std::string why = "no referee serves the scene: ";
      for (const auto& [method, reason] : study_.refusals) why += fmt::format("{}: {}; ", method->name, reason);
      throw NumericalError("study", why + error.what());
    }
    ++reference_passes_;
    reference.seconds.cpu += settings_.clock.cpu_s() - cpu;
    reference.seconds.wall += settings_.clock.wall_s() - wall;
    report();
    return true;
  }

  std::string reference_text() const {
    const StudySetting& s = reference_setting_;
    if (study_.reference.method == kPathTracer.name) {
      std::string text =
          fmt::format("{} independent passes of {} samples a pixel over at most {} rays, octree tolerance {:.4g}",
                      reference_passes_, s.method.samples, s.rays, s.octree_tolerance);
      if (s.intervals > 0) text += fmt::format(", {} intervals a band", s.intervals);
      return text;
    }
    return fmt::format(
        "{} cells along the longest side, S{}, octree tolerance {:.4g}, errors as the solver states them",
        s.method.cells, s.method.order, s.octree_tolerance);
  }

  // Jobs.

  bool measured(const StudySetting& setting) const { return find(setting) >= 0 || failed(setting); }
  int find(const StudySetting& setting) const {
    for (std::size_t r = 0; r < study_.runs.size(); ++r) {
      if (study_.runs[r].setting == setting) return static_cast<int>(r);
    }
    return -1;
  }
  bool failed(const StudySetting& setting) const {
    return std::find(failed_.begin(), failed_.end(), setting) != failed_.end();
  }
  const StudyRun& run_at(int index) const { return study_.runs[static_cast<std::size_t>(index)]; }

  Job job_of(std::vector<Job::Part> parts, double worth) const {
    Job job{std::move(parts), 0, worth};
    double map = 0;
    std::vector<StudySetting> worlds;
    for (const Job::Part& part : job.parts) {
      job.predicted_s += kPictures * predict_s(part.setting);
      if (std::none_of(worlds.begin(), worlds.end(),
                       [&](const StudySetting& w) { return same_world(w, part.setting); })) {
        job.predicted_s += world_s(part.setting);
        worlds.push_back(part.setting);
      }
      const StudyRun* run = nearest_run(part.setting);
      // The parts of a job share their maps.
      if (run && run->seconds.map.wall > 0 && part.setting.method.type != &kOrdinates) {
        const double own = kPictures * run->seconds.map.wall * work_of(part.setting).map / work_of(run->setting).map;
        if (map > 0) job.predicted_s -= own;
        map = own;
      }
    }
    return job;
  }

  bool improves(const Ladder& ladder) const {
    const std::size_t n = ladder.rungs.size();
    if (n == 0) return true;
    const auto error = [&](std::size_t back) { return run_at(ladder.rungs[n - back]).error.error.value(); };
    if (error(1) < kFarBelow * kStudyTargets.back()) return false;
    if (n < 3) return true;
    return error(1) < kStillImproves * error(2) || error(2) < kStillImproves * error(3);
  }

  /// The other knobs, first around the best rung that leaves time for others; once more around the last best one.
  void vary(const Ladder& ladder, bool up, std::vector<Job>& jobs) const {
    if (ladder.varying >= 0) return add_variations(ladder, ladder.varying, jobs);
    if (up && !ladder.varied.empty()) return;
    const int best = best_rung(ladder);
    for (auto rung = ladder.rungs.rbegin(); rung != ladder.rungs.rend(); ++rung) {
      if (*rung > best) continue;
      // Where errors are huge, small ones cannot be seen.
      if (up && run_at(*rung).error.error.value() > kTooMuchNoise) return;
      if (ladder.varied.contains(*rung)) return;
      std::vector<Job> around;
      add_variations(ladder, *rung, around);
      double all_s = 0;
      for (const Job& job : around) all_s += job.predicted_s;
      if (all_s > kVariationsShare * settings_.budget_s && *rung != ladder.rungs.front()) continue;
      jobs.insert(jobs.end(), around.begin(), around.end());
      return;
    }
  }

  /// The other knobs around a run. Those that only gather otherwise share its map.
  void add_variations(const Ladder& ladder, int base, std::vector<Job>& jobs) const {
    if (ladder.varied.contains(base)) return;
    std::vector<Job::Part> shared;
    for (const StudyVariation& v : variations(bench_.traits(), run_at(base).setting)) {
      if (measured(v.setting)) continue;
      const Job::Part part{v.setting, v.knob, base};
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

  std::vector<Job> find_jobs() {
    std::vector<Job> jobs;
    const StudyTraits& traits = bench_.traits();
    for (const MethodType* method : methods()) {
      Ladder& ladder = ladders_.at(method);
      if (refused(method)) continue;
      climb(ladder);
      const bool up = ladder.ended.empty() && improves(ladder);
      if (up && !measured(ladder.next))
        jobs.push_back(job_of({{ladder.next, "ladder"}}, ladder.rungs.empty() ? kWorthOfFirst : 1));
      if (ladder.rungs.size() >= kRungsFirst || (!up && !ladder.rungs.empty())) vary(ladder, up, jobs);
    }
    if (!refused(traits.given.method.type) && !measured(given())) jobs.push_back(job_of({{given(), "scene"}}, 2));
    add_targets(jobs);
    // A method that is far from the best one's efficiency waits.
    double best = std::numeric_limits<double>::infinity();
    for (const auto& [method, ladder] : ladders_) best = renders(method) ? std::min(best, efficiency(ladder)) : best;
    for (Job& job : jobs) {
      const MethodType* method = job.parts.front().setting.method.type;
      // What cannot render is there to compare with.
      if (!renders(method) && job.predicted_s > kOtherShare * settings_.budget_s) job.worth *= kLeastWorth;
      const double own = efficiency(ladders_.at(method));
      if (std::isfinite(own) && own > 0) job.worth *= std::clamp(best / own, kLeastWorth, 1.0);
    }
    return jobs;
  }
  double efficiency(const Ladder& ladder) const {
    return ladder.rungs.empty() ? std::numeric_limits<double>::infinity() : worth(best_rung(ladder));
  }

  /// Rungs that were measured for another purpose.
  void climb(Ladder& ladder) {
    for (int run = find(ladder.next); run >= 0 && ladder.ended.empty() && improves(ladder); run = find(ladder.next)) {
      if (std::find(ladder.rungs.begin(), ladder.rungs.end(), run) != ladder.rungs.end()) return;
      StudyRun& rung = study_.runs[static_cast<std::size_t>(run)];
      rung.purpose = "ladder";
      rung.base = -1;
      ladder.rungs.push_back(run);
      ladder.next = scaled(bench_.traits(), rung.setting, kRung);
    }
  }

  StudySetting given() const {
    const StudyTraits& traits = bench_.traits();
    StudySetting s = first_rung(traits, traits.given.method.type);
    s.rays = traits.given.rays;
    if (s.method.photons > 0)
      s.method.photons = traits.given.method.photons, s.method.nearest = traits.given.method.nearest;
    if (s.method.samples > 0) s.method.samples = traits.given.method.samples;
    return s;
  }

  /// The rung with the least error x time^(1/2).
  int best_rung(const Ladder& ladder) const {
    int best = ladder.rungs.front();
    for (const int r : ladder.rungs) {
      if (worth(r) <= worth(best)) best = r;
    }
    return best;
  }
  double worth(int run) const {
    const double error = std::max(run_at(run).error.error.value(), run_at(run).error.error.error());
    return error * error * run_at(run).full.cpu();
  }

  /// Settings between two rungs, that should just reach a target.
  void add_targets(std::vector<Job>& jobs) const {
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
          const StudySetting setting = scaled(bench_.traits(), high.setting, std::pow(kRung, -share));
          const double cpu = predict_full_cpu_s(setting);
          if (cpu < least && !measured(setting)) least = cpu, best = setting;
        }
      }
      if (best) jobs.push_back(job_of({{*best, fmt::format("target {:.4g} %", 100 * target.error)}}, 1.5));
    }
  }

  // Running.

  void run_job(const Job& job) {
    std::vector<std::vector<StudyPicture>> made(job.parts.size());
    for (int picture = 0; picture < kPictures; ++picture) {
      for (std::size_t p = 0; p < job.parts.size(); ++p) {
        const StudySetting& setting = job.parts[p].setting;
        if (failed(setting)) continue;
        try {
          made[p].push_back(bench_.measure(setting, seed(picture), watch_));
        } catch (const std::exception& error) {
          if (stop_ || outer_.cancelled()) return;
          fail(job.parts[p], error);
        }
        if (stopped_within()) return;
        report();
      }
    }
    for (std::size_t p = 0; p < job.parts.size(); ++p) {
      if (job.parts[p].purpose == "warm up") return;
      if (!failed(job.parts[p].setting)) add_run(job.parts[p], std::move(made[p]));
    }
    finish(job);
  }

  /// A picture that was stopped is no picture.
  bool stopped_within() { return stop_ || outer_.cancelled(); }

  void fail(const Job::Part& part, const std::exception& error) {
    failed_.push_back(part.setting);
    const bool known = dynamic_cast<const NumericalError*>(&error) || dynamic_cast<const InputError*>(&error) ||
                       dynamic_cast<const ResourceError*>(&error) || dynamic_cast<const std::bad_alloc*>(&error);
    if (!known) throw;
    Ladder& ladder = ladders_.at(part.setting.method.type);
    if (part.purpose != "ladder" && part.purpose != "warm up") {
      study_.left_out.push_back(fmt::format("{}: {}", study_label(part.setting), error.what()));
    } else if (ladder.rungs.empty()) {
      refuse(part.setting.method.type, error.what());
    } else {
      ladder.ended = error.what();
      study_.left_out.push_back(fmt::format("{}: {}", study_label(part.setting), error.what()));
    }
  }

  void add_run(const Job::Part& part, std::vector<StudyPicture> made) {
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
    known_world_s_ = std::max(known_world_s_, run.seconds.world.wall);
    const int index = static_cast<int>(study_.runs.size());
    study_.runs.push_back(std::move(run));
    if (part.setting == given()) study_.as_given = index;
    if (part.purpose == "ladder") ladders_.at(part.setting.method.type).rungs.push_back(index);
    if (study_.reference.picture.known()) evaluate(study_);
    tell(line_of(run_at(index)));
  }

  std::string line_of(const StudyRun& run) const {
    std::string error =
        study_.reference.picture.known()
            ? fmt::format("{:.2f} +- {:.2f} %", 100 * run.error.error.value(), 100 * run.error.error.error())
            : std::string("error not known yet");
    return fmt::format("[{:5.0f} s] {}: {}, {:.2f} s CPU", spent_s(), study_label(run.setting), error,
                       run.seconds.cpu());
  }

  /// What a job says about the next.
  void finish(const Job& job) {
    for (const Job::Part& part : job.parts) {
      if (part.purpose.starts_with("target")) {
        for (const double target : kStudyTargets)
          tries_[target] += part.purpose == fmt::format("target {:.4g} %", 100 * target) ? 1 : 0;
      }
    }
    const Job::Part& first = job.parts.front();
    Ladder& ladder = ladders_.at(first.setting.method.type);
    if (first.purpose == "ladder" && !failed(first.setting))
      ladder.next = scaled(bench_.traits(), first.setting, kRung);
    if (first.base < 0 || !study_.reference.picture.known()) return;
    // The best value of the knob, where it is worth taking, goes into the next rung.
    for (const Job::Part& part : job.parts) {
      const int run = find(part.setting);
      if (run < 0) continue;
      double& best = taken_[{first.base, part.purpose}];
      if (best == 0) best = kWorthTaking * worth(first.base);
      // With its standard error: luck is not worth taking.
      const RootError& error = run_at(run).error.error;
      const double sure = std::pow(error.value() + error.error(), 2) * run_at(run).full.cpu();
      if (sure < best) {
        best = sure;
        ladder.next = with_knob(ladder.next, part.purpose, run_at(first.base).setting, part.setting);
      }
    }
    std::vector<Job> open;
    add_variations(ladder, first.base, open);
    ladder.varying = open.empty() ? -1 : first.base;
    if (open.empty()) ladder.varied.insert(first.base);
  }

  void tell_left_out(const std::vector<Job>& jobs) {
    for (const Job& job : jobs) {
      if (job.parts.size() == 1) {
        study_.left_out.push_back(fmt::format("{}: about {:.0f} s, when {:.0f} s were left",
                                              study_label(job.parts.front().setting), job.predicted_s,
                                              std::max(0.0, left_s())));
      } else {
        study_.left_out.push_back(fmt::format("{} other settings around {}: about {:.0f} s, when {:.0f} s were left",
                                              job.parts.size(), study_label(run_at(job.parts.front().base).setting),
                                              job.predicted_s, std::max(0.0, left_s())));
      }
    }
  }

  StudyBench& bench_;
  const StudySettings& settings_;
  const Progress& outer_;
  Progress watch_;
  std::atomic<bool> stop_{false};
  double begin_s_;
  Study study_;
  std::map<const MethodType*, Ladder> ladders_;
  std::vector<StudySetting> failed_;
  std::map<double, int> tries_;
  std::map<std::pair<int, std::string>, double> taken_;  // by base and knob: the least error^2 x time so far
  StudySetting reference_setting_;
  int reference_passes_ = 0;
  double known_world_s_ = 0;
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
