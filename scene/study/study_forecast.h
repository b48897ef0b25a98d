// What a setting will cost, by the runs so far.
#pragma once

#include <vector>

#include "scene/study/study.h"

namespace obscura {

/// What a forecast may be wrong by: runs are started only where they fit with it.
inline constexpr double kMisjudged = 1.25;

/// Scales the run of the same method whose work is nearest. Valid as long as the runs, which may grow.
class StudyForecast {
 public:
  explicit StudyForecast(const std::vector<StudyRun>& runs) : runs_(&runs) {}

  /// Null where the method has no run yet.
  const StudyRun* nearest_run(const StudySetting& setting) const;
  /// Wall time of making the World; 0 where a run had the same.
  double world_s(const StudySetting& setting) const;
  /// Wall time of one picture without its World.
  double picture_s(const StudySetting& setting) const;
  /// CPU time of the scene's whole picture; infinite where nothing is known.
  double full_cpu_s(const StudySetting& setting) const;

 private:
  const std::vector<StudyRun>* runs_;
};

}  // namespace obscura
