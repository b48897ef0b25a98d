// The steps of a stretch of a camera ray that have random streams of their own.
#pragma once

#include "photon/paths/radiance.h"

namespace obscura::detail {

// Step 0 is for the places of scattering points, 1 to kMostPoints for the light at each. Then:

inline constexpr int kMapStep = kMostPoints + 1;
inline constexpr int kMeetStep = kMostPoints + 2;
inline constexpr int kReflectStep = kMostPoints + 3;  // one for each path from a surface
inline constexpr int kSteps = 2 * kMostPoints + 4;

}  // namespace obscura::detail
