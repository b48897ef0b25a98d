// The report of a run, from what has been done.
#pragma once

#include "scene/goal/accuracy.h"
#include "scene/run/report.h"

namespace obscura {

/// All but probes, fluxes, the detector and the time.
Report make_report(Session& session, const AccurateImage& made);

}  // namespace obscura
