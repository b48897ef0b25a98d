// Which effects run: the rows of the plan, by presence, by the user's word, or by bounds within a budget.
#pragma once

#include "photon/limits/media_summary.h"
#include "scene/plan/plan_row.h"
#include "scene/world/reduce.h"

namespace obscura::detail {

struct Decisions {
  std::vector<PlanRow> rows;  ///< one for each of effect_names(), in their order
  Cuts cuts;
  BudgetReport budget;
  std::vector<std::string> warnings;  ///< of effects that the user has forced

  bool on(const std::string& effect) const;
};

/// All that is dropped on bounds may change the image by a tenth of the budget together: smallest bounds first.
/// @param scene as it was written, with all its intervals
Decisions decide(const Description& scene, const MediaSummary& summary, double budget);

}  // namespace obscura::detail
