#include "photon/limits/build_measure.h"

#include <algorithm>
#include <atomic>
#include <mutex>

#include "photon/optics/planck_table.h"

namespace obscura {
namespace {

/// Largest value of a channel among all that the stream pours.
float largest_value(const VoxelStream& stream, int channel) {
  std::atomic<float> largest{0};
  const auto raise = [&largest](float value) {
    float known = largest.load(std::memory_order_relaxed);
    while (value > known && !largest.compare_exchange_weak(known, value, std::memory_order_relaxed)) {
    }
  };
  VoxelSink sink(
      [&](const Vec3i&, const float* const* values) {
        raise(*std::max_element(values[channel], values[channel] + 512));
      },
      [&](const Vec3i&, int, std::span<const float> values) { raise(values[static_cast<std::size_t>(channel)]); });
  stream.pour(sink);
  return largest;
}

}  // namespace

ErrorMeasure build_measure(const Cloud& cloud, std::span<const Band> bands, const VoxelStream& stream) {
  ErrorMeasure measure;
  measure.optical_weight.assign(stream.channels.size(), 0.0);
  const std::size_t intervals = cloud.media.empty() ? 0 : cloud.media.front().extinction.size();
  // Lengths are measured in the cloud's own metres; its placement may stretch them.
  const double stretch = std::cbrt(std::abs(linear_determinant(cloud.local_to_world)));

  // The interval in which all media together attenuate most.
  double most = 0;
  for (std::size_t i = 0; i < intervals; ++i) {
    std::vector<double> weights(stream.channels.size(), 0.0);
    double sum = 0;
    for (const Medium& medium : cloud.media) {
      weights[static_cast<std::size_t>(medium.channel)] += stretch * medium.extinction[i];
      sum += medium.extinction[i];
    }
    if (sum > most) {
      most = sum;
      measure.optical_weight = weights;
    }
  }

  // Emission that varies otherwise than extinction does: a temperature channel.
  const int channel = cloud.temperature.channel;
  if (channel < 0) return measure;
  const double scale = cloud.temperature.scale;
  const double offset = cloud.temperature.offset_K;
  const double warmest = scale * static_cast<double>(largest_value(stream, channel)) + offset;
  if (!(warmest > 2)) return measure;
  struct Part {
    PlanckTable planck;
    double relative;                 // one over the largest radiance
    std::vector<double> absorption;  // per channel, 1/m per unit
  };
  auto parts = std::make_shared<std::vector<Part>>();
  std::size_t index = 0;
  for (const Band& band : bands) {
    // One interval stands for a band: the one in which the warmest voxels emit most.
    std::optional<Part> strongest;
    double radiance = 0;
    for (int j = 0; j < band.interval_count(); ++j, ++index) {
      if (band.grey() || (!cloud.source.empty() && cloud.source[index])) continue;
      const double here = band.planck(j, warmest);
      if (!(here > radiance)) continue;
      radiance = here;
      std::vector<double> absorption(stream.channels.size(), 0.0);
      for (const Medium& medium : cloud.media) {
        absorption[static_cast<std::size_t>(medium.channel)] +=
            stretch * medium.extinction[index] * (1 - medium.albedo[index]);
      }
      strongest.emplace(Part{PlanckTable(band, j, 2, warmest), 1 / here, std::move(absorption)});
    }
    if (strongest) parts->push_back(std::move(*strongest));
  }
  if (parts->empty()) return measure;
  measure.emission = [parts, channel, scale, offset](std::span<const float> values) {
    double largest = 0;
    const double kelvin = scale * static_cast<double>(values[static_cast<std::size_t>(channel)]) + offset;
    for (const Part& part : *parts) {
      double absorption = 0;
      for (std::size_t c = 0; c < values.size(); ++c) absorption += part.absorption[c] * static_cast<double>(values[c]);
      if (absorption > 0) largest = std::max(largest, absorption * part.planck(kelvin) * part.relative);
    }
    return largest;
  };
  return measure;
}

}  // namespace obscura
