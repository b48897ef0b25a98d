// Tries ways to an image on some of its tiles, and fits models of their time and error.
#pragma once

#include <vector>

#include "scene/goal/accuracy.h"

namespace obscura {

/// The cheapest way that was found, and all that were tried.
struct Pilot {
  Recipe recipe;
  PassPlan passes;
  RecipeModel model;
  std::vector<PilotTrial> trials;
  std::uint64_t most_photons = 0;  ///< of a pass, per band: what the goal and memory allow
};

/// @throws where every way is refused, as the last of them
Pilot try_recipes(Session& session, const AccuracyGoal& goal, const RunClock& clock, const Progress& progress);

}  // namespace obscura
