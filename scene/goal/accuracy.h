// An image to a wanted error, or the most accurate one for a time: tries ways to it on a part of the picture, takes
// the cheapest, and repeats independent passes until the image's own errors say that it is there.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scene/goal/recipe.h"
#include "scene/session/session.h"
#include "sensor/judge/image_error.h"

namespace obscura {

/// Seconds since the run began.
using RunClock = std::function<double()>;

/// What a run may do until it ends. At least one is given.
struct AccuracyGoal {
  std::optional<ErrorTarget> target_error;
  std::optional<double> time_limit_s;     ///< since the run began
  double dropped = 0;                     ///< share of its radiance that a pixel may lack by what the plan has left out
  std::uint64_t most_photons = 20000000;  ///< of a pass, per band; fewer where their maps would exceed 2 GiB
};

/// A way to the image, as tried on a part of the picture.
struct PilotTrial {
  Recipe recipe;
  double seconds = 0;      ///< of the trial
  double predicted_s = 0;  ///< time to the target, or use of the time that is left; 0: out of reach
  double predicted_error = 0;
};

/// What was reached, and how.
struct Accuracy {
  AccuracyGoal goal;
  double error = 0;          ///< estimated error of the image, in the goal's unit: noise, bias and what was dropped
  double low = 0, high = 0;  ///< its 95 % interval
  double noise = 0, bias = 0, dropped = 0;  ///< parts of it
  Recipe recipe;                            ///< of each pass
  int passes = 0;
  std::vector<PilotTrial> trials;
  double pilot_s = 0, photons_s = 0, image_s = 0;
  /// Why it ended: "target", "time", "bias" (of the method, above the target) or "cancelled".
  std::string ended;

  bool reached() const noexcept { return goal.target_error && high <= goal.target_error->value; }
};

struct AccurateImage {
  Rendered rendered;
  Method method;           ///< of each pass
  std::uint64_t seed = 1;  ///< of the last pass
  Light light;             ///< what all photons together did, without maps; empty: none were traced
  Accuracy accuracy;       ///< `ended` is empty where there was no goal
};

/// What the film knows of the image's error in a band, in the goal's unit; none: the unit has no meaning there.
std::optional<FilmError> error_in_unit(Session& session, const AccuracyGoal& goal, const Film& film, int band);

/// Which way is taken depends on the machine's speed; what each pass gives does not.
/// @throws as Session::render(), where every way is refused
AccurateImage render_to_goal(Session& session, const AccuracyGoal& goal, const RunClock& clock,
                             const Progress& progress = {});

}  // namespace obscura
