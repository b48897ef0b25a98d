// The sampler: one jittered ray in each part of a pixel. Which parts, it is told (refine.h), or they are
// equal strata.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "octree/base/random.h"
#include "photon/methods/estimator.h"
#include "photon/spot/spot.h"
#include "sensor/capture/camera.h"
#include "sensor/capture/stratum.h"

namespace obscura {

/// What asks for more rays than one: thresholds of what may vary inside a spot. Nothing: not asked.
struct AdaptiveSettings {
  SpotThresholds geometry;
  std::optional<double> shadow = 0.05;        ///< share of the sun's light that reaches the surface
  std::optional<double> transmission = 0.05;  ///< of the clouds
  std::optional<double> radiance = 0.05;      ///< relative, beyond the deciding rays' own noise
  /// Relative standard error above which a pixel gets more rays, whatever it shows.
  std::optional<double> error;
  int specular_depth = 4;  ///< mirrors that are looked behind
};

struct SamplerSettings {
  /// Rays per pixel, at most; without `adaptive` every pixel gets as many.
  int max_oversampling = 16;
  std::optional<AdaptiveSettings> adaptive = std::nullopt;
  /// Points or paths per pixel, over all its rays, each of which gets its area's share; 0: every ray as many as the
  /// method has by itself.
  int samples = 0;
  std::uint64_t seed = 1;
  /// Passes over one image with different numbers draw different rays.
  std::uint32_t pass = 0;
  /// Tiles of the film to be done; none: all.
  std::vector<int> tiles = {};
};

struct PixelRay {
  /// Place on the image.
  double px, py;
  /// Nothing where the camera has no direction: such a ray meets nothing (a RaySample as reset).
  std::optional<Ray> ray;
  /// Unlike that of any other ray of this seed: names the random numbers drawn along it.
  std::uint64_t history;
};

class Sampler {
 public:
  /// Keeps a reference to the camera. @pre max_oversampling >= 1
  Sampler(const Camera& camera, const SamplerSettings& settings);

  /// All strata of a pixel that is sampled alike everywhere.
  std::span<const Stratum> strata() const noexcept { return strata_; }

  /// Appends a ray in each stratum of the pixel, in their order.
  /// @param first number of the first of them among the pixel's rays, of which there are at most max_oversampling
  void rays(int x, int y, std::span<const Stratum> strata, int first, std::vector<PixelRay>& rays) const;

  /// The ray through the pixel's centre, which names its object.
  std::optional<Ray> centre(int x, int y) const noexcept { return camera_->ray(x + 0.5, y + 0.5); }

  /// What rays stand for that have a share of their pixel, (0, 1].
  RayShare share(double of_pixel) const noexcept;

  const Camera& camera() const noexcept { return *camera_; }
  const SamplerSettings& settings() const noexcept { return settings_; }

 private:
  const Camera* camera_;
  SamplerSettings settings_;
  std::vector<Stratum> strata_;
};

}  // namespace obscura
