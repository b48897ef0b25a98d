// Which effects run: the rows of the plan, by presence, by the user's word, or by bounds within a budget.
#pragma once

#include "photon/limits/media_summary.h"
#include "scene/plan/plan_row.h"
#include "scene/world/reduce.h"
#include "sensor/picture/image.h"

namespace obscura::detail {

struct Decisions {
  std::vector<PlanRow> rows;  ///< one for each of effect_names(), in their order
  Cuts cuts;
  BudgetReport budget;
  std::vector<std::vector<LeftOut>> left_out;  ///< of each band: what is off because of a bound
  std::vector<std::string> warnings;           ///< of effects that the user has forced

  bool on(const std::string& effect) const;
};

/// All that is dropped on bounds may change any pixel by a tenth of the budget together: smallest bounds first. A pixel
/// is judged by its own radiance, or by one below which nothing matters (scene/METHODS.md, "Plan").
/// @param scene as it was written, with all its intervals
Decisions decide(const Description& scene, const MediaSummary& summary, double budget);

}  // namespace obscura::detail
