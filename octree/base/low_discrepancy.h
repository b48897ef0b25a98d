// Low-discrepancy points: the Sobol sequence with Owen scrambling, one independent replica per
// (seed, batch), so that the scatter between batches is the error of their mean.
#pragma once

#include <array>
#include <cstdint>

namespace obscura {

/// Points of the Sobol sequence (direction numbers of Joe & Kuo, "Constructing Sobol sequences with
/// better two-dimensional projections", SIAM J. Sci. Comput. 30, 2008), scrambled by a hash that
/// flips each binary digit depending on the digits before it (Owen 1995, as in Burley,
/// "Practical hash-based Owen scrambling", JCGT 9(4), 2020). Any number of points is unbiased when
/// scrambled; powers of two are the most even.
class LowDiscrepancy {
 public:
  static constexpr int kDimensions = 8;

  /// @param scrambled false: the plain sequence, the same for every seed and batch; it carries no
  ///   standard error.
  LowDiscrepancy(std::uint64_t seed, std::uint32_t batch, bool scrambled = true) noexcept;

  /// Point number `index`; every coordinate in the open interval (0, 1), 52 bits (plain: 32 bits).
  std::array<double, kDimensions> point(std::uint32_t index) const noexcept;

 private:
  std::array<std::uint32_t, kDimensions> scramble_{};  // decides the 32 digits of the sequence
  std::array<std::uint32_t, kDimensions> tail_{};      // decides the digits after them
  bool scrambled_;
};

}  // namespace obscura
