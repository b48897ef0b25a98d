// From a World and a way to estimate radiance to a film: hands out rays tile by tile and adds up what they
// bring home.
#pragma once

#include <functional>
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

/// What arrives at the start of each ray at one spectral interval. Called by many threads at once; the result
/// of a ray belongs to its history number.
using Estimator = std::function<RadianceCounts(int interval, std::span<const Ray> rays,
                                               std::span<const std::uint64_t> histories, std::span<Incoming> incoming)>;

/// The same bits for any number of threads. Cancelled: the tiles that were finished, film.partial().
Rendered render(const World& world, const Estimator& estimator, const Camera& camera, const SamplerSettings& sampling,
                const Progress& progress = {});

/// By photon maps.
/// @param maps one per spectral interval of the World, or none: direct light only
Rendered render(const World& world, std::span<const PhotonMaps> maps, const Camera& camera,
                const SamplerSettings& sampling, const RadianceSettings& radiance,
                const Progress& progress = {});

}  // namespace obscura
