#include "sensor/capture/estimator.h"

namespace obscura {

RadianceCounts trace_bands(const World& world, const RadianceEstimator& estimator, const RayShare& share,
                           std::span<const Ray> rays, std::span<const std::uint64_t> histories,
                           std::span<RaySample> samples) {
  RadianceCounts counts;
  for (RaySample& sample : samples) {
    for (BandSample& band : sample.bands) band.transmission = band.transmission_atmosphere = 0;
  }
  std::vector<Incoming> incoming(rays.size());
  for (int i = 0; i < world.interval_count(); ++i) {
    const IntervalIndex where = world.interval(i);
    const auto b = static_cast<std::size_t>(where.band);
    const double weight = world.bands()[b].intervals()[static_cast<std::size_t>(where.interval)].weight;
    counts += estimator(i, share, rays, histories, incoming);
    for (std::size_t r = 0; r < incoming.size(); ++r) {
      const Incoming& in = incoming[r];
      BandSample& band = samples[r].bands[b];
      band.direct += in.direct;
      for (std::size_t k = 0; k < in.map.size(); ++k) band.map[k] += in.map[k];
      band.bias += in.bias;
      band.variance += in.variance;
      band.transmission += weight * in.transmission;
      band.transmission_atmosphere += weight * in.transmission_air;
      samples[r].depth_m = in.distance;
    }
  }
  return counts;
}

}  // namespace obscura
