#include "sensor/capture/sampler.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "photon/optics/purpose.h"

namespace obscura {

Sampler::Sampler(const Camera& camera, const SamplerSettings& settings) : camera_(&camera), settings_(settings) {
  assert(settings.max_oversampling >= 1);
  for (int i = 0; i < settings.max_oversampling; ++i) strata_.push_back(stratum(i, settings.max_oversampling));
}

void Sampler::rays(int x, int y, std::span<const Stratum> strata, int first, std::vector<PixelRay>& rays) const {
  const auto columns = static_cast<std::uint64_t>(camera_->columns());
  const std::uint64_t pixels = columns * static_cast<std::uint64_t>(camera_->rows());
  const std::uint64_t pixel =
      settings_.pass * pixels + static_cast<std::uint64_t>(y) * columns + static_cast<std::uint64_t>(x);
  std::uint64_t history =
      pixel * static_cast<std::uint64_t>(settings_.max_oversampling) + static_cast<std::uint64_t>(first);
  for (const Stratum& cell : strata) {
    Stream stream = StreamName{settings_.seed, history, Purpose::pixel}.stream();
    PixelRay ray;
    ray.px = x + cell.x_min + cell.width * stream.uniform();
    ray.py = y + cell.y_min + cell.height * stream.uniform();
    ray.ray = camera_->ray(ray.px, ray.py);
    ray.history = history++;
    rays.push_back(ray);
  }
}

RayShare Sampler::share(double of_pixel) const noexcept {
  RayShare share{camera_->footprint(of_pixel), 0};
  if (settings_.samples > 0)
    share.paths = std::clamp(static_cast<int>(std::ceil(of_pixel * settings_.samples - 1e-9)), 1, kMostPoints);
  return share;
}

}  // namespace obscura
