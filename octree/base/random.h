// Counter-based random numbers: a value belongs to (seed, history, purpose) and its place in that
// stream, never to a thread, so results are the same bits on any number of threads.
#pragma once

#include <array>
#include <cstdint>

namespace obscura {

/// Philox4x32-10 of Salmon et al., "Parallel random numbers: as easy as 1, 2, 3" (SC11).
constexpr std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter,
                                                  std::array<std::uint32_t, 2> key) noexcept {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t a = std::uint64_t{0xD2511F53u} * counter[0];
    const std::uint64_t b = std::uint64_t{0xCD9E8D57u} * counter[2];
    counter = {static_cast<std::uint32_t>(b >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(b),
               static_cast<std::uint32_t>(a >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(a)};
    key[0] += 0x9E3779B9u;
    key[1] += 0xBB67AE85u;
  }
  return counter;
}

/// A stream of independent uniform numbers. Cheap to make (no state but a counter): make one where
/// it is needed.
class Stream {
 public:
  /// @param purpose  keeps streams of one history apart (emission, tracing, a pixel's rays ...)
  /// @param more     further digits of the purpose
  /// Two streams of one seed differ where history, purpose or more do: the counter holds the former two, and
  /// the key differs with the last, since multiplying by an odd number gives each 64-bit number another one.
  constexpr Stream(std::uint64_t seed, std::uint64_t history, std::uint32_t purpose, std::uint64_t more = 0) noexcept
      : key_{static_cast<std::uint32_t>(seed ^ more * kOdd), static_cast<std::uint32_t>((seed ^ more * kOdd) >> 32)},
        counter_{0, purpose, static_cast<std::uint32_t>(history), static_cast<std::uint32_t>(history >> 32)} {}

  constexpr std::uint32_t bits() noexcept {
    if (used_ == 4) {
      block_ = philox4x32(counter_, key_);
      ++counter_[0];
      used_ = 0;
    }
    return block_[used_++];
  }

  /// Uniform in the open interval (0, 1): never 0, so that its logarithm is finite. 53 bits.
  constexpr double uniform() noexcept {
    const std::uint64_t high = bits() >> 5;  // 27 bits
    const std::uint64_t low = bits() >> 6;   // 26 bits
    return (static_cast<double>((high << 26) | low) + 0.5) * 0x1p-53;
  }

 private:
  static constexpr std::uint64_t kOdd = 0x9E3779B97F4A7C15u;  // 2^64 over the golden ratio: neighbours get far apart

  std::array<std::uint32_t, 2> key_;
  std::array<std::uint32_t, 4> counter_;
  std::array<std::uint32_t, 4> block_{};
  int used_ = 4;
};

}  // namespace obscura
