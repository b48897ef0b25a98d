// Minimal loops for effects_bench, each what one would write who has only this to compute.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "octree/base/low_discrepancy.h"
#include "octree/base/statistics.h"
#include "octree/tree/batch_walk.h"
#include "octree/tree/walk.h"
#include "photon/map/photon.h"
#include "photon/optics/planck_table.h"
#include "photon/optics/purpose.h"
#include "photon/optics/transfer.h"
#include "photon/trace/emission.h"
#include "photon/world/scatter.h"
#include "photon/world/world.h"

namespace obscura::bench {

inline constexpr std::size_t kRays = 4096;
inline constexpr double kExtinction = 0.3;  // up to an optical depth of 10 across
inline constexpr double kAlbedo = 0.9;
inline constexpr double kSky = 3, kSource = 2, kSun = 5;

/// Radiance of all rays by the program or by a loop.
using Radiances = std::function<void(std::vector<double>&)>;

/// Optical depths of the one cloud.
class Depths {
 public:
  explicit Depths(const World& world)
      : octree_(*world.clouds()[0].octree), to_index_(world.frame(0).world_to_index), weights_{kExtinction, 0} {
    weights_.resize(static_cast<std::size_t>(octree_.channel_count()));
  }
  std::span<const double> operator()(std::span<const Ray> rays) {
    index_rays_.resize(rays.size());
    depths_.resize(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) index_rays_[i] = transform_ray(to_index_, rays[i]);
    optical_depths(octree_, index_rays_, weights_, depths_);
    return depths_;
  }

 private:
  const Octree& octree_;
  Affine to_index_;
  std::vector<double> weights_;
  std::vector<Ray> index_rays_;
  std::vector<double> depths_;
};

inline Radiances absorption(const World& world, const std::vector<Ray>& rays, double source) {
  return [&rays, source, depths = Depths(world)](std::vector<double>& radiance) mutable {
    const std::span<const double> depth = depths(rays);
    if (source > 0) {
      for (std::size_t i = 0; i < rays.size(); ++i)
        radiance[i] = std::exp(-depth[i]) * kSky + source * one_minus_exp(depth[i]);
    } else {
      for (std::size_t i = 0; i < rays.size(); ++i) radiance[i] = std::exp(-depth[i]) * kSky;
    }
  };
}

inline Radiances varying_temperature(const World& world, const std::vector<Ray>& rays, const PlanckTable& planck) {
  return [&world, &rays, &planck](std::vector<double>& radiance) {
    const Octree& octree = *world.clouds()[0].octree;
    const Affine& to_index = world.frame(0).world_to_index;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      double sum = 0, transmission = 1, depth = 0;
      Walk walk(octree, transform_ray(to_index, rays[i]));
      while (walk.next() && transmission > 0) {
        if (walk.empty()) continue;
        const double tau = kExtinction * static_cast<double>(walk.value(0)) * (walk.end() - walk.begin());
        sum += transmission * one_minus_exp(tau) * planck(static_cast<double>(walk.value(1)));
        depth += tau;
        transmission = std::exp(-depth);
      }
      radiance[i] = sum + transmission * kSky;
    }
  };
}

inline Radiances surfaces_only(const World& world, const std::vector<Ray>& rays) {
  return [&world, &rays](std::vector<double>& radiance) {
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const SurfaceHit hit = world.surfaces().intersect(rays[i]);
      if (hit.exists()) {
        const SurfacePoint at = SpectralWorld(world, 0).surface_at(rays[i], hit);
        radiance[i] = at.emission(at.cosine);
      } else {
        radiance[i] = kSky;
      }
    }
  };
}

/// Clouds before surfaces, in clear air.
inline Radiances cloud_and_surfaces(const World& world, const std::vector<Ray>& rays) {
  return [&world, &rays, depths = Depths(world), ends = rays,
          behind = std::vector<double>(kRays)](std::vector<double>& radiance) mutable {
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const SurfaceHit hit = world.surfaces().intersect(rays[i]);
      ends[i].t_max = hit.t;
      behind[i] = kSky;
      if (hit.exists()) {
        const SurfacePoint at = SpectralWorld(world, 0).surface_at(rays[i], hit);
        behind[i] = at.emission(at.cosine);
      }
    }
    const std::span<const double> depth = depths(ends);
    for (std::size_t i = 0; i < rays.size(); ++i)
      radiance[i] = std::exp(-depth[i]) * behind[i] + kSource * one_minus_exp(depth[i]);
  };
}

