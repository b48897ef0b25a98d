// Images of one value in each band for a detector to see, and what their values are like.
#pragma once

#include <algorithm>
#include <cstring>
#include <span>
#include <vector>

#include "octree/base/statistics.h"
#include "photon/optics/band.h"
#include "sensor/picture/image.h"

namespace obscura::test {

inline Band lwir() { return Band("lwir", 8, 12); }

// An image of one value in each band.
inline Image uniform(const std::vector<Band>& bands, int columns, int rows, const std::vector<double>& radiance) {
  Image image(columns, rows);
  for (std::size_t b = 0; b < bands.size(); ++b) {
    std::ranges::fill(image.add(bands[b].name() + ".radiance"), static_cast<float>(radiance[b]));
  }
  std::ranges::fill(image.add("rays.N"), 1.0f);
  return image;
}

inline Moments moments(std::span<const float> values) {
  Moments result;
  for (const float value : values) result.add(static_cast<double>(value));
  return result;
}

inline bool same_bits(std::span<const float> a, std::span<const float> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

}  // namespace obscura::test
