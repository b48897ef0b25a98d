// Rays that decide where to refine, at the corners of pixels and of their parts. They are never averaged.
#pragma once

#include <compare>
#include <cstdint>
#include <span>

#include "sensor/capture/estimator.h"
#include "sensor/capture/sampler.h"

namespace obscura {

/// What rays at the corners of spots have met; corners are numbered on the finest grid that there may be.
class CornerRays {
 public:
  struct Corner {
    std::uint32_t x, y;
    auto operator<=>(const Corner&) const = default;
  };

  /// @param levels how often a pixel may be split
  CornerRays(const World& world, const RadianceEstimator& estimator, const Sampler& sampler, int levels);

  /// Floats per corner: the sunlit share, then per band transmission, radiance and its variance.
  std::size_t stride() const noexcept { return 1 + 3 * static_cast<std::size_t>(bands_); }
  int bands() const noexcept { return bands_; }
  int levels() const noexcept { return levels_; }

  /// @param values stride() for each corner
  RadianceCounts trace(std::span<const Corner> corners, std::span<float> values) const;

 private:
  const World* world_;
  const RadianceEstimator* estimator_;
  const Sampler* sampler_;
  int levels_;
  int bands_;
  bool shadows_;
};

}  // namespace obscura
