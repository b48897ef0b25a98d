// From a World and a way to estimate radiance to a film: hands out rays tile by tile and adds up what they
// bring home.
#pragma once

#include <span>

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
};

/// The same bits for any number of threads. Cancelled: the tiles that were finished, film.partial().
Rendered render(const World& world, const Estimator& estimator, const Camera& camera, const SamplerSettings& sampling,
                const Progress& progress = {});

/// By photon maps.
/// @param maps one per spectral interval of the World, or none: direct light only
Rendered render(const World& world, std::span<const PhotonMaps> maps, const Camera& camera,
                const SamplerSettings& sampling, const RadianceSettings& radiance, const Progress& progress = {});

}  // namespace obscura
