// From World and photon maps to a film: hands out rays tile by tile and adds up what they bring home.
#pragma once

#include <span>

#include "octree/base/progress.h"
#include "photon/radiance.h"
#include "sensor/camera.h"
#include "sensor/film.h"
#include "sensor/sampler.h"

namespace obscura {

struct Rendered {
  Film film;
  RadianceCounts counts;  ///< over all rays and spectral intervals
};

/// The same bits for any number of threads. Cancelled: the tiles that were finished, film.partial().
/// @param maps one per spectral interval of the World, or none: direct light only
Rendered render(const World& world, std::span<const PhotonMaps> maps, const Camera& camera,
                const SamplerSettings& sampling, const RadianceSettings& radiance,
                const Progress& progress = {});

}  // namespace obscura
