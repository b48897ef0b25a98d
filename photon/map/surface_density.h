// The density estimate on surfaces: from the photons around a point to the light that its side reflects.
#pragma once

#include "photon/map/density.h"
#include "photon/world/spectral_world.h"

namespace obscura {
namespace detail {

/// Kernel over the unit disc, normalised: value at u = (distance / radius)^2.
double disc_kernel(Kernel kernel, double u) noexcept;

/// Points of the unit disc, as dense as the kernel is high.
struct DiscPoint {
  double x, y;
};
std::span<const DiscPoint, kRoundPoints> disc_points(Kernel kernel) noexcept;

/// How much surface there is in the disc around a point on which photons can have landed that count there: of the
/// point's own side, visible from it, and turned alike. 1 is a plane that fills the disc; less at edges, more where it
/// is curved.
struct DiscCover {
  double whole = 0;  ///< under the kernel of the disc's radius
  double inner = 0;  ///< under that of radius / sqrt 2
};
/// @param flat  no face stands up in the disc
DiscCover disc_cover(SpectralWorld world, const SurfacePoint& at, double radius, Kernel kernel, bool flat,
                     const Vec3d& key) noexcept;

/// Whether a place near a surface point, on a side with this normal, belongs to the same side.
bool same_side(const SurfacePoint& at, double radius, const Vec3d& place, const Vec3d& normal) noexcept;
/// Whether nothing stands between two places on a surface.
bool in_sight(const Surfaces& surfaces, const SurfacePoint& at, const Vec3d& place, const Vec3d& normal) noexcept;

}  // namespace detail

/// Light that arrives at a side of a surface, weighted: with weight 1 the irradiance (W/m2), with a BRDF
/// (1/sr) of the photons' directions the reflected radiance (W/m2/sr).
/// @param map    of light at surfaces; not periodic
/// @param weight double(const Vec3d& direction): what light that travels there counts
/// @param key    names the random turn of the rays that measure the surface
template <class Weight>
Estimate surface_estimate(SpectralWorld world, const PhotonMap& map, const SurfacePoint& at, const Weight& weight,
                          const GatherSettings& settings, const Vec3d& key) noexcept {
  Estimate result;
  // The disc, as in the volume: the k-th neighbour gives the radius and is not counted.
  const Vec3d x = transform_point(world->world_to_map(), at.position);
  const Vec3f local = map.local(x);
  const double reach = settings.max_radius_m;
  Nearest nearest(settings.nearest, static_cast<float>(reach * reach));
  map.nearest(local, nearest);
  if (nearest.full() && nearest.all_equal()) {
    nearest = Nearest(Nearest::kMax, static_cast<float>(reach * reach));
    map.nearest(local, nearest);
  }
  if (nearest.count() == 0) return result;
  const bool cut = !nearest.full() && std::isfinite(reach);
  const double rim = cut ? reach * reach : static_cast<double>(nearest.distance2(nearest.count() - 1));
  const double radius = result.radius = std::sqrt(rim);
  if (!(radius > 0) || (!cut && nearest.all_equal())) return result;

  const bool flat = world->surfaces().flat(at.position, at.normal, radius);
  const detail::DiscCover cover = detail::disc_cover(world, at, radius, settings.kernel, flat, key);
  double inner_sum = 0;
  for (int i = 0; i < nearest.count(); ++i) {
    const double distance2 = nearest.distance2(i);
    if (!(distance2 < rim)) continue;
    const Photon& photon = map.photon(nearest.index(i));
    const Vec3d place = transform_point(world->map_to_world(), x + Vec3d(map.offset(local, nearest.index(i))));
    const Vec3d normal = decode_normal(photon.collisions);
    if (!detail::same_side(at, radius, place, normal)) continue;
    if (!flat && !detail::in_sight(world->surfaces(), at, place, normal)) continue;
    ++result.photons;
    const double u = distance2 / rim;
    const double light = photon.power * weight(decode_direction(photon.direction));
    result.batch[photon.batch % kBatches] += light * detail::disc_kernel(settings.kernel, u);
    if (2 * u < 1) inner_sum += 2 * light * detail::disc_kernel(settings.kernel, 2 * u);
  }
  const double norm = 1 / rim;
  double sum = 0;
  for (double& batch : result.batch) {
    batch *= norm * kBatches / cover.whole;
    sum += batch;
  }
  result.value = sum / kBatches;
  result.bias = 2 * (result.value - inner_sum * norm / cover.inner);
  return result;
}

}  // namespace obscura
