// What a scene asks beside its image: fluence at its probes, power through its rectangles.
#pragma once

#include <vector>

#include "scene/run/report.h"
#include "scene/session/session.h"

namespace obscura {

/// By the method that makes the image. An error that is not random is told with those that are where the method has no
/// other (discrete ordinates).
std::vector<ProbeReport> probe(Session& session, const Method& method, const Estimator& estimator);
/// Empty where the method does not know powers through rectangles.
std::vector<FluxReport> fluxes(Session& session, const Estimator& estimator);
/// The same from what all photons of several passes did.
std::vector<FluxReport> fluxes(Session& session, const Light& light);

}  // namespace obscura
