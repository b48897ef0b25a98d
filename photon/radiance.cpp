#include "photon/radiance.h"

#include <algorithm>
#include <vector>

#include "octree/base/random.h"
#include "photon/purpose.h"
#include "photon/scatter.h"
#include "photon/transfer.h"
#include "photon/world_walk.h"

namespace obscura {
namespace {

/// Radiance emitted by the clouds along a ray: exact segment by segment.
double emitted_radiance(const World& world, int interval, const Ray& ray) noexcept {
  double radiance = 0;
  double transmission = 1;
  WorldWalk walk(world, interval, ray);
  while (walk.next() && transmission > 0) {
    const LocalOptics& local = walk.optics();
    const double length = walk.end() - walk.begin();
    const double depth = local.extinction * length;
    radiance += transmission * local.emission * length * mean_transmission(depth);
    transmission *= std::exp(-depth);
  }
  return radiance;
}

/// Most scattering points of one ray: their streams are numbered below this.
constexpr int kMostPoints = 64;

/// A point where light scatters into a ray.
struct ScatteringPoint {
  std::uint32_t ray;
  double t;
  double weight;  // dimensionless: share of the ray's transmission that is lost to scattering here
};

/// Light on its way to a scattering point: `radiance` arrives if nothing is in the way.
struct ShadowRay {
  std::uint32_t ray;   // the camera ray that it adds to
  double radiance;     // W/m2/sr at the camera ray's start, before attenuation on the way to the point
};

/// Everything that one call works on, so that its steps can be read one by one.
class Pass {
 public:
  Pass(const World& world, int interval, const PhotonMap* map, const RadianceSettings& settings,
       std::span<const Ray> rays, std::span<const std::uint64_t> histories, std::span<Incoming> incoming)
      : world_(world), interval_(interval), map_(map), settings_(settings), rays_(rays.begin(), rays.end()),
        histories_(histories), incoming_(incoming) {
    counts_.rays = rays.size();
  }

  RadianceCounts run() {
    find_surfaces();
    attenuate();
    add_background();
    if (settings_.parts.emission) add_emission();
    if (world_.scatters(interval_) && settings_.scattering_depth.value_or(1) > 0) {
      place_points();
      add_direct_light();
      if (settings_.parts.map && map_ && map_->size() > 0) add_map();
    }
    for (Incoming& in : incoming_) drop_anomalies(in);
    return counts_;
  }

 private:
  void find_surfaces() {
    hits_.resize(rays_.size());
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      hits_[i] = world_.spheres().intersect(rays_[i]);
      incoming_[i] = {};
      incoming_[i].distance = hits_[i].t;
      rays_[i].t_max = std::min(rays_[i].t_max, hits_[i].t);
    }
  }

  void attenuate() {
    depths_.resize(rays_.size());
    world_.optical_depths(interval_, rays_, depths_);
    for (std::size_t i = 0; i < rays_.size(); ++i) incoming_[i].transmission = std::exp(-depths_[i]);
  }

  void add_background() {
    if (!settings_.parts.background) return;
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      const double behind =
          hits_[i].t < kInfinity
              ? world_.spheres().spheres()[hits_[i].sphere].radiance[static_cast<std::size_t>(interval_)]
              : world_.background(interval_, rays_[i].direction, settings_.parts.sun_disc);
      // An empty cloud in the way changes no bit.
      incoming_[i].direct += incoming_[i].transmission * behind;
    }
  }

