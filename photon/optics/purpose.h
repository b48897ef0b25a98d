// What a stream of random numbers is for; with seed and history it names the stream.
#pragma once

#include <cstdint>

namespace obscura {

enum class Purpose : std::uint32_t {
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

/// Streams of one purpose are kept apart by the spectral interval they serve.
constexpr std::uint32_t purpose_id(Purpose purpose, int interval = 0) noexcept {
  return static_cast<std::uint32_t>(purpose) + 256u * static_cast<std::uint32_t>(interval);
}

}  // namespace obscura
