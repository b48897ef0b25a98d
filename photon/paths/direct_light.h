// Light that has not been scattered or reflected yet, at a point that scatters or reflects it: one shadow
// ray for each kind of source. The same for a point of a cloud and of a surface.
#pragma once

#include <vector>

#include "photon/optics/purpose.h"
#include "photon/optics/sampling.h"
#include "photon/optics/transfer.h"
#include "photon/paths/radiance.h"
#include "photon/world/footprint.h"
#include "photon/world/scatter.h"
#include "photon/world/spectral_world.h"

namespace obscura::detail {

/// Weight of a drawn direction: value over density; 1 where the density is infinite, because no other direction was
/// possible.
inline double drawn_share(double value, double density) noexcept { return density < kInfinity ? value / density : 1.0; }

/// A point in a cloud, seen along a ray. Directions `toward` are where light comes from.
class CloudScatterer {
 public:
  CloudScatterer(SpectralWorld world, const Ray& ray, double t) noexcept
      : position_(ray.at(t)), along_(ray.direction), scattering_(LocalScattering::at_collision(world, position_)) {}

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
  /// Density of sample(), 1/sr, where value() is the given one. Infinite where it is 0, for then a phase function
  /// without a density (g = 1 or -1) has drawn the one direction that it has.
  double density(const Vec3d&, double value) const noexcept { return value > 0 ? value : kInfinity; }
  const LocalScattering& scattering() const noexcept { return scattering_; }
  const Vec3d& along() const noexcept { return along_; }

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
  const SurfacePoint& point() const noexcept { return *at_; }
  /// 1/sr
  double brdf(const Vec3d& toward) const noexcept {
    const double cosine = toward.dot(at_->normal);
    return cosine > 0 ? at_->material->diffuse(cosine, at_->cosine) : 0.0;
  }
  double value(const Vec3d& toward) const noexcept {
    const double cosine = toward.dot(at_->normal);
    return cosine > 0 ? at_->material->diffuse(cosine, at_->cosine) * cosine : 0.0;
  }
  Vec3d sample(Stream& stream) const noexcept {
    const double u = stream.uniform();
    return cosine_direction(at_->normal, u, stream.uniform());
  }
  double density(const Vec3d& toward, double) const noexcept { return std::max(0.0, toward.dot(at_->normal)) / kPi; }

 private:
  const SurfacePoint* at_;
};

/// A rough mirror as something that scatters the light of sun and moon alone.
struct RoughMirror {
  const SurfacePoint& at;
  Vec3d arriving;

  const Vec3d& position() const noexcept { return at.position; }
  FaceId from() const noexcept { return at.id; }
  double value(const Vec3d& toward) const noexcept {
    return rough_mirror(arriving, at.normal, at.material->roughness(), toward) * toward.dot(at.normal);
  }
  double density(const Vec3d&, double value) const noexcept { return value; }
};

/// Where the light of one shadow ray goes if no cloud is in the way.
struct Shadow {
  std::uint32_t owner;            ///< whose sum it adds to
  double radiance;                ///< what it adds there, W/m2/sr
  double air_weight = 0;          ///< what the air's own light along the ray counts there
  double target_depth = 0;        ///< of the clouds, exponentially distributed: where the air's light begins
  double last_depth = kInfinity;  ///< of the clouds, at which roulette ends the ray
};

/// Where on the discs of sun and moon a ray looks. Rays of consecutive numbers look at opposite places, so
/// that what varies evenly over a disc cancels.
class DiscPlaces {
 public:
  explicit DiscPlaces(const StreamName& ray) noexcept : stream_(pair_of(ray).stream()), opposite_(ray.history & 1) {}
  Vec3d toward(const Sun& sun) noexcept {
    if (!(sun.diameter > 0)) return sun.toward;
    const double u = stream_.uniform();
    const double v = stream_.uniform() + (opposite_ ? 0.5 : 0.0);
    return cone_direction(sun.toward, std::sin(0.5 * sun.diameter), u, v).first;
  }

 private:
  static StreamName pair_of(StreamName ray) noexcept {
    ray.history >>= 1;
    return ray;
  }

  Stream stream_;
  bool opposite_;
};

/// The hot spheres that are worth a shadow ray each, or of many one, chosen in proportion to power.
class SphereLights {
 public:
  SphereLights() = default;
  explicit SphereLights(SpectralWorld world);

  bool empty() const noexcept { return sums_.empty(); }
  /// visit(sphere, chance) for those that are asked.
  template <class Visit>
  void for_some(Stream& stream, Visit&& visit) const {
    if (empty()) return;
    if (sums_.size() <= kAll) {
      for (std::size_t s = 0; s < sums_.size(); ++s) visit(s, 1.0);
    } else {
      double u = stream.uniform();
      const std::size_t s = choose(sums_, sums_.size(), u);
      visit(s, chance(s));
    }
  }
  double chance(std::size_t s) const noexcept {
    return sums_.size() <= kAll ? 1.0 : (sums_[s] - (s ? sums_[s - 1] : 0.0)) / sums_.back();
  }

