// A scene's quantities at every spectral interval of its bands, in the order of the World's intervals.
#pragma once

#include <optional>
#include <vector>

#include "photon/optics/band.h"
#include "scene/file/description.h"

namespace obscura::detail {

constexpr double kDegree = kPi / 180;

/// Calls value(band, interval) for every spectral interval of the scene.
template <class F>
auto per_interval(const std::vector<Band>& bands, F&& value) {
  std::vector<decltype(value(std::size_t{0}, 0))> result;
  for (std::size_t b = 0; b < bands.size(); ++b) {
    for (int j = 0; j < bands[b].interval_count(); ++j) result.push_back(value(b, j));
  }
  return result;
}

/// Radiance, irradiance or power: integrated with the response.
inline std::vector<double> integrated(const std::vector<Band>& bands, const Spectrum& spectrum) {
  return per_interval(bands, [&](std::size_t b, int j) { return bands[b].integrate(j, spectrum); });
}

inline std::vector<double> optical(const std::vector<Band>& bands, const Spectrum& spectrum) {
  return per_interval(bands, [&](std::size_t b, int j) { return bands[b].optics(j, spectrum); });
}

/// Of something that has a temperature, a radiance or both.
inline std::vector<double> emitted(const Description& scene, const std::vector<Band>& bands,
                                   const std::optional<double>& K, const std::optional<Spectrum>& radiance) {
  return per_interval(bands, [&](std::size_t b, int j) {
    switch (emitter(scene, scene.bands[b], K.has_value(), radiance.has_value())) {
      case Emitter::planck:
        return bands[b].planck(j, *K);
      case Emitter::radiance:
        return bands[b].integrate(j, *radiance);
      case Emitter::none:
        break;
    }
    return 0.0;
  });
}

}  // namespace obscura::detail
