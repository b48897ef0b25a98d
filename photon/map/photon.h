// A photon as it is stored at a collision: 24 bytes, position relative to its map's origin. Who makes
// photons is the tracing; who holds them is PhotonMap.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "octree/base/math.h"

namespace obscura {

/// Histories are dealt to this many independent replicas, whose scatter is the error of an estimate.
inline constexpr int kBatches = 16;

namespace detail {

/// A unit vector in octahedral coordinates, two whole numbers from 0 to 2 `half`.
template <int half>
inline std::pair<std::uint32_t, std::uint32_t> octahedral(const Vec3d& direction) noexcept {
  const double scale = 1.0 / (std::abs(direction.x) + std::abs(direction.y) + std::abs(direction.z));
  double u = direction.x * scale;
  double v = direction.y * scale;
  if (direction.z < 0) {
    const double folded = (1 - std::abs(v)) * std::copysign(1.0, u);
    v = (1 - std::abs(u)) * std::copysign(1.0, v);
    u = folded;
  }
  const auto quantise = [](double t) {
    return static_cast<std::uint32_t>(std::clamp(t * half + (half + 0.5), 0.0, 2.0 * half));
  };
  return {quantise(u), quantise(v)};
}

template <int half>
inline Vec3d from_octahedral(std::uint32_t i, std::uint32_t j) noexcept {
  double u = (static_cast<double>(i) - half) * (1.0 / half);
  double v = (static_cast<double>(j) - half) * (1.0 / half);
  const double z = 1 - std::abs(u) - std::abs(v);
  const double fold = std::max(-z, 0.0);
  u -= std::copysign(fold, u);
  v -= std::copysign(fold, v);
  const double scale = 1 / std::sqrt(u * u + v * v + z * z);
  return {u * scale, v * scale, z * scale};
}

}  // namespace detail

/// A unit vector in 2 x 16 bits, octahedral map of Cigolle et al., "A survey of efficient
/// representations for independent unit vectors" (JCGT 3(2), 2014). Off by less than 7e-5 rad; the six
/// axes are exact. The vector need not be normalised, but must not be 0.
inline std::uint32_t encode_direction(const Vec3d& direction) noexcept {
  const auto [u, v] = detail::octahedral<32767>(direction);
  return u | v << 16;
}

/// The unit vector that encode_direction() has stored.
inline Vec3d decode_direction(std::uint32_t bits) noexcept {
  return detail::from_octahedral<32767>(bits & 0xFFFFu, bits >> 16);
}

/// The same in 16 bits, off by less than 1 degree: enough to tell the sides of surfaces apart.
inline std::uint16_t encode_normal(const Vec3d& normal) noexcept {
  const auto [u, v] = detail::octahedral<127>(normal);
  return static_cast<std::uint16_t>(u | v << 8);
}
inline Vec3d decode_normal(std::uint16_t bits) noexcept {
  return detail::from_octahedral<127>(bits & 0xFFu, bits >> 8);
}

/// Light that arrives at a collision, or at a surface.
struct Photon {
  Vec3f position;               ///< m, relative to the origin of its map
  std::uint32_t direction = 0;  ///< where it travels, see encode_direction()
  float power = 0;              ///< W, before roulette, divided by the emitted number of the whole map
  std::uint8_t batch = 0;       ///< 0 .. kBatches - 1, by history
  std::uint8_t split = 0;       ///< a label of whoever traces; neither tree nor estimate looks at it
  /// Collisions of its history before this one; of light at a surface, the normal of the side that it
  /// has met, see encode_normal().
  std::uint16_t collisions = 0;
};
static_assert(sizeof(Photon) == 24);

}  // namespace obscura
