// A photon as it is stored at a collision: 24 bytes, position relative to its map's origin. Who makes
// photons is the tracing; who holds them is PhotonMap.
#pragma once

#include "octree/base/math.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace obscura {

/// Histories are dealt to this many independent replicas, whose scatter is the error of an estimate.
inline constexpr int kBatches = 16;

/// A unit vector in 2 x 16 bits, octahedral map of Cigolle et al., "A survey of efficient
/// representations for independent unit vectors" (JCGT 3(2), 2014). Off by less than 7e-5 rad; the six
/// axes are exact. The vector need not be normalised, but must not be 0.
inline std::uint32_t encode_direction(const Vec3d& direction) noexcept {
  const double scale = 1.0 / (std::abs(direction.x) + std::abs(direction.y) + std::abs(direction.z));
  double u = direction.x * scale;
  double v = direction.y * scale;
  if (direction.z < 0) {
    const double folded = (1 - std::abs(v)) * std::copysign(1.0, u);
    v = (1 - std::abs(u)) * std::copysign(1.0, v);
    u = folded;
  }
  const auto quantise = [](double t) {
    return static_cast<std::uint32_t>(std::clamp(t * 32767.0 + 32767.5, 0.0, 65534.0));
  };
  return quantise(u) | quantise(v) << 16;
}

/// The unit vector that encode_direction() has stored.
inline Vec3d decode_direction(std::uint32_t bits) noexcept {
  double u = (static_cast<double>(bits & 0xFFFFu) - 32767.0) * (1.0 / 32767.0);
  double v = (static_cast<double>(bits >> 16) - 32767.0) * (1.0 / 32767.0);
  const double z = 1 - std::abs(u) - std::abs(v);
  const double fold = std::max(-z, 0.0);
  u -= std::copysign(fold, u);
  v -= std::copysign(fold, v);
  const double scale = 1 / std::sqrt(u * u + v * v + z * z);
  return {u * scale, v * scale, z * scale};
}

/// Light that arrives at a collision.
struct Photon {
  Vec3f position;              ///< m, relative to the origin of its map
  std::uint32_t direction = 0; ///< where it travels, see encode_direction()
  float power = 0;             ///< W, before roulette, divided by the emitted number of the whole map
  std::uint8_t batch = 0;      ///< 0 .. kBatches - 1, by history
  std::uint8_t split = 0;      ///< a label of whoever traces; neither tree nor estimate looks at it
  std::uint16_t collisions = 0;///< of its history before this one
};
static_assert(sizeof(Photon) == 24);

}  // namespace obscura
