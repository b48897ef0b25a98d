// The World as light of one spectral interval meets it: what kernels ask.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "photon/world/world.h"

namespace obscura {

/// A World and one of its intervals; two words, passed by value. `->` reaches what all intervals share. Valid as long
/// as the World.
class SpectralWorld {
 public:
  /// @param interval 0 to World::interval_count() - 1
  SpectralWorld(const World& world, int interval) noexcept : world_(&world), interval_(interval) {}

  const World& operator*() const noexcept { return *world_; }
  const World* operator->() const noexcept { return world_; }
  int interval() const noexcept { return interval_; }
  /// Of a list with one value for each interval, the one here.
  double value_of(const std::vector<double>& per_interval) const noexcept { return per_interval[index()]; }
  /// The interval's band, and its number in the band.
  IntervalIndex place_in_band() const noexcept { return world_->interval(interval_); }
  const Band& band() const noexcept { return world_->bands()[static_cast<std::size_t>(place_in_band().band)]; }

  const CloudOptics& optics(int cloud) const noexcept {
    return world_->optics_[static_cast<std::size_t>(interval_ * world_->cloud_count() + cloud)];
  }
  /// A cloud absorbs or scatters.
  bool attenuates() const noexcept;
  bool scatters() const noexcept;
  bool emits() const noexcept;
  /// A cloud emits without absorbing.
  bool glows() const noexcept;
  /// Most that emission over extinction can be anywhere, W/m2/sr; infinite where a cloud may emit without absorbing.
  double largest_source() const noexcept;
  /// Emission over extinction where it is one number in every cloud, W/m2/sr.
  std::optional<double> uniform_source() const noexcept;
  /// The medium, where there is only one in the World: albedo and phase function are then the same
  /// wherever light collides. Else null.
  const CloudOptics::Part* only_medium() const noexcept {
    return world_->cloud_count() == 1 && optics(0).parts().size() == 1 ? optics(0).parts().data() : nullptr;
  }

  /// Optics at a point; periodic clouds repeat.
  LocalOptics at(const Vec3d& point) const noexcept;
  /// Optics where a flight has collided. Where the batched walk's rounding has carried the end out of
  /// what the flight collided with, or where leaves are thick, the flight is walked again in double and the
  /// end put right; it may turn out not to have collided.
  LocalOptics at_collision(const Flight& flight, FreePath& end) const noexcept;
  /// Whether some leaf may be so thick that at_collision() walks flights again.
  bool has_thick_leaves() const noexcept;
  /// Extinction at a point of the map's frame, 1/m.
  double extinction_in_map(const Vec3d& point) const noexcept;

  /// Optical depth of all clouds along each ray. Deterministic per ray. Scratch is allocated.
  void optical_depths(std::span<const Ray> rays, std::span<double> depths) const;
  /// Goes along each ray until the target depth is reached (collided) or the ray ends.
  void reach_depths(std::span<const Flight> flights, std::span<FreePath> ends) const;

  /// W/m2/sr
  double sky() const noexcept { return world_->contents().sky.empty() ? 0.0 : value_of(world_->contents().sky); }
  /// Radiance from beyond all clouds, W/m2/sr: the sky, and the discs of sun and moon where the ray meets
  /// them.
  double background(const Vec3d& direction, bool discs = true) const noexcept;
  /// Extinction of the air, 1/m, and the radiance of a black body at its temperature, W/m2/sr.
  double air_extinction() const noexcept {
    return world_->atmosphere() ? value_of(world_->atmosphere()->extinction) : 0.0;
  }
  double air_radiance() const noexcept { return world_->atmosphere() ? value_of(world_->atmosphere()->radiance) : 0.0; }

  /// What a ray has met; the hit has to exist.
  SurfacePoint surface_at(const Ray& ray, const SurfaceHit& hit) const noexcept;
  /// The material of a face of an object.
  const MaterialOptics& material(const FaceId& face) const noexcept;
  /// Radiance of a black body with the temperature (or with the given radiance) of a point on a face of an
  /// object, W/m2/sr.
  double black_radiance(const FaceId& face, double u, double v) const noexcept;
  /// Faces of objects that emit.
  const FaceLights& face_lights() const noexcept { return world_->face_lights_[index()]; }
  /// A surface of an object reflects.
  bool surfaces_reflect() const noexcept { return world_->surfaces_reflect_[index()]; }

 private:
  std::size_t index() const noexcept { return static_cast<std::size_t>(interval_); }

  const World* world_;
  int interval_;
};

/// Light is scattered or reflected at some interval.
bool redirects_light(const World& world) noexcept;

}  // namespace obscura
