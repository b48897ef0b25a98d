#include "photon/paths/radiance.h"

#include <algorithm>
#include <vector>

#include "photon/optics/purpose.h"
#include "photon/optics/transfer.h"
#include "photon/paths/gather.h"
#include "photon/paths/leg_steps.h"
#include "photon/paths/map_light.h"
#include "photon/paths/straight_radiance.h"
#include "photon/world/check_contents.h"

namespace obscura {
namespace {

using detail::CloudScatterer;
using detail::kMapStep;
using detail::kMeetStep;
using detail::kReflectStep;
using detail::kSteps;
using detail::map_light;
using detail::SurfaceScatterer;

/// A stretch of a camera ray: from the sensor to a surface or infinity, then from mirror to mirror.
struct Leg {
  Ray ray;              // ends at the surface
  std::uint32_t owner;  // the camera ray
  double weight;        // what its radiance counts at the sensor
  FaceId from;
  bool discs;  // sees the discs of sun and moon
  SurfaceHit hit;
  Footprint footprint;    // none: exactly through the leaves
  double depth = 0;       // of the clouds
  double most_depth = 0;  // no less than what the leaves hold
  double transmission = 1;
  double emission = 0;  // where coarse: of what lies along it
  bool coarse = false;
};

/// A point where light scatters into a leg.
struct ScatteringPoint {
  std::uint32_t leg;
  int number;  // in its leg
  double t;
  double weight;  // what radiance scattered there counts at the sensor
};

/// Rays as legs, unless straight_radiance() serves them: all that one call works on, so that its steps can be read one
/// by one.
class LegPass {
 public:
  LegPass(SpectralWorld world, const PhotonMaps* maps, const RadianceSettings& settings, std::span<const Ray> rays,
          std::span<const std::uint64_t> histories, std::span<Incoming> incoming)
      : world_(world),
        maps_(maps),
        settings_(settings),
        rays_(rays),
        histories_(histories),
        incoming_(incoming),
        air_(world.air_extinction()),
        attenuates_(world.attenuates()),
        direct_(world, settings.parts, counts_.work, settings.gather_bounces > 0),
        gather_(world, maps, settings, direct_, counts_),
        beyond_(gather_.wanted() ? detail::Beyond::path : detail::Beyond::map),
        narrowest_spot_(narrowest_spot()) {
    counts_.rays = rays.size();
  }

  RadianceCounts run() {
    if (is_straight()) return detail::straight_radiance(world_, settings_, rays_, histories_, incoming_);
    legs_.reserve(rays_.size());
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      incoming_[i] = {};
      legs_.push_back(
          {rays_[i], static_cast<std::uint32_t>(i), 1.0, {}, settings_.parts.sun_disc, {}, settings_.footprint});
    }
    for (bounce_ = 0; !legs_.empty(); ++bounce_) {
      if (!world_->surfaces().empty()) find_surfaces();
      attenuate();
      if (settings_.parts.background) add_background();
      if (settings_.parts.emission) add_emission();
      if (world_.scatters() && settings_.scattering_depth.value_or(1) > 0) {
        place_points();
        add_direct_light();
        if (!gather_.wanted() && settings_.parts.map && maps_ && maps_->volume.size() > 0) add_map();
      }
      std::vector<Leg> mirrored;
      if (world_.surfaces_reflect()) reflect(mirrored);
      if (!gather_.wanted()) {
        direct_.arrive([this](std::uint32_t ray, double light) { incoming_[ray].direct += light; });
      }
      counts_.work[Work::specular] += mirrored.size();
      legs_ = std::move(mirrored);
    }
    if (gather_.wanted()) gather_.finish(incoming_);
    for (Incoming& in : incoming_) drop_anomalies(in);
    return counts_;
  }

 private:
  /// True where nothing scatters or reflects light into a ray: all that it brings comes from along itself.
  bool is_straight() const {
    const bool scatters = world_.scatters() && settings_.scattering_depth.value_or(1) > 0;
    return !scatters && !world_.surfaces_reflect() && !(narrowest_spot_ < kInfinity);
  }

  void find_surfaces() {
    counts_.work[Work::masking] += legs_.size();
    for (Leg& leg : legs_) {
      Stream stream = stream_of(leg, kMeetStep);
      leg.hit = world_->meet(leg.ray, leg.from, stream);
      leg.ray.t_max = std::min(leg.ray.t_max, leg.hit.t);
      if (bounce_ == 0) incoming_[leg.owner].distance = leg.hit.t;
    }
  }

