// What effects and methods will cost: a work model, not a measurement.
#pragma once

#include "photon/limits/media_summary.h"
#include "scene/file/description.h"

namespace obscura::detail {

/// Seconds of one core of an ordinary machine. Formulas: scene/METHODS.md, "Plan".
struct Costs {
  std::array<double, 12> effects{};  ///< of each of effect_names() by the method in use, were it on
  double photon_s = 0;               ///< the whole image by photons, with the scene's settings
  double path_s = 0;                 ///< by paths
};

struct CostSettings {
  bool gathers = false;                 ///< method photon asks its map behind a bounce
  bool single = true, multiple = true;  ///< these effects are on
  bool path = false;                    ///< effects cost what they do by method path
};

Costs predict_costs(const Description& scene, const MediaSummary& summary, const CostSettings& settings);

}  // namespace obscura::detail
