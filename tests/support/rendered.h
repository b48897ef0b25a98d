// A film by the pass along rays with any settings of it, beside what methods make of them.
#pragma once

#include "photon/paths/radiance.h"
#include "sensor/capture/render.h"

namespace obscura::test {

/// @param maps one per spectral interval, or none: direct light only, unless the settings ask for all bounces
inline RadianceEstimator by_pass(const World& world, std::span<const PhotonMaps> maps,
                                 const RadianceSettings& radiance) {
  return [&world, maps, radiance](int interval, const RayShare& share, std::span<const Ray> rays,
                                  std::span<const std::uint64_t> histories, std::span<Incoming> incoming) {
    RadianceSettings settings = radiance;
    settings.footprint = share.footprint;
    if (share.paths > 0) settings.points = share.paths;
    const PhotonMaps* map = maps.empty() ? nullptr : &maps[static_cast<std::size_t>(interval)];
    return incoming_radiance({world, interval}, map, settings, rays, histories, incoming);
  };
}

inline Rendered render_pass(const World& world, std::span<const PhotonMaps> maps, const Camera& camera,
                            const SamplerSettings& sampling, const RadianceSettings& radiance,
                            const Progress& progress = {}) {
  return render(world, by_pass(world, maps, radiance), camera, sampling, progress);
}

}  // namespace obscura::test
