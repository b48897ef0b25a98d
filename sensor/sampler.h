// The sampler: which rays a pixel gets. It hands them out one by one and is told what each met, so
// that a sampler which refines where the picture varies can take its place.
#pragma once

#include <cstdint>
#include <optional>

#include "octree/base/random.h"
#include "sensor/camera.h"
#include "sensor/sample.h"

namespace obscura {

struct SamplerSettings {
  /// Rays per pixel, at most; every pixel gets as many.
  int max_oversampling = 16;
  std::uint64_t seed = 1;
  /// Passes over one image with different numbers draw different rays.
  std::uint32_t pass = 0;
};

struct PixelRay {
  /// Place on the image.
  double px, py;
  /// Nothing where the camera has no direction: such a ray meets nothing (a RaySample as reset).
  std::optional<Ray> ray;
  /// Unlike that of any other ray of this seed: names the random numbers drawn along it.
  std::uint64_t history;
};

/// The rays of one pixel, in fixed order:
///
///     for (PixelRays rays = sampler.pixel(x, y); auto ray = rays.next();) rays.met(trace(*ray));
class PixelRays {
 public:
  std::optional<PixelRay> next() noexcept;
  /// What the last ray met.
  void met(const RaySample&) noexcept {}

 private:
  friend class Sampler;
  PixelRays(const Camera& camera, int x, int y, int count, std::uint64_t first_history,
            Stream stream) noexcept
      : camera_(&camera), x_(x), y_(y), count_(count), history_(first_history), stream_(stream) {}

  const Camera* camera_;
  int x_, y_, count_;
  int index_ = 0;
  std::uint64_t history_;
  Stream stream_;
};

/// Cells of equal area that tile the unit square, as near to squares as `count` allows: rows of
/// equally many cells, or of one more (7 is rows of 2, 3 and 2). One jittered place in each makes an
/// unbiased stratified sample of any size.
struct Stratum {
  double x_min, y_min, width, height;
};
Stratum stratum(int index, int count) noexcept;

class Sampler {
 public:
  /// Keeps a reference to the camera. @pre max_oversampling >= 1
  Sampler(const Camera& camera, const SamplerSettings& settings);

  PixelRays pixel(int x, int y) const noexcept;

  /// The ray through the pixel's centre, which names its object.
  std::optional<Ray> centre(int x, int y) const noexcept { return camera_->ray(x + 0.5, y + 0.5); }

 private:
  const Camera* camera_;
  SamplerSettings settings_;
};

}  // namespace obscura
