// The values of one brick, unpacked, and what they become where cells are merged. Internal to analyse() and compress().
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octree/build/build.h"
#include "octree/tree/layout.h"

namespace obscura::detail {

/// 8^3 values of each channel of a brick. Load one after the other into the same object: its memory is used again.
class BrickValues {
 public:
  /// @pre tree and measure outlive this, and fit each other
  BrickValues(const TreeData& tree, const ErrorMeasure& measure);

  /// Unpacks the brick of this word of the tree's table. Voxels that neither attenuate nor emit become 0 in all
  /// channels: none of their other properties can be seen.
  void load(std::uint32_t word);

  /// @param i  voxel of the brick, x fastest, 0 to 511
  float value(std::size_t channel, std::size_t i) const { return values_[512 * channel + i]; }
  /// 1/m, summed over the channels that attenuate.
  double extinction(std::size_t i) const {
    double sum = 0;
    for (std::size_t c = 0; c < channels_; ++c) {
      sum += measure_.optical_weight[c] * static_cast<double>(values_[512 * c + i]);
    }
    return sum;
  }

  /// ErrorMeasure::emission of every voxel; nothing where nothing is emitted.
  void emissions(std::vector<double>& result) const;

  /// The values of a cell whose voxels are merged, one per channel: their means; of channels that do not attenuate,
  /// means weighted by the extinction. What a channel tells counts as far as it can be seen.
  /// @param level  of the cell, 0 to 3 @param cell  its number among the brick's cells of that level, x fastest
  void merged(int level, std::size_t cell, std::span<float> result) const;

  /// How far the voxels of a cell lie from the values it would be merged to, at most.
  struct Deviation {
    double extinction = 0;  ///< 1/m
    double emission = 0;    ///< in the measure's unit
    double relative = 0;    ///< of channels that do not attenuate, where no emission tells what they are worth
  };
  /// @param emissions  what emissions() gave
  Deviation deviation(int level, std::size_t cell, std::span<const float> from,
                      std::span<const double> emissions) const;

 private:
  template <class F>
  void for_each_voxel(int level, std::size_t cell, F&& f) const;

  const TreeData& tree_;
  const ErrorMeasure& measure_;
  std::size_t channels_;
  bool attenuates_ = false;
  std::vector<float> values_;
};

}  // namespace obscura::detail