  void attenuate() {
    if (air_ > 0) counts_.work[Work::atmosphere] += legs_.size();
    if (!attenuates_) {
      for (const Leg& leg : legs_) {
        if (bounce_ == 0) incoming_[leg.owner].transmission_air = air(leg.ray.t_max);
      }
      return;
    }
    counts_.work[Work::extinction] += legs_.size();
    std::vector<Ray> rays;
    rays.reserve(legs_.size());
    for (Leg& leg : legs_) {
      leg.coarse = is_wide(leg);
      if (!leg.coarse) rays.push_back(leg.ray);
    }
    std::vector<double> depths(rays.size());
    world_.optical_depths(rays, depths);
    std::size_t next = 0;
    for (Leg& leg : legs_) {
      if (leg.coarse) {
        walk_coarsely(leg);
      } else {
        leg.depth = leg.most_depth = depths[next++];
      }
      leg.transmission = std::exp(-leg.depth);
      if (bounce_ > 0) continue;
      incoming_[leg.owner].transmission = leg.transmission;
      incoming_[leg.owner].transmission_air = air(leg.ray.t_max);
    }
  }

  /// Narrowest spot in the clouds, m, that makes a leg worth a walk by coarse cells: where its emission has to be
  /// followed in any case. Transmission alone is faster by the batched walk through the leaves (octree/MEASURED.md,
  /// "Coarse cells").
  double narrowest_spot() const {
    if (!settings_.footprint.exists() || !(settings_.footprint_tolerance > 0)) return kInfinity;
    if (!settings_.parts.emission || !world_.emits() || !(world_.largest_source() < kInfinity)) return kInfinity;
    if (!(air_ > 0) && world_.uniform_source()) return kInfinity;
    double voxel_m = kInfinity;
    for (int c = 0; c < world_->cloud_count(); ++c) voxel_m = std::min(voxel_m, world_->frame(c).voxel_m);
    return voxel_m * (1 << Walk::kFinestStop);
  }

  bool is_wide(const Leg& leg) const noexcept {
    if (!(narrowest_spot_ < kInfinity) || !leg.footprint.exists()) return false;
    const auto [enter, leave] =
        world_->periodic() ? std::pair(leg.ray.t_min, leg.ray.t_max) : clip(leg.ray, world_->cloud_bounds());
    return enter < leave && leg.footprint.at(leave) >= narrowest_spot_;
  }

  void walk_coarsely(Leg& leg) {
    CoarseCells cells(leg.footprint, settings_.footprint_tolerance, world_.largest_source());
    leg.emission = detail::light_along(world_, leg.ray, &cells);
    leg.depth = cells.depth();
    leg.most_depth = cells.depth() + cells.depth_doubt();
    counts_.footprint += cells.counts();
  }

  void add_background() {
    for (const Leg& leg : legs_) {
      double behind;
      if (leg.hit.exists()) {
        ++counts_.work[Work::surfaces];
        behind = detail::surface_behind(world_, leg.ray, leg.hit, air(leg.hit.t));
      } else {
        behind = world_.background(leg.ray.direction, leg.discs);
      }
      // An empty cloud in the way changes no bit.
      incoming_[leg.owner].direct += leg.weight * (leg.transmission * behind);
    }
  }

  void add_emission() {
    const bool emits = world_.emits();
    if (!emits && !(air_ > 0)) return;
    const std::optional<double> source = air_ > 0 ? std::nullopt : world_.uniform_source();
    for (const Leg& leg : legs_) {
      if (leg.coarse) {
        counts_.work[Work::emission] += emits;
        incoming_[leg.owner].direct += leg.weight * leg.emission;
        continue;
      }
      if (leg.depth <= 0 && !world_.glows()) continue;
      counts_.work[Work::emission] += emits;
      incoming_[leg.owner].direct +=
          leg.weight * (source ? *source * one_minus_exp(leg.depth) : detail::light_along(world_, leg.ray));
    }
  }

