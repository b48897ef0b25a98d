// The unbiased path tracer: no map, no limit of bounces. The referee of the photon map, and the method of
// choice for thin clouds.
#pragma once

#include "octree/base/error.h"
#include "octree/base/statistics.h"
#include "photon/paths/radiance.h"
#include "photon/trace/flux.h"

namespace obscura {

struct PathSettings {
  /// Paths of a ray whose clouds let nothing through; in proportion fewer through thin clouds.
  int paths = 1;
  /// Mirrors that a camera ray follows; one behind them is taken for Lambertian.
  int specular_depth = 4;
  std::optional<int> scattering_depth;  ///< most scatterings in clouds; none: no limit
  std::uint64_t seed = 1;
  RadianceParts parts;
};

/// Radiance along many rays, as incoming_radiance(): everything is in Incoming::direct, the variance of its
/// mean over the ray's paths in Incoming::variance (0 for one path).
RadianceCounts path_radiance(SpectralWorld world, const PathSettings& settings, std::span<const Ray> rays,
                             std::span<const std::uint64_t> histories, std::span<Incoming> incoming);

/// Power through a rectangle, W, each with its standard error: along its normal and against it.
struct PathFlux {
  BatchMean forward, backward;
};
/// By `rays` paths a side from stratified places in cosine-distributed directions. @param history names the
/// random numbers
PathFlux path_flux(SpectralWorld world, const PathSettings& settings, const FluxRectangle& rectangle, int rays,
                   std::uint64_t history);

/// Why paths cannot serve the World: what they cannot find (beams without width) or not finish; none: they can.
std::optional<NumericalError> unfit_for_paths(const World& world);

}  // namespace obscura
