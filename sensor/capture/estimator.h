// What the sensor asks of light: the radiance that rays bring, and the same in all bands.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "photon/paths/radiance.h"
#include "sensor/capture/sample.h"

namespace obscura {

/// What arrives at the start of each ray at one spectral interval. Called by many threads at once; the result
/// of a ray belongs to its history number.
/// @param share of a pixel that each of the rays stands for, (0, 1]: of its samples, its footprint
using Estimator = std::function<RadianceCounts(int interval, double share, std::span<const Ray> rays,
                                               std::span<const std::uint64_t> histories, std::span<Incoming> incoming)>;

/// All bands: interval after interval, added up per band. @pre one sample, as reset, for each ray
RadianceCounts trace_bands(const World& world, const Estimator& estimator, double share, std::span<const Ray> rays,
                           std::span<const std::uint64_t> histories, std::span<RaySample> samples);

}  // namespace obscura