  /// Points with equal shares of what each leg loses: strata of transmission, one jittered point in
  /// each, so that the mean of albedo times in-scattered radiance over them is unbiased.
  void place_points() {
    points_.clear();
    std::vector<Flight> flights;
    for (std::size_t i = 0; i < legs_.size(); ++i) {
      const Leg& leg = legs_[i];
      // With coarse cells this depth is an upper estimate: a target that the leaves do not reach gets no point.
      const double lost = one_minus_exp(leg.most_depth);
      if (!(lost > 0)) continue;
      const int count = std::clamp(static_cast<int>(std::ceil(lost * settings_.points)), 1, kMostPoints);
      Stream stream = stream_of(leg, 0);
      for (int k = 0; k < count; ++k) {
        const double u = (k + stream.uniform()) / count;
        flights.push_back({leg.ray, std::min(-std::log1p(-u * lost), leg.most_depth)});
        points_.push_back({static_cast<std::uint32_t>(i), k, 0.0, leg.weight * lost / count});
      }
    }
    std::vector<FreePath> ends(flights.size());
    world_.reach_depths(flights, ends);
    // Of one medium in leaves that are not thick, nothing has to be looked up where it collides.
    const CloudOptics::Part* only = world_.has_thick_leaves() ? nullptr : world_.only_medium();
    std::size_t kept = 0;
    for (std::size_t k = 0; k < flights.size(); ++k) {
      // Rounding at the far border of a cloud may leave the last bit of depth unreached: no point there.
      if (!ends[k].collided) continue;
      double albedo;
      if (only) {
        albedo = only->scattering / only->extinction;
      } else {
        const LocalOptics local = world_.at_collision(flights[k], ends[k]);
        if (!(local.scattering > 0)) continue;
        albedo = local.scattering / local.extinction;
      }
      ScatteringPoint point = points_[k];
      point.t = ends[k].t;
      point.weight *= albedo * air(point.t);
      points_[kept++] = point;
    }
    points_.resize(kept);
    counts_.work[Work::scattering] += kept;
  }

  void add_direct_light() {
    if (direct_.empty() && !gather_.wanted()) return;
    for (const ScatteringPoint& point : points_) {
      const Leg& leg = legs_[point.leg];
      light(leg, 1 + point.number, point.weight, CloudScatterer(world_, leg.ray, point.t), 1);
    }
  }

  /// Direct light at a point, and a path that goes on from there where all else is gathered.
  template <class Scatterer>
  void light(const Leg& leg, int step, double weight, const Scatterer& at, int scatterings) {
    Stream stream = stream_of(leg, step);
    const std::uint32_t sum = gather_.wanted() ? gather_.add_path(leg.owner) : leg.owner;
    if (!direct_.empty(beyond_)) direct_.add(sum, weight, at, stream, discs_of(leg, step), beyond_);
    if (gather_.wanted()) gather_.start(sum, weight, at, scatterings, stream);
  }

  /// The map is asked at one point of each leg, for all of them: rays of a pixel share photons, so that
  /// more points would cost more and know little more.
  void add_map() {
    for (std::size_t first = 0, end; first < points_.size(); first = end) {
      end = first + 1;
      while (end < points_.size() && points_[end].leg == points_[first].leg) ++end;
      const std::size_t count = end - first;
      const Leg& leg = legs_[points_[first].leg];
      Stream stream = stream_of(leg, kMapStep);
      const auto chosen = std::min(count - 1, static_cast<std::size_t>(stream.uniform() * static_cast<double>(count)));
      const ScatteringPoint& point = points_[first + chosen];
      const CloudScatterer at(world_, leg.ray, point.t);
      add(leg.owner, point.weight * static_cast<double>(count),
          map_light(world_, *maps_, at, settings_.gather, key_of(leg)));
    }
  }

