// The plan: which effects run and with what settings, as a value. Everything that the scene holds is on.
#pragma once

#include "photon/trace.h"
#include "scene/description.h"
#include "scene/report.h"
#include "sensor/render.h"

namespace obscura {

struct Plan {
  std::vector<PlanRow> effects;  ///< named as in the report
  CameraSettings camera;
  SamplerSettings sampling;
  TraceSettings trace;
  RadianceSettings radiance;
  /// Passes over the image, each with random numbers of its own: more samples than one pass can hold.
  int passes = 1;
};

/// A pure function of the description and what its World holds.
Plan make_plan(const Description& scene, const World& world);

}  // namespace obscura