  void add_emission() {
    if (!world_.emits(interval_)) return;
    const std::optional<double> source = world_.uniform_source(interval_);
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      if (depths_[i] <= 0 && source) continue;
      incoming_[i].direct += source ? *source * one_minus_exp(depths_[i])
                                    : emitted_radiance(world_, interval_, rays_[i]);
    }
  }

  /// Points with equal shares of what each ray loses: strata of transmission, one jittered point in
  /// each, so that the mean of albedo times in-scattered radiance over them is unbiased.
  void place_points() {
    std::vector<Flight> flights;
    std::vector<std::uint32_t> owners;
    std::vector<double> weights;
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      const double lost = one_minus_exp(depths_[i]);
      if (!(lost > 0)) continue;
      const int count = std::clamp(static_cast<int>(std::ceil(lost * settings_.points)), 1, kMostPoints);
      Stream stream = stream_of(i, 0);
      for (int k = 0; k < count; ++k) {
        const double u = (k + stream.uniform()) / count;
        flights.push_back({rays_[i], std::min(-std::log1p(-u * lost), depths_[i])});
        owners.push_back(static_cast<std::uint32_t>(i));
        weights.push_back(lost / count);
      }
    }
    std::vector<FreePath> ends(flights.size());
    world_.reach_depths(interval_, flights, ends);
    points_.reserve(flights.size());
    for (std::size_t k = 0; k < flights.size(); ++k) {
      // Rounding at the far border of a cloud may leave the last bit of depth unreached: no point there.
      if (!ends[k].collided) continue;
      const LocalOptics local = world_.at_collision(interval_, flights[k], ends[k]);
      if (!(local.scattering > 0)) continue;
      points_.push_back({owners[k], ends[k].t, weights[k] * local.scattering / local.extinction});
    }
    counts_.scattering_points += points_.size();
  }

  /// Light of sun, sky and hot spheres that has not scattered yet: one shadow ray for each.
  void add_direct_light() {
    const bool sun = settings_.parts.sun && world_.sun() &&
                     world_.sun()->irradiance[static_cast<std::size_t>(interval_)] > 0;
    const bool sky = settings_.parts.sky && world_.sky(interval_) > 0;
    const std::size_t spheres = settings_.parts.spheres ? world_.source_count() : 0;
    if (!sun && !sky && spheres == 0) return;

    std::vector<Ray> rays;
    std::vector<ShadowRay> shadows;
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const ScatteringPoint& point = points_[k];
      const Ray& ray = rays_[point.ray];
      const Vec3d x = ray.at(point.t);
      const Vec3d outward = -ray.direction;  // where the scattered light goes
      const LocalScattering scattering(world_, interval_, x);
      Stream stream = stream_of(point.ray, 1 + k - first_of(k));
      if (sun) {
        const double u = stream.uniform();
        const Vec3d toward =
            cone_direction(world_.sun()->toward, std::sin(0.5 * world_.sun()->diameter), u, stream.uniform()).first;
        shoot(rays, shadows, point, {x, toward, 0, kInfinity},
              scattering.phase(-toward.dot(outward)) *
                  world_.sun()->irradiance[static_cast<std::size_t>(interval_)]);
      }
      if (sky) {
        // In proportion to the phase function: what remains is the sky's own radiance.
        const double u = stream.uniform();
        const double v = stream.uniform();
        const Vec3d toward = scattering.sample(ray.direction, u, v, stream.uniform());
        shoot(rays, shadows, point, {x, toward, 0, kInfinity}, world_.sky(interval_));
      }
      for (std::size_t s = 0; s < spheres; ++s) {
        const HotSphere& sphere = world_.spheres().spheres()[s];
        const Vec3d to_center = sphere.center - x;
        const double distance = to_center.length();
        if (distance <= sphere.radius) continue;
        const double u = stream.uniform();
        const auto [toward, solid_angle] =
            cone_direction(to_center / distance, sphere.radius / distance, u, stream.uniform());
        const double radiance = scattering.phase(-toward.dot(outward)) *
                                sphere.radiance[static_cast<std::size_t>(interval_)] * solid_angle;
        const Ray shadow{x, toward, 0, kInfinity};
        const SphereHit hit = world_.spheres().intersect(shadow);
        // At the very limb rounding may miss it: the ray then ends where the limb is.
        if (hit.t < kInfinity && hit.sphere != s) continue;
        shoot(rays, shadows, point,
              {x, toward, 0, hit.t < kInfinity ? hit.t : distance}, radiance, true);
      }
    }
    std::vector<double> depths(rays.size());
    world_.optical_depths(interval_, rays, depths);
    for (std::size_t s = 0; s < rays.size(); ++s) {
      incoming_[shadows[s].ray].direct += shadows[s].radiance * std::exp(-depths[s]);
    }
    counts_.shadow_rays += rays.size();
  }

  void shoot(std::vector<Ray>& rays, std::vector<ShadowRay>& shadows, const ScatteringPoint& point,
             const Ray& ray, double radiance, bool visible = false) {
    if (!(radiance > 0)) return;
    if (!visible && world_.spheres().intersect(ray).t < kInfinity) return;
    rays.push_back(ray);
    shadows.push_back({point.ray, point.weight * radiance});
  }

  /// The map is asked at one point of each ray, for all of them: rays of a pixel share photons, so that
  /// more points would cost more and know little more.
  void add_map() {
    for (std::size_t first = 0, end; first < points_.size(); first = end) {
      end = first + 1;
      while (end < points_.size() && points_[end].ray == points_[first].ray) ++end;
      const std::size_t count = end - first;
      Stream stream = stream_of(points_[first].ray, 1 + kMostPoints);
      const auto chosen = std::min(count - 1, static_cast<std::size_t>(stream.uniform() * static_cast<double>(count)));
      ScatteringPoint point = points_[first + chosen];
      point.weight *= static_cast<double>(count);
      const Ray& ray = rays_[point.ray];
      const Vec3d x = ray.at(point.t);
      const LocalScattering scattering(world_, interval_, x);
      const Vec3d outward = transform_direction(world_.world_to_map(), -ray.direction);
      const Estimate estimate = obscura::estimate(
          *map_, transform_point(world_.world_to_map(), x),
          [&](const Vec3d& y) noexcept { return world_.extinction_in_map(interval_, y); },
          [&](const Vec3d& travel) noexcept { return scattering.phase(travel.dot(outward)); },
          settings_.gather);
      counts_.anomalies += estimate.anomaly;
      Incoming& in = incoming_[point.ray];
      for (std::size_t b = 0; b < in.map.size(); ++b) in.map[b] += point.weight * estimate.batch[b];
      in.bias += point.weight * estimate.bias;
    }
  }

  void drop_anomalies(Incoming& in) {
    const auto check = [this](double& value) {
      if (!std::isfinite(value)) {
        value = 0;
        ++counts_.anomalies;
      }
    };
    check(in.direct);
    check(in.bias);
    for (double& batch : in.map) check(batch);
  }

  /// The stream of a ray's own step: 0 for its points, then one for each point.
  Stream stream_of(std::size_t ray, std::size_t step) const noexcept {
    return {settings_.seed, histories_[ray],
            purpose_id(Purpose::radiance, interval_) + 0x10000u * static_cast<std::uint32_t>(step)};
  }
  /// Number of the first point of the ray that owns point k.
  std::size_t first_of(std::size_t k) const noexcept {
    std::size_t first = k;
    while (first > 0 && points_[first - 1].ray == points_[k].ray) --first;
    return first;
  }

  const World& world_;
  int interval_;
  const PhotonMap* map_;
  const RadianceSettings& settings_;
  std::vector<Ray> rays_;  // clipped at the first surface
  std::span<const std::uint64_t> histories_;
  std::span<Incoming> incoming_;
  std::vector<SphereHit> hits_;
  std::vector<double> depths_;
  std::vector<ScatteringPoint> points_;
  RadianceCounts counts_;
};

}  // namespace

RadianceCounts incoming_radiance(const World& world, int interval, const PhotonMap* map,
                                 const RadianceSettings& settings, std::span<const Ray> rays,
                                 std::span<const std::uint64_t> histories,
                                 std::span<Incoming> incoming) {
  return Pass(world, interval, map, settings, rays, histories, incoming).run();
}

}  // namespace obscura
