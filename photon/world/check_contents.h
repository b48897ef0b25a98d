// What a World is made of, looked at before anything is made of it.
#pragma once

#include <span>

#include "octree/base/math.h"
#include "photon/world/spectral_world.h"

namespace obscura {

/// Every list has an entry for each interval, every number is in its range and finite, every index points at something.
/// @throws InputError with all problems, each with its place ("cloud \"smoke\", medium 0"), the number and the remedy
void check_contents(const WorldContents& contents);

/// What a caller asks of rays: an interval that the World has, directions of unit length, as many places for the
/// results as there are rays. Once a call, at the door.
/// @throws InputError
void check_rays(SpectralWorld world, std::span<const Ray> rays, std::size_t histories, std::size_t results);

}  // namespace obscura