 private:
  static constexpr std::size_t kAll = 4;
  std::vector<double> sums_;  // of power
};

/// Independent places on the discs.
struct RandomDiscPlaces {
  Stream& stream;
  Vec3d toward(const Sun& sun) noexcept {
    const double u = stream.uniform();
    return cone_direction(sun.toward, std::sin(0.5 * sun.diameter), u, stream.uniform()).first;
  }
};

/// How a point gets the light that its shadow rays do not bring.
enum class Beyond {
  map,  ///< from the photon map
  path  ///< by a path that goes on in a direction drawn at the point. The path can meet the sources too: what both
        ///< find is shared between them by the balance heuristic (Veach, 1997)
};

/// Shadow rays of many points, to be attenuated together.
class DirectLight {
 public:
  /// @param work      what is done adds to it
  /// @param roulette  deep shadow rays end by chance, so that each costs a few free paths at most: for paths, whose own
  ///                  noise is larger than what this adds
  DirectLight(SpectralWorld world, const RadianceParts& parts, WorkCounts& work, bool roulette = false);

  bool empty(Beyond beyond = Beyond::map) const noexcept {
    return !suns_ && !faces_ &&
           (beyond == Beyond::map ? !ambient_ && spheres_ == 0 : all_spheres_.empty() && beams_ == 0);
  }

  /// Asks all sources once for the light at a point.
  /// @param weight what the scattered radiance counts in the owner's sum
  template <class Scatterer, class Discs>
  void add(std::uint32_t owner, double weight, const Scatterer& at, Stream& stream, Discs discs,
           Beyond beyond = Beyond::map) {
    if (suns_) add_suns(owner, weight, at, stream, discs, beyond);
    if (beyond == Beyond::map && (ambient_ || faces_)) add_drawn(owner, weight, at, stream);
    if (faces_) add_faces(owner, weight, at, stream);
    if (beyond == Beyond::map) {
      for (std::size_t s = 0; s < spheres_; ++s) add_sphere(owner, weight, at, stream, s);
    } else {
      all_spheres_.for_some(stream,
                            [&](std::size_t s, double chance) { add_sphere(owner, weight, at, stream, s, chance); });
      for (std::size_t b = 0; b < beams_; ++b) add_beam(owner, weight, at, stream, world_->beams()[b]);
    }
  }

  /// Sun and moon alone.
  template <class Scatterer, class Discs>
  void add_suns(std::uint32_t owner, double weight, const Scatterer& at, Stream& stream, Discs& discs, Beyond beyond) {
    for (const Sun& sun : world_->suns()) {
      const Vec3d toward = discs.toward(sun);
      const double value = at.value(toward);
      double radiance = value * world_.value_of(sun.irradiance);
      if (beyond == Beyond::path && value > 0) radiance *= 1 / (1 + at.density(toward, value) * solid_angle(sun));
      const Ray ray{at.position(), toward, start(at), kInfinity};
      ++work_[Work::sun];
      if (radiance > 0 && !blocked(ray, at.from(), stream)) shoot(owner, weight * radiance, ray, stream);
    }
  }
  bool suns() const noexcept { return suns_; }

  /// Radiance that counts where a path meets the discs of sun and moon, an emitting face or a hot sphere, if the point
  /// before has sent shadow rays with Beyond::path: the path's share by the balance heuristic, W/m2/sr.
  /// @param density of the path's direction, 1/sr; infinite: nothing else has looked there
  double discs_found(const Vec3d& toward, double density) const noexcept;
  double face_found(const SurfacePoint& there, double t, double density) const noexcept;
  double sphere_found(const Vec3d& from, const SurfacePoint& there, double density) const noexcept;

  /// Lets the clouds attenuate everything and adds it to the owners: add(owner, radiance).
  template <class Add>
  void arrive(Add&& add) {
    attenuate();
    for (const auto& [owner, radiance] : arrived_) add(owner, radiance);
    rays_.clear();
    shadows_.clear();
    arrived_.clear();
  }

 private:
  /// Towards where the scatterer would have light from: the sky, the air, or what a surface emits there.
  template <class Scatterer>
  void add_drawn(std::uint32_t owner, double weight, const Scatterer& at, Stream& stream) {
    const Vec3d toward = at.sample(stream);
    const double value = at.value(toward);
    const double density = at.density(toward, value);
    Ray ray{at.position(), toward, start(at), kInfinity};
    const SurfaceHit hit = meet(ray, at.from(), stream);
    ray.t_max = hit.t;
    if (sky_) ++work_[Work::sky];
    const double depth = air_ > 0 ? -std::log(stream.uniform()) : 0.0;
    const double share = drawn_share(value, density);
    if (share > 0) shoot_drawn(owner, weight * share, density, ray, hit, depth, stream);
  }

