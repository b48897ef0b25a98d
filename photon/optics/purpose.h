// The name of a stream of random numbers: whose it is and what it is for.
#pragma once

#include <cassert>
#include <cstdint>

#include "octree/base/random.h"

namespace obscura {

enum class Purpose : std::uint8_t {
  none = 0,  ///< what is the same in every run: the rays of the discrete ordinates
  emission = 1,
  tracing,
  pixel,
  radiance,
  probe,
  chord,
  disc,
  detector_noise,
  detector_pattern,
  sunlight
};

/// Two names of one seed that differ anywhere never give the same numbers.
struct StreamName {
  std::uint64_t seed = 0;
  std::uint64_t history = 0;  ///< a photon, a ray, a pixel
  Purpose purpose = Purpose::none;
  int interval = 0;        ///< spectral interval (a detector: band) that it serves, 0 to 2^24 - 1
  std::uint64_t step = 0;  ///< of what a history does one after another, each with a stream of its own

  /// The first 256 intervals and 65,536 steps lie in the 32 bits of Stream's purpose beside this one; of those beyond,
  /// the higher digits, 16 bits of the interval and 48 of the step, are what Stream takes as `more`.
  constexpr Stream stream() const noexcept {
    assert(interval >= 0 && interval < 1 << 24);
    const auto i = static_cast<std::uint32_t>(interval);
    return {seed, history,
            static_cast<std::uint32_t>(purpose) | (i & 0xFFu) << 8 | static_cast<std::uint32_t>(step & 0xFFFFu) << 16,
            std::uint64_t{i >> 8} | step >> 16 << 16};
  }
};

}  // namespace obscura
