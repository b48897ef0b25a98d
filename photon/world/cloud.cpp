// The optics of a cloud at one spectral interval, from its media, temperature and given emission.
#include "photon/world/cloud.h"

#include <algorithm>

#include "octree/base/math.h"

namespace obscura {

CloudOptics::CloudOptics(const Cloud& cloud, const Band& band, int interval, int index)
    : temperature_(cloud.temperature) {
  const auto at = [index](const std::vector<double>& values) { return values[static_cast<std::size_t>(index)]; };
  weights_.assign(static_cast<std::size_t>(cloud.octree->channel_count()), 0.0);
  bool one_albedo = true;
  for (const Medium& medium : cloud.media) {
    const double extinction = at(medium.extinction);
    const double scattering = extinction * at(medium.albedo);
    blunted_.push_back(std::make_shared<const PhaseFunction>(medium.phase.blunted(kMapPeak)));
    parts_.push_back({medium.channel, extinction, scattering, &medium.phase, blunted_.back().get()});
    weights_[static_cast<std::size_t>(medium.channel)] += extinction;
    scatters_ = scatters_ || scattering > 0;
    one_albedo = one_albedo && at(medium.albedo) == at(cloud.media.front().albedo);
  }

  // Emission: the given source, or Planck's where there is a temperature.
  if (!cloud.source.empty() && cloud.source[static_cast<std::size_t>(index)]) {
    constant_source_ = *cloud.source[static_cast<std::size_t>(index)];
    temperature_.channel = -1;
  } else if (band.grey()) {
    temperature_.channel = -1;
  } else if (temperature_.channel < 0) {
    constant_source_ = temperature_.constant_K > 0 ? band.planck(interval, temperature_.constant_K) : 0.0;
  } else {
    const Bounds range = cloud.octree->bounds(temperature_.channel);
    const double a = temperature_.scale * range.min + temperature_.offset_K;
    const double b = temperature_.scale * range.max + temperature_.offset_K;
    // Cells without density are at 0 K: the table serves what a cloud can be, the rest is computed.
    const double warmest = std::max({a, b, 2.0});
    planck_.emplace(band, interval, std::clamp(std::min(a, b), 2.0, warmest), warmest);
  }
  if (!cloud.emission.empty()) added_ = at(cloud.emission);
  emits_ = temperature_.channel >= 0 || constant_source_ > 0 || added_ > 0;
  if (temperature_.channel < 0 && added_ == 0 && one_albedo && !cloud.media.empty()) {
    uniform_source_ = (1 - at(cloud.media.front().albedo)) * constant_source_;
  }
  if (emits_) {
    double largest_share = 0;
    for (const Part& part : parts_) {
      if (part.extinction > 0) largest_share = std::max(largest_share, 1 - part.scattering / part.extinction);
    }
    double warmest = constant_source_;
    if (temperature_.channel >= 0) warmest = source_range(cloud.octree->bounds(temperature_.channel)).second;
    largest_source_ = added_ > 0 ? kInfinity : largest_share * warmest;
  }
}

std::pair<double, double> CloudOptics::source_range(const Bounds& value) const noexcept {
  const double a = temperature_.scale * static_cast<double>(value.min) + temperature_.offset_K;
  const double b = temperature_.scale * static_cast<double>(value.max) + temperature_.offset_K;
  return {(*planck_)(std::min(a, b)), (*planck_)(std::max(a, b))};
}

}  // namespace obscura
