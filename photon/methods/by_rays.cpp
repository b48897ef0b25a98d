#include "photon/methods/by_rays.h"

#include "photon/paths/fluence.h"

namespace obscura::detail {

RadianceSettings radiance_settings(const Method& method, const EstimatorSettings& settings) {
  RadianceSettings radiance;
  radiance.gather.nearest = method.nearest;
  radiance.gather.kernel = method.kernel;
  radiance.specular_depth = method.specular_depth;
  radiance.scattering_depth = settings.scattering ? method.scattering_depth : std::optional(0);
  radiance.seed = settings.seed;
  radiance.footprint_tolerance = settings.footprint_tolerance;
  radiance.points = settings.paths_per_ray;
  return radiance;
}

void answer_by_rays(const World& world, const RadianceSettings& settings, std::shared_ptr<const Light> light,
                    Estimator& estimator) {
  const auto maps_of = [light](int interval) -> const PhotonMaps* {
    return light && !light->maps.empty() ? &light->maps[static_cast<std::size_t>(interval)] : nullptr;
  };
  estimator.radiance = [&world, settings, maps_of](int interval, const RayShare& share, std::span<const Ray> rays,
                                                   std::span<const std::uint64_t> histories,
                                                   std::span<Incoming> incoming) {
    RadianceSettings here = settings;
    here.footprint = share.footprint;
    if (share.paths > 0) here.points = share.paths;
    return incoming_radiance({world, interval}, maps_of(interval), here, rays, histories, incoming);
  };
  estimator.fluence = [&world, settings, maps_of](int band, const Vec3d& point, int directions, std::uint64_t history) {
    Measured sum;
    for (int i = 0; i < world.interval_count(); ++i) {
      if (world.interval(i).band != band) continue;
      const PhotonMaps* maps = maps_of(i);
      const Fluence here = fluence({world, i}, maps, settings, point, directions, history);
      sum.value += here.mean;
      sum.error = std::hypot(sum.error, here.standard_error);
      sum.bias += std::abs(here.bias);
      if (maps) sum.freedom = kBatches - 1.0;
    }
    return sum;
  };
}

}  // namespace obscura::detail