/// Sunlight scattered once: strata of the depth that a ray loses, a shadow ray from each.
inline Radiances single_scattering(const World& world, const std::vector<Ray>& rays, int points) {
  return [&world, &rays, points, depths = Depths(world), shadow_depths = Depths(world), own = std::vector<Flight>(),
          flights = std::vector<Flight>(), ends = std::vector<FreePath>(), weights = std::vector<double>(),
          owners = std::vector<std::size_t>(), shadows = std::vector<Ray>(),
          lights = std::vector<double>()](std::vector<double>& radiance) mutable {
    const Octree& octree = *world.clouds()[0].octree;
    const Affine& to_index = world.frame(0).world_to_index;
    const PhaseFunction& phase = world.clouds()[0].media[0].phase;
    const Vec3d toward = world.suns()[0].toward;
    const std::array<double, 1> extinction = {kExtinction};
    const double near = 2e-3 * (world.frame(0).local_bounds.max - world.frame(0).local_bounds.min).length();
    constexpr std::size_t kTogether = 4096;
    for (std::size_t first = 0; first < rays.size(); first += kTogether) {
      const auto some = std::span(rays).subspan(first, std::min(kTogether, rays.size() - first));
      const std::span<const double> depth = depths(some);
      own.clear();
      weights.clear();
      owners.clear();
      for (std::size_t i = 0; i < some.size(); ++i) {
        radiance[first + i] = std::exp(-depth[i]) * kSky;
        const double lost = one_minus_exp(depth[i]);
        if (!(lost > 0)) continue;
        const int count = std::max(1, static_cast<int>(std::ceil(lost * points)));
        Stream stream = StreamName{1, first + i, Purpose::radiance}.stream();
        const Ray ray = transform_ray(to_index, some[i]);
        for (int k = 0; k < count; ++k) {
          const double u = (k + stream.uniform()) / count;
          own.push_back({ray, std::min(-std::log1p(-u * lost), depth[i])});
          weights.push_back(kAlbedo * lost / count * kSun);
          owners.push_back(i);
        }
      }
      ends.resize(own.size());
      free_paths(octree, own, extinction, ends);
      shadows.clear();
      lights.clear();
      std::size_t kept = 0;
      for (std::size_t p = 0; p < own.size(); ++p) {
        if (!ends[p].collided) continue;
        const Ray& ray = some[owners[p]];
        // The batched walk is too coarse for the shortest.
        if (ends[p].t - own[p].ray.t_min < near)
          ends[p] = free_path(octree, own[p].ray, extinction, own[p].target_depth);
        lights.push_back(weights[p] * phase.value(toward.dot(ray.direction)));
        shadows.push_back({ray.at(ends[p].t), toward, 0, kInfinity});
        owners[kept++] = owners[p];
      }
      const std::span<const double> dark = shadow_depths(shadows);
      for (std::size_t p = 0; p < kept; ++p) radiance[first + owners[p]] += lights[p] * std::exp(-dark[p]);
    }
  };
}

/// Photons of a parallel sun in one cloud: collisions beyond the first are stored.
inline std::vector<Photon> minimal_photons(const World& world, const PhotonEmitter& emitter, std::uint64_t photons,
                                           double& absorbed) {
  struct History {
    Vec3d position, direction;
    double power;
    int collisions;
    Stream stream;
  };
  const Octree& octree = *world.clouds()[0].octree;
  const Affine& to_index = world.frame(0).world_to_index;
  const PhaseFunction& phase = world.clouds()[0].media[0].phase;
  const std::array<double, 1> extinction = {kExtinction};
  const double near = 2e-3 * (world.frame(0).local_bounds.max - world.frame(0).local_bounds.min).length();
  std::vector<Photon> stored;
  std::vector<History> active;
  std::vector<Flight> flights;
  std::vector<FreePath> ends;
  PhotonEmitter::Cache cache;
  absorbed = 0;
  std::uint64_t first = 0;
  for (std::uint64_t batch = 0; batch < kBatches; ++batch) {
    const std::uint64_t count = photons / kBatches;
    const LowDiscrepancy numbers(1, static_cast<std::uint32_t>(batch));
    for (std::uint64_t begin = 0; begin < count; begin += 2048) {
      active.clear();
      for (std::uint64_t i = begin; i < std::min(begin + 2048, count); ++i) {
        const EmittedPhoton photon = emitter.emit(numbers.point(static_cast<std::uint32_t>(i)), cache);
        active.push_back({photon.position, photon.direction, photon.power / static_cast<double>(photons), 0,
                          StreamName{1, first + i, Purpose::tracing}.stream()});
      }
      while (!active.empty()) {
        flights.clear();
        for (History& h : active) {
          flights.push_back(
              {transform_ray(to_index, {h.position, h.direction, 0, kInfinity}), -std::log(h.stream.uniform())});
        }
        ends.resize(flights.size());
        free_paths(octree, flights, extinction, ends);
        std::size_t kept = 0;
        for (std::size_t i = 0; i < active.size(); ++i) {
          if (!ends[i].collided) continue;
          if (ends[i].t < near) ends[i] = free_path(octree, flights[i].ray, extinction, flights[i].target_depth);
          History& h = active[i];
          h.position += ends[i].t * h.direction;
          if (h.collisions++ > 0) {
            Photon photon;
            photon.position = Vec3f(transform_point(world.world_to_map(), h.position));
            photon.direction = encode_direction(h.direction);
            photon.power = static_cast<float>(h.power);
            photon.batch = static_cast<std::uint16_t>(batch);
            photon.collisions = static_cast<std::uint16_t>(h.collisions - 1);
            stored.push_back(photon);
          }
          if (h.stream.uniform() >= kAlbedo) {
            absorbed += h.power;
            continue;
          }
          h.stream.uniform();
          const double v = h.stream.uniform();
          h.direction = direction_about(h.direction, phase.sample(v, 0), 2 * kPi * h.stream.uniform());
          if (kept != i) active[kept] = h;
          ++kept;
        }
        active.erase(active.begin() + static_cast<std::ptrdiff_t>(kept), active.end());
      }
    }
    first += count;
  }
  return stored;
}

}  // namespace obscura::bench
