// The reference that a study's errors are measured against: independent passes of paths, or one solution of ordinates.
#pragma once

#include <string>

#include "scene/study/study_bench.h"
#include "scene/study/study_search.h"

namespace obscura {

class ReferenceRuns {
 public:
  /// @param study its `reference` is what grows
  ReferenceRuns(Study& study, StudyBench& bench, const StudySettings& settings)
      : study_(study), bench_(bench), settings_(settings) {}

  /// Wall time that a pass should take.
  double pass_s() const;
  /// Chooses method and setting by what the lowest rungs cost.
  void choose(const StudySearch& search);

  /// Whether it is behind its share of the time that has been spent.
  bool is_due(double spent_s) const;
  /// While it is not much better than what it is held against.
  bool is_worth_more() const;
  /// One more pass. False where it does not fit into what is left, or was stopped.
  /// @throws NumericalError where no referee serves the scene
  bool pass(double left_s, const Progress& watch);

  /// What was run, for people.
  std::string text() const;

 private:
  bool by_paths() const { return setting_.method.type == &kPathTracer; }

  Study& study_;
  StudyBench& bench_;
  const StudySettings& settings_;
  StudySetting setting_;
  int passes_ = 0;
};

}  // namespace obscura
