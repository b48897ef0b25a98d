// Radiance along rays into which nothing is scattered or reflected: all that they bring comes from along themselves.
// One loop over the rays, no lists of legs. For radiance.cpp.
#pragma once

#include <span>

#include "photon/paths/radiance.h"

namespace obscura::detail {

/// What a surface sends along the ray that has met it, through the air before it.
/// @param air transmission of the air up to the hit
inline double surface_behind(SpectralWorld world, const Ray& ray, const SurfaceHit& hit, double air) {
  const SurfacePoint at = world.surface_at(ray, hit);
  const double behind = at.emission(at.cosine);
  return air < 1 ? air * behind + (1 - air) * world.air_radiance() : behind;
}

/// As incoming_radiance(). @pre nothing scatters or reflects light into a ray, and none has a spot to be walked
/// coarsely
RadianceCounts straight_radiance(SpectralWorld world, const RadianceSettings& settings, std::span<const Ray> rays,
                                 std::span<const std::uint64_t> histories, std::span<Incoming> incoming);

}  // namespace obscura::detail
