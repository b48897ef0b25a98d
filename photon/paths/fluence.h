// Fluence at a point: the radiance of all directions, by the same pass that serves the sensor.
#pragma once

#include "octree/base/statistics.h"
#include "photon/paths/radiance.h"

namespace obscura {

struct Fluence : BatchMean {
  double bias = 0;  ///< estimated, of the maps' part
};

/// Integral of radiance over the sphere, W/m2, and its standard error, at one spectral interval.
/// @param directions stratified over the sphere; @param history names the random numbers
Fluence fluence(SpectralWorld world, const PhotonMaps* maps, const RadianceSettings& settings, const Vec3d& point,
                int directions, std::uint64_t history);

}  // namespace obscura
