// The plan: which effects run and with what settings, as a value. An effect is off because it is absent, because a
// bound says that it hardly shows, or because the user says so.
#pragma once

#include "photon/limits/media_summary.h"
#include "photon/methods/method.h"
#include "scene/file/description.h"
#include "scene/plan/plan_row.h"
#include "scene/world/reduce.h"
#include "sensor/capture/camera.h"
#include "sensor/capture/sampler.h"
#include "sensor/picture/image.h"

namespace obscura {

/// The method that will reach the same error sooner, and what the scene's settings will cost by either.
struct MethodChoice {
  const MethodType* cheaper = &kPhotonMap;
  std::string reason;
  double photon_s = 0;  ///< seconds of one core
  double path_s = 0;
};

struct Plan {
  std::vector<PlanRow> effects;  ///< named as in the report
  CameraSettings camera;
  SamplerSettings sampling;  ///< as the sensor is described; how rays share samples is the method's affair
  /// The one that the scene names, or the cheaper one, with the scene's settings.
  Method method;
  const MethodType* photon = &kPhotonMap;  ///< of the methods by photons the one that suits the scene
  EstimatorSettings estimator;             ///< what is left of the light's effects
  Cuts cuts;                               ///< what the World does not hold
  BudgetReport budget;
  std::vector<std::vector<LeftOut>> left_out;  ///< of each band: what is off because of a bound
  MethodChoice choice;
  std::vector<std::string> warnings;  ///< what the user should know, one sentence each
};

/// The settings of the scene for a method.
Method method_of(const Description& scene, const MethodType& type);

/// The error that a plan may spend where the scene names no target (scene/FORMAT.md, "Plan and budget").
inline constexpr double kDefaultBudget = 1e-3;

/// A pure function of the description, as it was written, what its whole World can do at most, and the image error that
/// is allowed.
Plan make_plan(const Description& scene, const MediaSummary& summary, double budget);

}  // namespace obscura