  /// What surfaces reflect: the Lambertian share here, the mirror's share along a leg of its own.
  void reflect(std::vector<Leg>& mirrored) {
    for (const Leg& leg : legs_) {
      if (!leg.hit.exists()) continue;
      ++counts_.work[Work::surfaces];
      const SurfacePoint at = world_.surface_at(leg.ray, leg.hit);
      if (!at.reflects()) continue;
      const MaterialOptics& material = *at.material;
      const double weight = leg.weight * leg.transmission * air(leg.hit.t);
      if (!(weight > 0)) continue;
      Stream stream = stream_of(leg, kReflectStep);
      const double specular = bounce_ < settings_.specular_depth ? material.specular() : 0.0;
      if (specular < 1) {
        const double share = weight * (1 - specular);
        const int paths = gather_.wanted() ? std::clamp(settings_.points, 1, kMostPoints) : 1;
        for (int k = 0; k < paths; ++k) light(leg, kReflectStep + k, share / paths, SurfaceScatterer(at), 0);
        if (!gather_.wanted() && settings_.parts.map && maps_ && maps_->surface.size() > 0) {
          add(leg.owner, share, map_light(world_, *maps_, SurfaceScatterer(at), settings_.gather, key_of(leg)));
        }
      }
      const double share = weight * specular * material.reflectance(at.cosine);
      if (!(share > 0)) continue;
      bool exact;
      const Vec3d toward = mirror_direction(leg.ray.direction, at.normal, material.roughness(), stream, exact);
      mirrored.push_back({{at.position, toward, world_->surfaces().clearance(), kInfinity},
                          leg.owner,
                          share,
                          at.id,
                          settings_.parts.sun_disc && exact,
                          {},
                          exact ? leg.footprint.from(leg.hit.t) : Footprint()});
      if (material.roughness() > 0 && direct_.suns()) {
        // A rough mirror would find the small discs too rarely.
        detail::DiscPlaces discs = discs_of(leg, kReflectStep);
        const std::uint32_t sum = gather_.wanted() ? gather_.add_path(leg.owner) : leg.owner;
        direct_.add_suns(sum, share, detail::RoughMirror{at, leg.ray.direction}, stream, discs, detail::Beyond::map);
      }
    }
  }

  void add(std::uint32_t owner, double weight, const Estimate& estimate) {
    ++counts_.work[Work::map];
    counts_.anomalies += estimate.anomaly;
    Incoming& in = incoming_[owner];
    for (std::size_t b = 0; b < in.map.size(); ++b) in.map[b] += weight * estimate.batch[b];
    in.bias += weight * estimate.bias;
  }

  void drop_anomalies(Incoming& in) {
    const auto check = [this](double& value) {
      if (!std::isfinite(value)) {
        value = 0;
        ++counts_.anomalies;
      }
    };
    check(in.direct);
    if (counts_.work[Work::map] == 0) return;
    check(in.bias);
    for (double& batch : in.map) check(batch);
  }

  /// Transmission of the air.
  double air(double distance) const noexcept { return transmission_over(air_, distance); }

  Stream stream_of(const Leg& leg, int step) const noexcept {
    return name_of(leg.owner, Purpose::radiance, step).stream();
  }
  detail::DiscPlaces discs_of(const Leg& leg, int step) const noexcept {
    return detail::DiscPlaces(name_of(leg.owner, Purpose::disc, step));
  }
  Vec3d key_of(const Leg& leg) const noexcept {
    return {static_cast<double>(histories_[leg.owner]), static_cast<double>(settings_.seed),
            static_cast<double>(bounce_)};
  }
  StreamName name_of(std::size_t ray, Purpose purpose, int step) const noexcept {
    return {settings_.seed, histories_[ray], purpose, world_.interval(),
            static_cast<std::uint64_t>(bounce_) * kSteps + static_cast<std::uint64_t>(step)};
  }

  SpectralWorld world_;
  const PhotonMaps* maps_;
  const RadianceSettings& settings_;
  std::span<const Ray> rays_;
  std::span<const std::uint64_t> histories_;
  std::span<Incoming> incoming_;
  double air_;
  bool attenuates_;
  RadianceCounts counts_;  // the next two count into it
  detail::DirectLight direct_;
  detail::Gather gather_;
  detail::Beyond beyond_;
  double narrowest_spot_;
  int bounce_ = 0;
  std::vector<Leg> legs_;
  std::vector<ScatteringPoint> points_;
};

}  // namespace

RadianceCounts incoming_radiance(SpectralWorld world, const PhotonMaps* maps, const RadianceSettings& settings,
                                 std::span<const Ray> rays, std::span<const std::uint64_t> histories,
                                 std::span<Incoming> incoming) {
  check_rays(world, rays, histories.size(), incoming.size());
  // So many together that their points and paths fit the caches.
  constexpr std::size_t kTogether = 16384;
  const std::size_t most = std::max<std::size_t>(1, kTogether / static_cast<std::size_t>(std::max(1, settings.points)));
  RadianceCounts counts;
  for (std::size_t first = 0; first < rays.size(); first += most) {
    const std::size_t count = std::min(most, rays.size() - first);
    counts += LegPass(world, maps, settings, rays.subspan(first, count), histories.subspan(first, count),
                      incoming.subspan(first, count))
                  .run();
  }
  if (world.place_in_band().interval > 0) counts.work[Work::spectral] += rays.size();
  return counts;
}

}  // namespace obscura
