// What the photon maps know of the light at a point that scatters or reflects it along a ray.
#pragma once

#include "photon/map/surface_density.h"
#include "photon/paths/boundary_layer.h"
#include "photon/paths/direct_light.h"

namespace obscura::detail {

/// What a point of the map's frame can see of its surroundings, which end at surfaces. The random rotation of the
/// cubature is named by the ray and not by the place, so that rounding of the place changes no result.
struct MapSurroundings {
  const World& world;
  Vec3d ray_key;

  Vec3d key(const Vec3d&) const noexcept { return ray_key; }

  bool obstructed(const Vec3d& x, double radius) const noexcept {
    return !world.surfaces().empty() && world.surfaces().near(transform_point(world.map_to_world(), x), radius);
  }
  bool sees(const Vec3d& x, const Vec3d& y) const noexcept {
    const Vec3d way = y - x;
    const double distance = way.length();
    return !(distance > 0) ||
           !world.surfaces().occluded({transform_point(world.map_to_world(), x),
                                       transform_direction(world.map_to_world(), way / distance), 0, distance});
  }
};

inline Estimate map_light(SpectralWorld world, const PhotonMaps& maps, const CloudScatterer& at,
                          const GatherSettings& settings, const Vec3d& key) noexcept {
  if (maps.volume.size() == 0) return {};
  const Vec3d outward = transform_direction(world->world_to_map(), -at.along());
  Estimate found = estimate(
      maps.volume, transform_point(world->world_to_map(), at.position()),
      [&](const Vec3d& y) noexcept { return world.extinction_in_map(y); },
      [&](const Vec3d& travel) noexcept { return at.scattering().phase_in_map(travel.dot(outward)); }, settings,
      MapSurroundings{*world, key});
  resolve_boundary_layer(world, at.position(), found);
  return found;
}

inline Estimate map_light(SpectralWorld world, const PhotonMaps& maps, const SurfaceScatterer& at,
                          const GatherSettings& settings, const Vec3d& key) noexcept {
  if (maps.surface.size() == 0) return {};
  return surface_estimate(
      world, maps.surface, at.point(), [&](const Vec3d& travel) noexcept { return at.brdf(-travel); }, settings, key);
}

}  // namespace obscura::detail
