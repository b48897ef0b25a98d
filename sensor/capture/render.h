// From a World and a way to estimate radiance to a film: hands out rays tile by tile and adds up what they
// bring home.
#pragma once

#include "octree/base/progress.h"
#include "sensor/capture/camera.h"
#include "sensor/capture/estimator.h"
#include "sensor/capture/film.h"
#include "sensor/capture/refine.h"
#include "sensor/capture/sampler.h"

namespace obscura {

struct Rendered {
  Film film;
  RadianceCounts counts;  ///< over all rays and spectral intervals
  RayCounts rays;

  /// Adds an independent pass over the same image.
  void merge(const Rendered& other);
};

/// The same bits for any number of threads. Cancelled: the tiles that were finished, film.partial().
Rendered render(const World& world, const RadianceEstimator& estimator, const Camera& camera,
                const SamplerSettings& sampling, const Progress& progress = {});

}  // namespace obscura
