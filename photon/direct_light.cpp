#include "photon/direct_light.h"

#include "photon/transfer.h"
#include "photon/world_walk.h"

namespace obscura::detail {

DirectLight::DirectLight(const World& world, int interval, const RadianceParts& parts)
    : world_(world), interval_(interval), air_(world.air_extinction(interval)) {
  suns_ = false;
  for (const Sun& sun : world.suns()) {
    suns_ = suns_ || (parts.sun && sun.irradiance[static_cast<std::size_t>(interval)] > 0);
  }
  sky_ = parts.sky && world.sky(interval) > 0;
  ambient_ = sky_ || (parts.emission && air_ > 0);
  faces_ = parts.surfaces && !world.face_lights(interval).empty();
  spheres_ = parts.spheres ? world.source_count() : 0;
}

void DirectLight::shoot(std::uint32_t owner, double radiance, const Ray& ray, double air_weight,
                        double target_depth) {
  if (!(radiance > 0) && !(air_weight > 0)) return;
  rays_.push_back(ray);
  shadows_.push_back({owner, radiance, air_weight, target_depth});
}

void DirectLight::shoot_sampled(std::uint32_t owner, double weight, double density, const Ray& ray,
                                const SurfaceHit& hit, double target_depth) {
  const double air_weight = air_ > 0 ? weight : 0.0;
  if (!hit.exists()) {
    shoot(owner, sky_ ? weight * world_.sky(interval_) : 0.0, ray, air_weight, target_depth);
    return;
  }
  double radiance = 0;
  if (hit.id.surface < world_.objects().size()) {
    const SurfacePoint there = world_.surface_at(interval_, ray, hit);
    radiance = faces_ ? there.emission(there.cosine) : 0.0;
    if (radiance > 0) {
      const double other = world_.face_lights(interval_).density(world_, hit.id) * hit.t * hit.t / there.cosine;
      radiance *= density / (density + other);
    }
  }
  radiance *= air(hit.t);
  shoot(owner, weight * radiance, ray, air_weight, target_depth);
}

std::size_t DirectLight::arrive(std::span<Incoming> incoming) {
  std::vector<double> depths(rays_.size());
  world_.optical_depths(interval_, rays_, depths);
  for (std::size_t s = 0; s < rays_.size(); ++s) {
    incoming[shadows_[s].owner].direct += shadows_[s].radiance * std::exp(-depths[s]);
  }
  if (air_ > 0) add_air(incoming);
  const std::size_t count = rays_.size();
  rays_.clear();
  shadows_.clear();
  return count;
}

void DirectLight::add_air(std::span<Incoming> incoming) const {
  // The air glows from the point to where the first thing hides what is behind: a cloud, by chance with
  // the probability of a collision, or a surface. Behind nothing there is the sky, which is given whole.
  std::vector<Flight> flights;
  std::vector<const Shadow*> shadows;
  for (std::size_t s = 0; s < rays_.size(); ++s) {
    if (!(shadows_[s].air_weight > 0)) continue;
    flights.push_back({rays_[s], shadows_[s].target_depth});
    shadows.push_back(&shadows_[s]);
  }
  std::vector<FreePath> ends(flights.size());
  world_.reach_depths(interval_, flights, ends);
  for (std::size_t i = 0; i < flights.size(); ++i) {
    const double end = ends[i].collided ? ends[i].t : flights[i].ray.t_max;
    if (end == kInfinity) continue;
    incoming[shadows[i]->owner].direct += shadows[i]->air_weight * world_.air_radiance(interval_) * one_minus_exp(air_ * end);
  }
}

double light_along(const World& world, int interval, const Ray& ray) noexcept {
  const double extinction = world.air_extinction(interval);
  const double black = world.air_radiance(interval);
  double radiance = 0;
  double transmission = 1;
  WorldWalk walk(world, interval, ray);
  while (walk.next() && transmission > 0) {
    const LocalOptics& local = walk.optics();
    const double length = walk.end() - walk.begin();
    const double depth = local.extinction * length;
    double source = local.emission;
    double seen = transmission;
    if (extinction > 0) {
      // What the cloud hides of the air behind is as bright as the air in front of it: METHODS.md.
      radiance += transmission * one_minus_exp(depth) * black;
      source -= local.extinction * black;
      seen *= std::exp(-extinction * walk.begin());
    }
    radiance += seen * source * length * mean_transmission(depth + extinction * length);
    transmission *= std::exp(-depth);
  }
  return radiance;
}

}  // namespace obscura::detail
