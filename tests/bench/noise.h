// Seeded noise for the benchmarks' clouds.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace obscura::bench {

/// A smooth lattice noise in [0, 1): trilinear between hashed corners.
inline double value_noise(std::uint32_t seed, double x, double y, double z) {
  const double fx = std::floor(x), fy = std::floor(y), fz = std::floor(z);
  const auto corner = [&](int k) {
    std::uint32_t h = seed;
    for (const int v :
         {static_cast<int>(fx) + (k & 1), static_cast<int>(fy) + (k >> 1 & 1), static_cast<int>(fz) + (k >> 2)}) {
      h = (h ^ static_cast<std::uint32_t>(v)) * 0x9E3779B1u;
      h ^= h >> 15;
      h *= 0x85EBCA77u;
      h ^= h >> 13;
    }
    return h * 0x1p-32;
  };
  const auto ease = [](double t) { return t * t * (3 - 2 * t); };
  const double u = ease(x - fx), v = ease(y - fy), w = ease(z - fz);
  const auto mix = [](double a, double b, double t) { return a + (b - a) * t; };
  return mix(mix(mix(corner(0), corner(1), u), mix(corner(2), corner(3), u), v),
             mix(mix(corner(4), corner(5), u), mix(corner(6), corner(7), u), v), w);
}

inline constexpr double kFractalRadius = 0.42;  // of the side

/// Billows down to the voxel inside a ball in a cube of n voxels a side: rough in every cell.
inline float fractal_density(int n, int x, int y, int z) {
  const double centre = 0.5 * n;
  const double far = std::hypot(x - centre, y - centre, z - centre) / (kFractalRadius * n);
  if (far >= 1) return 0.0f;
  double sum = 0, amplitude = 0.5, frequency = 5.0 / n;
  for (std::uint32_t octave = 0; frequency < 0.6; ++octave) {
    sum += amplitude * value_noise(octave, x * frequency, y * frequency, z * frequency);
    amplitude *= 0.62;
    frequency *= 2;
  }
  return static_cast<float>(std::max(0.0, sum - 0.62 - 0.25 * far * far));
}

}  // namespace obscura::bench
