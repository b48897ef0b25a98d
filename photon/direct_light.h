// Light that has not been scattered or reflected yet, at a point that scatters or reflects it: one shadow
// ray for each kind of source. The same for a point of a cloud and of a surface.
#pragma once

#include <vector>

#include "photon/radiance.h"
#include "photon/sampling.h"
#include "photon/scatter.h"
#include "photon/world.h"

namespace obscura::detail {

/// A point in a cloud, seen along a ray. Directions `toward` are where light comes from.
class CloudScatterer {
 public:
  CloudScatterer(const World& world, int interval, const Ray& ray, double t) noexcept
      : position_(ray.at(t)), along_(ray.direction), scattering_(world, interval, position_) {}

  const Vec3d& position() const noexcept { return position_; }
  FaceId from() const noexcept { return {}; }
  /// Radiance sent back along the ray per radiance that arrives from there and solid angle, 1/sr.
  double value(const Vec3d& toward) const noexcept { return scattering_.phase(toward.dot(along_)); }
  /// A direction in proportion to value(), or near to it.
  Vec3d sample(Stream& stream) const noexcept {
    const double u = stream.uniform();
    const double v = stream.uniform();
    return scattering_.sample(along_, u, v, stream.uniform());
  }
  /// Density of sample(), 1/sr, where value() is the given one.
  double density(const Vec3d&, double value) const noexcept { return value; }
  const LocalScattering& scattering() const noexcept { return scattering_; }

 private:
  Vec3d position_;
  Vec3d along_;
  LocalScattering scattering_;
};

/// A point on a surface that is seen from above.
class SurfaceScatterer {
 public:
  explicit SurfaceScatterer(const SurfacePoint& at) noexcept : at_(&at) {}

  const Vec3d& position() const noexcept { return at_->position; }
  FaceId from() const noexcept { return at_->id; }
  double value(const Vec3d& toward) const noexcept {
    const double cosine = toward.dot(at_->normal);
    return cosine > 0 ? at_->material->diffuse(cosine, at_->cosine) * cosine : 0.0;
  }
  Vec3d sample(Stream& stream) const noexcept {
    const double u = stream.uniform();
    return cosine_direction(at_->normal, u, stream.uniform());
  }
  double density(const Vec3d& toward, double) const noexcept { return toward.dot(at_->normal) / kPi; }

 private:
  const SurfacePoint* at_;
};

/// Where the light of one shadow ray goes if no cloud is in the way.
struct Shadow {
  std::uint32_t owner;    ///< the camera ray
  double radiance;        ///< what it adds there, W/m2/sr
  double air_weight = 0;  ///< what the air's own light along the ray counts there
  double target_depth = 0;  ///< of the clouds, exponentially distributed: where the air's light begins
};

/// Where on the discs of sun and moon a ray looks. Rays of consecutive numbers look at opposite places, so
/// that what varies evenly over a disc cancels.
class DiscPlaces {
 public:
  DiscPlaces(std::uint64_t seed, std::uint64_t history, std::uint32_t purpose) noexcept
      : stream_(seed, history >> 1, purpose), opposite_(history & 1) {}
  Vec3d toward(const Sun& sun) noexcept {
    const double u = stream_.uniform();
    const double v = stream_.uniform() + (opposite_ ? 0.5 : 0.0);
    return cone_direction(sun.toward, std::sin(0.5 * sun.diameter), u, v).first;
  }

 private:
  Stream stream_;
  bool opposite_;
};

/// Shadow rays of many points, to be attenuated together.
class DirectLight {
 public:
  DirectLight(const World& world, int interval, const RadianceParts& parts);

  bool empty() const noexcept { return !suns_ && !ambient_ && !faces_ && spheres_ == 0; }

