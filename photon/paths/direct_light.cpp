#include "photon/paths/direct_light.h"

#include "photon/optics/transfer.h"
#include "photon/world/world_walk.h"

namespace obscura::detail {

namespace {

/// The depth up to which no shadow ray ends by roulette. Beyond it the ray survives as a free path does; one that
/// arrives counts exp(-kSureDepth).
constexpr double kSureDepth = 2;

}  // namespace

DirectLight::DirectLight(SpectralWorld world, const RadianceParts& parts, WorkCounts& work, bool roulette)
    : world_(world),
      work_(work),
      air_(world.air_extinction()),
      attenuates_(world.attenuates()),
      masked_(!world->surfaces().empty()),
      roulette_(roulette) {
  suns_ = false;
  for (const Sun& sun : world->suns()) {
    suns_ = suns_ || (parts.sun && world.value_of(sun.irradiance) > 0);
  }
  sky_ = parts.sky && world.sky() > 0;
  ambient_ = sky_ || (parts.emission && air_ > 0);
  faces_ = parts.surfaces && !world.face_lights().empty();
  spheres_ = parts.spheres ? world->source_count() : 0;
  if (parts.spheres) all_spheres_ = SphereLights(world);
  beams_ = parts.map ? world->beams().size() : 0;
}

SphereLights::SphereLights(SpectralWorld world) {
  double sum = 0;
  for (const HotSphere& sphere : world->spheres()) {
    sum += sphere.radius * sphere.radius * world.value_of(sphere.radiance);
    sums_.push_back(sum);
  }
  if (!(sum > 0)) sums_.clear();
}

double DirectLight::discs_found(const Vec3d& toward, double density) const noexcept {
  if (!suns_) return 0;
  double radiance = 0;
  for (const Sun& sun : world_->suns()) {
    if (!sun.covers(toward)) continue;
    const double other = solid_angle(sun) * density;
    radiance += sun.radiance(world_.interval()) * (other < kInfinity ? other / (1 + other) : 1.0);
  }
  return radiance;
}

double DirectLight::face_found(const SurfacePoint& there, double t, double density) const noexcept {
  const double radiance = faces_ ? there.emission(there.cosine) : 0.0;
  if (!(radiance > 0) || density == kInfinity) return radiance;
  const double other = world_.face_lights().density(world_, there.id) * t * t / there.cosine;
  return radiance * density / (density + other);
}

double DirectLight::sphere_found(const Vec3d& from, const SurfacePoint& there, double density) const noexcept {
  if (all_spheres_.empty() || density == kInfinity) return all_spheres_.empty() ? 0.0 : there.black;
  const std::size_t s = there.id.surface - world_->objects().size();
  const HotSphere& sphere = world_->spheres()[s];
  const double sine = std::min(1.0, sphere.radius / (sphere.center - from).length());
  const double solid_angle = 2 * kPi * sine * sine / (1 + std::sqrt(1 - sine * sine));
  return there.black * density / (density + all_spheres_.chance(s) / solid_angle);
}

void DirectLight::shoot(std::uint32_t owner, double radiance, const Ray& ray, Stream& stream, double air_weight,
                        double target_depth) {
  if (!(radiance > 0) && !(air_weight > 0)) return;
  rays_.push_back(ray);
  const double last_depth = roulette_ ? kSureDepth - std::log(stream.uniform()) : kInfinity;
  shadows_.push_back({owner, radiance, air_weight, target_depth, last_depth});
}

void DirectLight::shoot_drawn(std::uint32_t owner, double weight, double density, const Ray& ray, const SurfaceHit& hit,
                              double target_depth, Stream& stream) {
  const double air_weight = air_ > 0 ? weight : 0.0;
  if (!hit.exists()) {
    shoot(owner, sky_ ? weight * world_.sky() : 0.0, ray, stream, air_weight, target_depth);
    return;
  }
  double radiance = 0;
  if (hit.id.surface < world_->objects().size()) {
    radiance = face_found(world_.surface_at(ray, hit), hit.t, density);
  }
  radiance *= air(hit.t);
  shoot(owner, weight * radiance, ray, stream, air_weight, target_depth);
}

void DirectLight::attenuate() {
  if (rays_.empty()) return;
  if (attenuates_) work_[Work::extinction] += rays_.size();
  if (!attenuates_) {
    for (const Shadow& shadow : shadows_) arrived_.emplace_back(shadow.owner, shadow.radiance);
  } else if (roulette_) {
    std::vector<Flight> flights(rays_.size());
    for (std::size_t s = 0; s < rays_.size(); ++s) flights[s] = {rays_[s], shadows_[s].last_depth};
    std::vector<FreePath> ends(flights.size());
    world_.reach_depths(flights, ends);
    for (std::size_t s = 0; s < rays_.size(); ++s) {
      if (ends[s].collided) continue;
      arrived_.emplace_back(shadows_[s].owner, shadows_[s].radiance * std::exp(-std::min(ends[s].depth, kSureDepth)));
    }
  } else {
    std::vector<double> depths(rays_.size());
    world_.optical_depths(rays_, depths);
    for (std::size_t s = 0; s < rays_.size(); ++s) {
      arrived_.emplace_back(shadows_[s].owner, shadows_[s].radiance * std::exp(-depths[s]));
    }
  }
  if (air_ > 0) add_air();
}

void DirectLight::add_air() {
  // The air glows from the point to where the first thing hides what is behind: a cloud, by chance with
  // the probability of a collision, or a surface. Behind nothing there is the sky, which is given whole.
  std::vector<Flight> flights;
  std::vector<const Shadow*> shadows;
  for (std::size_t s = 0; s < rays_.size(); ++s) {
    if (!(shadows_[s].air_weight > 0)) continue;
    flights.push_back({rays_[s], shadows_[s].target_depth});
    shadows.push_back(&shadows_[s]);
  }
  work_[Work::atmosphere] += flights.size();
  std::vector<FreePath> ends(flights.size());
  if (attenuates_) world_.reach_depths(flights, ends);
  for (std::size_t i = 0; i < flights.size(); ++i) {
    const double end = ends[i].collided ? ends[i].t : flights[i].ray.t_max;
    if (end == kInfinity) continue;
    arrived_.emplace_back(shadows[i]->owner,
                          shadows[i]->air_weight * world_.air_radiance() * one_minus_exp(air_ * end));
  }
}

namespace {

/// The segments of one cloud that does not repeat: nothing has to be merged.
class PlainWalk {
 public:
  PlainWalk(SpectralWorld world, const Ray& ray) noexcept
      : optics_(world.optics(0)),
        walk_(*world->clouds()[0].octree, transform_ray(world->frame(0).world_to_index, ray)) {}
  bool next() noexcept {
    while (walk_.next()) {
      if (!walk_.empty()) return true;
    }
    return false;
  }
  double begin() const noexcept { return walk_.begin(); }
  double end() const noexcept { return walk_.end(); }
  LocalOptics optics() const noexcept {
    return optics_.at([this](int channel) noexcept { return walk_.value(channel); });
  }

