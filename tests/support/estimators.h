// One World, one number, by every Monte Carlo estimator of the library: photon map, final gather, paths.
#pragma once

#include <span>
#include <vector>

#include "photon/paths/fluence.h"
#include "photon/paths/path_tracer.h"
#include "tests/support/worlds.h"

namespace obscura::test {

struct Estimator {
  const char* name;
  int bounces;  ///< RadianceSettings::gather_bounces
};
inline constexpr Estimator kPhotonMap{"photon map", 0}, kFinalGather{"final gather", 1}, kPaths{"paths", kAllBounces};
inline constexpr Estimator kEstimators[] = {kPhotonMap, kFinalGather, kPaths};

inline RadianceSettings settings_of(const Estimator& estimator, RadianceSettings settings = {}) {
  settings.gather_bounces = estimator.bounces;
  return settings;
}

struct Seen {
  double mean = 0;
  double error = 0;  ///< of rays and, with a map, of its batches
  double bias = 0;   ///< as the map estimates it
  std::uint64_t anomalies = 0;
};

/// The mean over rays, each taken `count` times.
inline Seen seen(const World& world, const Light& light, const Estimator& estimator, std::span<const Ray> rays,
                 int count, RadianceSettings settings = {}) {
  settings = settings_of(estimator, settings);
  std::vector<Ray> all;
  std::vector<std::uint64_t> histories;
  for (int i = 0; i < count; ++i) {
    for (const Ray& ray : rays) {
      histories.push_back(histories.size());
      all.push_back(ray);
    }
  }
  std::vector<Incoming> incoming(all.size());
  const PhotonMaps* maps = estimator.bounces == kAllBounces || light.maps.empty() ? nullptr : &light.maps[0];
  Seen result;
  result.anomalies = incoming_radiance(world, 0, maps, settings, all, histories, incoming).anomalies;
  Moments total;
  std::array<double, kBatches> batches{};
  const auto n = static_cast<double>(incoming.size());
  for (const Incoming& in : incoming) {
    total.add(in.total());
    result.bias += in.bias / n;
    for (std::size_t b = 0; b < batches.size(); ++b) batches[b] += in.map[b] / n;
  }
  result.mean = total.mean();
  result.error = std::hypot(total.standard_error(), batch_mean(batches).standard_error);
  return result;
}

/// Integral of radiance over the sphere.
inline BatchMean fluence_by(const World& world, const Light& light, const Estimator& estimator, const Vec3d& point,
                            int directions, std::uint64_t history = 1) {
  const PhotonMaps* maps = estimator.bounces == kAllBounces || light.maps.empty() ? nullptr : &light.maps[0];
  return fluence(world, 0, maps, settings_of(estimator), point, directions, history);
}

}  // namespace obscura::test