  /// Towards a point of an emitting face. This and what is drawn, or the path, count by the balance heuristic.
  template <class Scatterer>
  void add_faces(std::uint32_t owner, double weight, const Scatterer& at, Stream& stream) {
    const double u = stream.uniform(), v = stream.uniform(), w = stream.uniform();
    const FaceLights& lights = world_.face_lights();
    const FaceLights::Place place = lights.sample(world_, u, v, w);
    ++work_[Work::faces];
    const Vec3d way = place.position - at.position();
    const double distance = way.length();
    const Vec3d toward = distance > 0 ? way / distance : Vec3d(0);
    const double cosine = -toward.dot(place.normal);
    const double value = cosine > 0 ? at.value(toward) : 0.0;
    if (!(value > 0)) return;
    const double density = lights.density(world_, place.id) * distance * distance / cosine;
    const double emission = lights.emission(world_, place, cosine);
    const Ray ray{at.position(), toward, start(at), distance * (1 - 1e-10) - world_->surfaces().clearance()};
    if (ray.t_max > ray.t_min && !blocked(ray, at.from(), stream)) {
      shoot(owner, weight * value * emission / (density + at.density(toward, value)) * air(distance), ray, stream);
    }
  }

  /// @param chance with which this sphere was chosen; 0: always, and no path looks for it
  template <class Scatterer>
  void add_sphere(std::uint32_t owner, double weight, const Scatterer& at, Stream& stream, std::size_t s,
                  double chance = 0) {
    const HotSphere& sphere = world_->spheres()[s];
    const Vec3d to_center = sphere.center - at.position();
    const double distance = to_center.length();
    const double u = stream.uniform(), v = stream.uniform();
    if (distance <= sphere.radius) return;
    ++work_[Work::spheres];
    const auto [toward, solid_angle] = cone_direction(to_center / distance, sphere.radius / distance, u, v);
    const double value = at.value(toward);
    const double radiance = value * world_.value_of(sphere.radiance);
    Ray ray{at.position(), toward, start(at), kInfinity};
    const SurfaceHit hit = meet(ray, at.from(), stream);
    // At the very limb rounding may miss it: the ray then ends where the limb is.
    if (hit.exists() && hit.id.surface != world_->objects().size() + s && hit.t < distance) return;
    ray.t_max = std::min(hit.t, distance);
    const double share = chance > 0 ? 1 / (chance / solid_angle + at.density(toward, value)) : solid_angle;
    if (radiance > 0) shoot(owner, weight * radiance * share * air(ray.t_max), ray, stream);
  }

  /// A beam's light where the point is inside it.
  template <class Scatterer>
  void add_beam(std::uint32_t owner, double weight, const Scatterer& at, Stream& stream, const Beam& beam) {
    const Vec3d offset = at.position() - beam.position;
    const double along = offset.dot(beam.direction);
    if (along < 0 || (offset - along * beam.direction).length() > beam.radius) return;
    const double radiance = at.value(-beam.direction) * world_.value_of(beam.power) / (kPi * beam.radius * beam.radius);
    const Ray ray{at.position(), -beam.direction, start(at), along};
    ++work_[Work::beams];
    if (radiance > 0 && !blocked(ray, at.from(), stream)) shoot(owner, weight * radiance * air(along), ray, stream);
  }

  template <class Scatterer>
  double start(const Scatterer& at) const noexcept {
    return at.from().exists() ? world_->surfaces().clearance() : 0.0;
  }
  static double solid_angle(const Sun& sun) noexcept {
    const double sine = std::sin(0.25 * sun.diameter);
    return 4 * kPi * sine * sine;
  }

  SurfaceHit meet(const Ray& ray, FaceId from, Stream& stream) noexcept {
    if (!masked_) return {};
    ++work_[Work::masking];
    return world_->meet(ray, from, stream);
  }
  bool blocked(const Ray& ray, FaceId from, Stream& stream) noexcept {
    if (!masked_) return false;
    ++work_[Work::masking];
    return world_->blocked(ray, from, stream);
  }
  double air(double distance) const noexcept { return transmission_over(air_, distance); }
  void shoot(std::uint32_t owner, double radiance, const Ray& ray, Stream& stream, double air_weight = 0,
             double target_depth = 0);
  void shoot_drawn(std::uint32_t owner, double weight, double density, const Ray& ray, const SurfaceHit& hit,
                   double target_depth, Stream& stream);
  void attenuate();
  void add_air();

  SpectralWorld world_;
  WorkCounts& work_;
  double air_;
  bool attenuates_;
  bool masked_;
  bool roulette_;
  bool suns_;
  bool ambient_;  // sky, or the air's own light
  bool faces_;
  bool sky_;
  std::size_t spheres_;
  std::size_t beams_;
  SphereLights all_spheres_;  // particles too
  std::vector<Ray> rays_;
  std::vector<Shadow> shadows_;
  std::vector<std::pair<std::uint32_t, double>> arrived_;
};

/// Light along a ray through clouds and air that are not at its end, W/m2/sr: exact segment by segment.
/// The clouds' own emission, and the air's, of which the clouds hide what is behind them.
/// @param coarse if not null, decides which cells are taken whole, and knows the clouds' optical depth afterwards
/// @param depth  if not null, receives the clouds' optical depth; the walk ends where transmission underflows, and
///               depth behind that is not counted
double light_along(SpectralWorld world, const Ray& ray, CoarseCells* coarse = nullptr,
                   double* depth = nullptr) noexcept;

}  // namespace obscura::detail
