// One World, one number, by every Monte Carlo estimator of the library: photon map, final gather, paths.
#pragma once

#include <span>
#include <vector>

#include "photon/methods/method.h"
#include "photon/paths/fluence.h"
#include "tests/support/worlds.h"

namespace obscura::test {

inline constexpr const MethodType* kMonteCarlo[] = {&kPhotonMap, &kFinalGather, &kPathTracer};

inline RadianceSettings settings_of(const MethodType& method, RadianceSettings settings = {}) {
  settings.gather_bounces = !method.photons ? kAllBounces : method.samples ? 1 : 0;
  return settings;
}

inline const PhotonMaps* maps_of(const MethodType& method, const Light& light) {
  return !method.photons || light.maps.empty() ? nullptr : &light.maps[0];
}

struct Seen {
  double mean = 0;
  double error = 0;  ///< of rays and, with a map, of its batches
  double bias = 0;   ///< as the map estimates it
  std::uint64_t anomalies = 0;
};

/// The mean over rays, each taken `count` times.
inline Seen seen(const World& world, const Light& light, const MethodType& method, std::span<const Ray> rays, int count,
                 RadianceSettings settings = {}) {
  settings = settings_of(method, settings);
  std::vector<Ray> all;
  std::vector<std::uint64_t> histories;
  for (int i = 0; i < count; ++i) {
    for (const Ray& ray : rays) {
      histories.push_back(histories.size());
      all.push_back(ray);
    }
  }
  std::vector<Incoming> incoming(all.size());
  const PhotonMaps* maps = maps_of(method, light);
  Seen result;
  result.anomalies = incoming_radiance({world, 0}, maps, settings, all, histories, incoming).anomalies;
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
inline BatchMean fluence_by(const World& world, const Light& light, const MethodType& method, const Vec3d& point,
                            int directions, std::uint64_t history = 1) {
  const PhotonMaps* maps = maps_of(method, light);
  return fluence({world, 0}, maps, settings_of(method), point, directions, history);
}

}  // namespace obscura::test
