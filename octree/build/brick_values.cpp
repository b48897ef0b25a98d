#include "octree/build/brick_values.h"

#include <algorithm>
#include <cmath>

namespace obscura::detail {

BrickValues::BrickValues(const TreeData& tree, const ErrorMeasure& measure)
    : tree_(tree), measure_(measure), channels_(tree.channels.size()), values_(512 * channels_) {
  for (const double w : measure.optical_weight) attenuates_ = attenuates_ || w > 0;
}

void BrickValues::load(std::uint32_t word) {
  for (std::size_t c = 0; c < channels_; ++c) {
    unpack_brick(tree_.record(word), tree_.header(word, static_cast<int>(c)),
                 std::span<float, 512>(&values_[512 * c], 512));
  }
  if (!attenuates_ || !measure_.emission) return;
  std::vector<float> at(channels_);
  for (std::size_t i = 0; i < 512; ++i) {
    if (extinction(i) != 0) continue;
    bool any = false;
    for (std::size_t c = 0; c < channels_; ++c) any = any || (at[c] = values_[512 * c + i]) != 0;
    if (!any || measure_.emission(at) != 0) continue;
    for (std::size_t c = 0; c < channels_; ++c) values_[512 * c + i] = 0;
  }
}

void BrickValues::emissions(std::vector<double>& result) const {
  result.clear();
  if (!measure_.emission) return;
  result.resize(512);
  std::vector<float> at(channels_);
  for (std::size_t i = 0; i < 512; ++i) {
    for (std::size_t c = 0; c < channels_; ++c) at[c] = value(c, i);
    result[i] = measure_.emission(at);
  }
}

// f(voxel) for each voxel of a cell.
template <class F>
void BrickValues::for_each_voxel(int level, std::size_t cell, F&& f) const {
  const std::size_t bits = static_cast<std::size_t>(3 - level), mask = (std::size_t{1} << bits) - 1;
  const std::size_t side = std::size_t{1} << level;
  const std::size_t x0 = (cell & mask) << level, y0 = ((cell >> bits) & mask) << level,
                    z0 = (cell >> (2 * bits)) << level;
  for (std::size_t z = z0; z < z0 + side; ++z) {
    for (std::size_t y = y0; y < y0 + side; ++y) {
      for (std::size_t x = x0; x < x0 + side; ++x) f(x + 8 * y + 64 * z);
    }
  }
}

void BrickValues::merged(int level, std::size_t cell, std::span<float> result) const {
  if (level == 0) {
    for (std::size_t c = 0; c < channels_; ++c) result[c] = values_[512 * c + cell];
    return;
  }
  double weight = 0;
  for_each_voxel(level, cell, [&](std::size_t i) { weight += extinction(i); });
  for (std::size_t c = 0; c < channels_; ++c) {
    double sum = 0;
    const bool weighted = measure_.optical_weight[c] == 0 && weight > 0;
    for_each_voxel(level, cell,
                   [&](std::size_t i) { sum += static_cast<double>(value(c, i)) * (weighted ? extinction(i) : 1.0); });
    result[c] = static_cast<float>(sum / (weighted ? weight : std::ldexp(1.0, 3 * level)));
  }
}

BrickValues::Deviation BrickValues::deviation(int level, std::size_t cell, std::span<const float> from,
                                              std::span<const double> emissions) const {
  Deviation largest;
  const double emission_from = emissions.empty() ? 0.0 : measure_.emission(from);
  for_each_voxel(level, cell, [&](std::size_t i) {
    double sum = 0;
    for (std::size_t c = 0; c < channels_; ++c) {
      const double v = static_cast<double>(value(c, i)), d = std::abs(v - static_cast<double>(from[c]));
      sum += measure_.optical_weight[c] * d;
      if (measure_.optical_weight[c] == 0 && emissions.empty() && d > 0) {
        largest.relative =
            std::max(largest.relative, d / std::max(std::abs(v), std::abs(static_cast<double>(from[c]))));
      }
    }
    largest.extinction = std::max(largest.extinction, sum);
    if (!emissions.empty()) largest.emission = std::max(largest.emission, std::abs(emissions[i] - emission_from));
  });
  return largest;
}

}  // namespace obscura::detail
