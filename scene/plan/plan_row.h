// What the plan says of each effect, and how it spends the accuracy that is asked for.
#pragma once

#include <optional>
#include <string>

namespace obscura {

/// One effect of the plan (scene/METHODS.md, "Plan"): whether it runs, why, and the bound behind the decision.
struct PlanRow {
  std::string effect;
  bool on = false;
  std::string reason;
  std::optional<double> bound;                  ///< none: nothing was left out on a bound
  std::optional<double> cost_s = std::nullopt;  ///< predicted seconds of one core; none: not known, or not on its own
};

/// How the accuracy is spent, as image errors (sensor/METHODS.md, "Comparing images").
struct BudgetReport {
  double total = 1e-3;    ///< what the user allows
  double dropped = 0;     ///< sum of the bounds of effects that are off though present
  double sampled = 1e-3;  ///< what is left for everything that is sampled
};

}  // namespace obscura
