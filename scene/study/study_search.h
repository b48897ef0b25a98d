// Which runs a study makes next: ladders of growing cost, other knobs around their best rungs, and settings between
// rungs that should just reach a target.
#pragma once

#include <exception>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "scene/study/study_forecast.h"

namespace obscura {

/// Runs one after the other on one map.
struct StudyJob {
  struct Part {
    StudySetting setting;
    std::string purpose;
    int base = -1;
  };
  std::vector<Part> parts;
  double predicted_s = 0;  ///< wall time
  double worth = 1;        ///< how much more useful than a rung of the same time
};

/// The purpose of a job whose pictures are thrown away.
inline constexpr const char* kWarmUp = "warm up";

/// Of a study's random numbers: pictures of a setting count from 0, passes of the reference from kReferenceSeeds.
inline constexpr std::uint64_t kReferenceSeeds = 500000;
inline std::uint64_t study_seed(const StudySettings& settings, std::uint64_t number) noexcept {
  return settings.seed * 1000003 + number;
}

/// Pictures of a setting; bias and noise need two.
inline constexpr int kStudyPictures = 2;

/// Below this error none is of interest.
inline constexpr double kLeastStudyError = 0.5 * kStudyTargets.back();

class StudySearch {
 public:
  struct Ladder {
    StudySetting next;
    std::vector<int> rungs;  ///< runs
    int varying = -1;        ///< the run around which other knobs are being tried
    std::set<int> varied;    ///< runs around which they have been
    std::string ended;       ///< why there is no next rung; empty: there is
  };
  /// Rungs before the other knobs are tried for the first time.
  static constexpr std::size_t kRungsFirst = 3;

  /// @param study its runs and targets say what is worth trying; refusals and what is left out are added to it
  StudySearch(Study& study, const StudyTraits& traits);

  const Ladder& ladder(const MethodType* method) const { return ladders_.at(method); }
  bool refused(const MethodType* method) const;
  /// Whether a run of the setting has been tried in vain.
  bool failed(const StudySetting& setting) const;

  /// All that could be done next.
  std::vector<StudyJob> find_jobs();
  /// A part could not be run. @pre called where the error was caught: rethrows what is no refusal of a method
  void fail(const StudyJob::Part& part, const std::exception& error);
  /// A part has become the study's newest run.
  void add_run(const StudyJob::Part& part);
  /// What a job says about the next.
  void finish(const StudyJob& job);
  /// Says which jobs no time was left for.
  void leave_out(const std::vector<StudyJob>& jobs, double left_s);

 private:
  const StudyRun& run_at(int index) const { return study_.runs[static_cast<std::size_t>(index)]; }
  int find(const StudySetting& setting) const;
  bool measured(const StudySetting& setting) const { return find(setting) >= 0 || failed(setting); }
  StudySetting given() const;
  void refuse(const MethodType* method, const std::string& why);

  StudyJob job_of(std::vector<StudyJob::Part> parts, double worth) const;
  bool improves(const Ladder& ladder) const;
  void climb(Ladder& ladder);
  void vary(const Ladder& ladder, bool up, std::vector<StudyJob>& jobs) const;
  void add_variations(const Ladder& ladder, int base, std::vector<StudyJob>& jobs) const;
  void add_targets(std::vector<StudyJob>& jobs) const;
  void let_poor_methods_wait(std::vector<StudyJob>& jobs) const;
  void take_best_knob(const StudyJob& job, Ladder& ladder);

  int best_rung(const Ladder& ladder) const;
  double error2_time(int run) const;
  double efficiency(const Ladder& ladder) const;

  Study& study_;
  const StudyTraits& traits_;
  StudyForecast forecast_;
  std::map<const MethodType*, Ladder> ladders_;
  std::vector<StudySetting> failed_;
  std::map<double, int> tries_;                          // of each target
  std::map<std::pair<int, std::string>, double> taken_;  // by base and knob: the least error^2 x time so far
};

}  // namespace obscura
