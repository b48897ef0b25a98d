#include "sensor/capture/corner_rays.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "photon/paths/sunlight.h"
#include "sensor/capture/film.h"

namespace obscura {
namespace {

/// Deciding rays have names beyond those of all rays that are averaged, exact in a double.
constexpr std::uint64_t kDecidingHistory = std::uint64_t{1} << 52;
/// Share of a pixel's samples that a deciding ray gets.
constexpr double kDecidingShare = 0.125;

}  // namespace

CornerRays::CornerRays(const World& world, const RadianceEstimator& estimator, const Sampler& sampler, int levels)
    : world_(&world),
      estimator_(&estimator),
      sampler_(&sampler),
      levels_(levels),
      bands_(static_cast<int>(world.bands().size())),
      shadows_(sampler.settings().adaptive->shadow && !world.suns().empty() && !world.objects().empty()) {}

RadianceCounts CornerRays::trace(std::span<const Corner> corners, std::span<float> values) const {
  const Camera& camera = sampler_->camera();
  const double step = std::ldexp(1.0, -levels_);
  const std::uint64_t columns = (static_cast<std::uint64_t>(camera.columns()) << levels_) + 1;
  std::vector<Ray> rays;
  std::vector<std::uint64_t> histories;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::optional<Ray> ray = camera.ray(corners[i].x * step, corners[i].y * step);
    float* value = &values[i * stride()];
    std::fill_n(value, stride(), 0.0f);
    for (int b = 0; b < bands_; ++b) value[1 + 3 * b] = 1;
    if (!ray) continue;
    rays.push_back(*ray);
    histories.push_back(kDecidingHistory + corners[i].y * columns + corners[i].x);
    places.push_back(i);
  }
  std::vector<RaySample> samples(rays.size(), RaySample(bands_));
  const RadianceCounts counts =
      trace_bands(*world_, *estimator_, sampler_->share(kDecidingShare), rays, histories, samples);
  std::vector<float> shares(rays.size());
  if (shadows_) sunlit_shares(*world_, sampler_->settings().seed, rays, histories, shares);
  PixelSum sum(bands_);
  for (std::size_t r = 0; r < rays.size(); ++r) {
    float* value = &values[places[r] * stride()];
    *value++ = shares[r];
    sum.reset();
    sum.add(samples[r]);
    for (int b = 0; b < bands_; ++b) {
      const PixelBand band = sum.band(b);
      *value++ = static_cast<float>(band.transmission);
      *value++ = static_cast<float>(band.radiance);
      *value++ = static_cast<float>(band.variance);
    }
  }
  return counts;
}

}  // namespace obscura
