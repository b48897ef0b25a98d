// Which part of the suns' light reaches what a ray meets first.
#pragma once

#include <cstdint>
#include <span>

#include "photon/world/world.h"

namespace obscura {

/// Of each ray's first surface: the share of the light of sun and moon (from the middle of their discs) that
/// neither surfaces nor clouds keep from it, at the interval in which they shine brightest. 0 where it faces away
/// from them, where the ray meets nothing, and where no sun shines.
/// @param histories name the random numbers that permeable materials draw
void sunlit_shares(const World& world, std::uint64_t seed, std::span<const Ray> rays,
                   std::span<const std::uint64_t> histories, std::span<float> shares);

}  // namespace obscura
