// Measures what a compressed tree does to whole rays: their transmission and the radiance that they
// collect, against the lossless tree.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "octree/build/build.h"
#include "octree/tree/octree.h"

namespace obscura::detail {

/// Seeded rays through the part of the tree that is not empty: half of them lines in random directions, a quarter
/// lines along the axes, a quarter segments between random points. t is in metres.
class MeasuringRays {
 public:
  static constexpr std::size_t kCount = 100000;
  static constexpr std::size_t kEmissionCount = 4000;  ///< of them measure the collected radiance too

  MeasuringRays(const Octree& lossless, const ErrorMeasure& measure, std::uint64_t seed);

  struct Errors {
    double transmission = 0;  ///< largest difference over the rays
    double emission = 0;      ///< largest difference of the radiance, relative to the largest possible one
    double largest() const noexcept { return transmission > emission ? transmission : emission; }
  };
  /// Over the first `count` rays.
  Errors compare(const Octree& tree, std::size_t count) const;

 private:
  void prepare(std::size_t count) const;
  double radiance(const Octree& tree, std::size_t ray) const;

  const Octree& lossless_;
  const ErrorMeasure& measure_;
  std::vector<Ray> rays_;
  mutable std::vector<double> depths_;  // of the lossless tree, as many as were needed so far
  mutable std::vector<double> radiances_;
};

}  // namespace obscura::detail