 private:
  const CloudOptics& optics_;
  Walk walk_;
};

/// @param walk WorldWalk or what is like it
template <bool kAir, bool kCoarse, class Segments>
[[gnu::flatten]] double sum_along(Segments&& walk, double extinction, double black, CoarseCells* coarse,
                                  double& total) noexcept {
  double radiance = 0;
  double transmission = 1;
  while (walk.next() && transmission > 0) {
    const LocalOptics local = walk.optics();
    const double length = walk.end() - walk.begin();
    const double depth = local.extinction * length;
    double source = local.emission;
    double seen = transmission;
    if constexpr (kAir) {
      // What the cloud hides of the air behind is as bright as the air in front of it: photon/METHODS.md, "Atmosphere".
      radiance += transmission * one_minus_exp(depth) * black;
      source -= local.extinction * black;
      seen *= std::exp(-extinction * walk.begin());
    }
    radiance += seen * source * length * mean_transmission(kAir ? depth + extinction * length : depth);
    transmission *= std::exp(-depth);
    total += depth;
    if constexpr (kCoarse) coarse->passed(depth, transmission);
  }
  return radiance;
}

}  // namespace

double light_along(SpectralWorld world, const Ray& ray, CoarseCells* coarse, double* depth) noexcept {
  const double extinction = world.air_extinction();
  const double black = world.air_radiance();
  const bool air = extinction > 0;
  double total = 0, radiance = 0;
  if (coarse) {
    radiance = air ? sum_along<true, true>(WorldWalk(world, ray, coarse), extinction, black, coarse, total)
                   : sum_along<false, true>(WorldWalk(world, ray, coarse), 0, 0, coarse, total);
  } else if (world->cloud_count() == 1 && !world->periodic()) {
    radiance = air ? sum_along<true, false>(PlainWalk(world, ray), extinction, black, nullptr, total)
                   : sum_along<false, false>(PlainWalk(world, ray), 0, 0, nullptr, total);
  } else {
    radiance = air ? sum_along<true, false>(WorldWalk(world, ray), extinction, black, nullptr, total)
                   : sum_along<false, false>(WorldWalk(world, ray), 0, 0, nullptr, total);
  }
  if (depth) *depth = total;
  return radiance;
}

}  // namespace obscura::detail
