// The parts of a tile's pixels, each of which gets a ray of its own.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "photon/paths/radiance.h"
#include "photon/spot/spot.h"
#include "sensor/capture/film.h"
#include "sensor/capture/sampler.h"

namespace obscura {

/// Which rays were traced, and for what.
struct RayCounts {
  std::uint64_t base = 0;                        ///< one in each pixel (all, where every pixel gets as many)
  std::uint64_t deciding = 0;                    ///< at corners of pixels and their parts; not averaged
  std::array<std::uint64_t, kCriteria> asked{};  ///< beyond the first, by the criterion that asked

  RayCounts& operator+=(const RayCounts& other) noexcept;
};

/// The slope of a part as its corners tell it, a function of the place in the part (-1/2 to 1/2 across and down) whose
/// mean is 0.
struct Slope {
  double across = 0, down = 0, twist = 0;

  double operator()(double x, double y) const noexcept { return across * x + down * y + twist * x * y; }
};

/// What is taken off each ray of a part before averaging: that lowers the noise and, whatever the corners have met,
/// leaves the mean alone.
struct Ramp {
  Slope radiance;
  Slope transmission;   ///< with the same share of the corners' slope, so that both are of the same place
  double strength = 0;  ///< that share, as far as it is trusted, [0, 1]
  /// Mean radiance of the corners where they know the slope well; NaN: they do not.
  double mean = std::numeric_limits<double>::quiet_NaN();
};

/// The parts of a tile's pixels.
struct TileStrata {
  std::vector<Stratum> strata;       // pixel by pixel, neighbours in succession
  std::vector<char> complex;         // of each part: what would split it further is in it
  std::vector<Ramp> ramps;           // of each part in each band; none where its corners are not known
  std::vector<std::size_t> first;    // of each pixel, and the end
  std::vector<Criterion> criterion;  // of each pixel: what has asked for most of them
  RayCounts rays;
  RadianceCounts counts;

  std::span<const Stratum> of(std::size_t pixel) const noexcept {
    return std::span(strata).subspan(first[pixel], first[pixel + 1] - first[pixel]);
  }
};

/// Every pixel in the sampler's own strata. Surfaces are asked which of them hold an edge.
TileStrata even_strata(const World& world, const Sampler& sampler, const FilmTile& tile);

}  // namespace obscura
