// Light gathered along paths: from points that scatter or reflect, on in one sampled direction each, for some
// bounces, after which the maps are asked; or without end. Final gather and path tracer are this.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "photon/optics/transfer.h"
#include "photon/paths/direct_light.h"
#include "photon/paths/radiance.h"

namespace obscura::detail {

/// Paths of many camera rays, followed together flight by flight. Not for one ray at a time.
class Gather {
 public:
  /// @param direct  holds the shadow rays of all points; it owns sums by path
  /// @param counts  what is done adds to them
  Gather(SpectralWorld world, const PhotonMaps* maps, const RadianceSettings& settings, DirectLight& direct,
         RadianceCounts& counts);

  /// A path for light that scatters into a camera ray: all that it brings adds to that ray.
  std::uint32_t add_path(std::uint32_t owner) {
    paths_.push_back({owner});
    return static_cast<std::uint32_t>(paths_.size() - 1);
  }
  bool wanted() const noexcept { return settings_.gather_bounces > 0; }

  /// Sends a path on from a point: the first of it, with the number of scatterings in clouds so far.
  template <class Scatterer>
  void start(std::uint32_t path, double weight, const Scatterer& at, int scatterings, const Stream& stream) {
    PathLeg leg{{}, path, at.from(), 0, weight, 0, true, 1, scatterings, stream};
    if (continues(scatterings) && send(leg, weight, at)) legs_.push_back(leg);
  }

  /// Follows all paths to their ends and adds what they bring to their rays.
  void finish(std::span<Incoming> incoming);

 private:
  struct Path {
    std::uint32_t owner;
    double direct = 0;
    double map = 0;
  };

  /// A flight, backwards: from where light arrives to where it comes from.
  struct PathLeg {
    Ray ray;
    std::uint32_t path;
    FaceId from;
    double weight;    // what its radiance counts at the sensor
    double first;     // of the path's first leg
    double density;   // of its direction, 1/sr; infinite: the mirror's own
    bool discs;       // may find the discs of sun and moon
    int points;       // that have scattered or reflected so far
    int scatterings;  // in clouds
    Stream stream;
  };

  bool continues(int scatterings) const noexcept {
    return !settings_.scattering_depth || scatterings < *settings_.scattering_depth || world_.surfaces_reflect();
  }

  /// Aims a leg from a point in a direction that the point draws. False where that ends it.
  template <class Scatterer>
  bool send(PathLeg& leg, double weight, const Scatterer& at) {
    const Vec3d toward = at.sample(leg.stream);
    const double value = at.value(toward);
    leg.density = at.density(toward, value);
    leg.weight = weight * drawn_share(value, leg.density);
    if (!(leg.weight > 0)) return false;
    leg.from = at.from();
    leg.discs = true;
    leg.ray = {at.position(), toward, at.from().exists() ? world_->surfaces().clearance() : 0.0, kInfinity};
    return survives(leg);
  }

  bool survives(PathLeg& leg) const noexcept;
  void fly();
  void end_flight(PathLeg& leg, const Flight& flight, FreePath& end, const SurfaceHit& hit);
  template <class Scatterer>
  void scatter(PathLeg& leg, double weight, const Scatterer& at);
  void reflect(PathLeg& leg, double weight, const SurfacePoint& at);
  double emission_along(const PathLeg& leg, const FreePath& end) const noexcept;
  double air(double distance) const noexcept { return transmission_over(air_, distance); }

  SpectralWorld world_;
  const PhotonMaps* maps_;
  const RadianceSettings& settings_;
  DirectLight& direct_;
  RadianceCounts& counts_;
  double air_;
  bool attenuates_;
  double sky_;
  bool emits_;
  const CloudOptics::Part* only_;
  std::optional<double> source_;
  std::vector<Path> paths_;
  std::vector<PathLeg> legs_, next_;
  std::span<Incoming> incoming_;
};

}  // namespace obscura::detail
