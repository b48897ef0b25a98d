// What the sensor asks of light: the radiance that rays bring, in all bands.
#pragma once

#include <cstdint>
#include <span>

#include "photon/methods/estimator.h"
#include "sensor/capture/sample.h"

namespace obscura {

/// All bands: interval after interval, added up per band. @pre one sample, as reset, for each ray
RadianceCounts trace_bands(const World& world, const RadianceEstimator& estimator, const RayShare& share,
                           std::span<const Ray> rays, std::span<const std::uint64_t> histories,
                           std::span<RaySample> samples);

}  // namespace obscura
