// What one camera ray brings home: the value that the sensor pass makes, sampler and film take.
#pragma once

#include <array>
#include <vector>

#include "octree/base/math.h"
#include "photon/map/photon.h"

namespace obscura {

/// One ray in one band, radiances in W/m2/sr (grey: the scene's unit).
struct BandSample {
  /// The part of the radiance that does not depend on the photon map.
  double direct = 0;
  /// The part from the map as each batch alone estimates it: the ray's is their mean.
  std::array<double, kBatches> map{};
  /// Estimated bias of the map's part.
  double bias = 0;
  /// Of the radiance, from the ray's own random points; 0: not known.
  double variance = 0;
  /// Of clouds alone, to the first surface or infinity.
  double transmission = 1;
  double transmission_atmosphere = 1;
};

/// Kept and reset between rays, so that a pixel allocates nothing.
struct RaySample {
  explicit RaySample(int band_count) : bands(static_cast<std::size_t>(band_count)) {}

  /// Back to the ray that meets nothing.
  void reset() {
    for (BandSample& band : bands) band = BandSample{};
    depth_m = kInfinity;
  }

  std::vector<BandSample> bands;
  /// Along the ray to the first surface; infinity: none.
  double depth_m = kInfinity;
};

}  // namespace obscura