  /// Asks all sources once for the light at a point.
  /// @param weight what the scattered radiance counts at the camera ray
  template <class Scatterer>
  void add(std::uint32_t owner, double weight, const Scatterer& at, Stream& stream, DiscPlaces discs) {
    const double t_min = at.from().exists() ? world_.surfaces().clearance() : 0.0;
    if (suns_) {
      add_suns(owner, weight, at.position(), at.from(), stream, discs, [&](const Vec3d& w) { return at.value(w); });
    }
    if (ambient_ || faces_) {
      // Where the scatterer would have it from: the sky, or what a surface emits there.
      const Vec3d toward = at.sample(stream);
      const double value = at.value(toward);
      const double density = at.density(toward, value);
      Ray ray{at.position(), toward, t_min, kInfinity};
      const SurfaceHit hit = world_.meet(ray, at.from(), stream);
      ray.t_max = hit.t;
      const double depth = air_ > 0 ? -std::log(stream.uniform()) : 0.0;
      if (value > 0) shoot_sampled(owner, weight * value / density, density, ray, hit, depth);
    }
    if (faces_) {
      // Where the emitting faces are. Both ways count by the balance heuristic (Veach, 1997).
      const double u = stream.uniform(), v = stream.uniform(), w = stream.uniform();
      const FaceLights& lights = world_.face_lights(interval_);
      const FaceLights::Place place = lights.sample(world_, u, v, w);
      const Vec3d way = place.position - at.position();
      const double distance = way.length();
      const Vec3d toward = distance > 0 ? way / distance : Vec3d(0);
      const double cosine = -toward.dot(place.normal);
      const double value = cosine > 0 ? at.value(toward) : 0.0;
      if (value > 0) {
        const double density = lights.density(world_, place.id) * distance * distance / cosine;
        const double emission = lights.emission(world_, place, cosine);
        const Ray ray{at.position(), toward, t_min, distance * (1 - 1e-10) - world_.surfaces().clearance()};
        if (ray.t_max > t_min && !world_.blocked(ray, at.from(), stream)) {
          shoot(owner, weight * value * emission / (density + at.density(toward, value)) * air(distance), ray);
        }
      }
    }
    for (std::size_t s = 0; s < spheres_; ++s) {
      const HotSphere& sphere = world_.spheres()[s];
      const Vec3d to_center = sphere.center - at.position();
      const double distance = to_center.length();
      if (distance <= sphere.radius) continue;
      const double u = stream.uniform();
      const auto [toward, solid_angle] =
          cone_direction(to_center / distance, sphere.radius / distance, u, stream.uniform());
      const double radiance = at.value(toward) * sphere.radiance[static_cast<std::size_t>(interval_)] * solid_angle;
      Ray ray{at.position(), toward, t_min, kInfinity};
      const SurfaceHit hit = world_.meet(ray, at.from(), stream);
      // At the very limb rounding may miss it: the ray then ends where the limb is.
      if (hit.exists() && hit.id.surface != world_.objects().size() + s && hit.t < distance) continue;
      ray.t_max = std::min(hit.t, distance);
      shoot(owner, weight * radiance * air(ray.t_max), ray);
    }
  }

  /// Sun and moon alone.
  /// @param value callable: where the light comes from -> 1/sr
  template <class Value>
  void add_suns(std::uint32_t owner, double weight, const Vec3d& position, FaceId from, Stream& stream,
                DiscPlaces discs, Value&& value) {
    const double t_min = from.exists() ? world_.surfaces().clearance() : 0.0;
    for (const Sun& sun : world_.suns()) {
      const Vec3d toward = discs.toward(sun);
      const double radiance = value(toward) * sun.irradiance[static_cast<std::size_t>(interval_)];
      const Ray ray{position, toward, t_min, kInfinity};
      if (radiance > 0 && !world_.blocked(ray, from, stream)) shoot(owner, weight * radiance, ray);
    }
  }
  bool suns() const noexcept { return suns_; }

  /// Lets the clouds attenuate everything and adds it to the camera rays. Returns the number of rays.
  std::size_t arrive(std::span<Incoming> incoming);

 private:
  double air(double distance) const noexcept { return air_ > 0 ? std::exp(-air_ * distance) : 1.0; }
  void shoot(std::uint32_t owner, double radiance, const Ray& ray, double air_weight = 0, double target_depth = 0);
  void shoot_sampled(std::uint32_t owner, double weight, double density, const Ray& ray, const SurfaceHit& hit,
                     double target_depth);
  void add_air(std::span<Incoming> incoming) const;

  const World& world_;
  int interval_;
  double air_;
  bool suns_;
  bool ambient_;  // sky, or the air's own light
  bool faces_;
  bool sky_;
  std::size_t spheres_;
  std::vector<Ray> rays_;
  std::vector<Shadow> shadows_;
};

/// Light along a ray through clouds and air that are not at its end, W/m2/sr: exact segment by segment.
/// The clouds' own emission, and the air's, of which the clouds hide what is behind them.
double light_along(const World& world, int interval, const Ray& ray) noexcept;

}  // namespace obscura::detail
