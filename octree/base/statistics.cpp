#include "octree/base/statistics.h"

namespace obscura {

BatchMean batch_mean(std::span<const double> batches) noexcept {
  if (batches.empty()) return {};
  const double count = static_cast<double>(batches.size());
  const double mean = pairwise_sum(batches) / count;
  if (batches.size() < 2) return {mean, std::numeric_limits<double>::infinity()};
  double squares = 0;
  for (const double x : batches) squares += (x - mean) * (x - mean);
  return {mean, std::sqrt(squares / (count * (count - 1)))};
}

double pairwise_sum(std::span<const double> values) noexcept {
  if (values.size() <= 32) {
    double sum = 0;
    for (const double x : values) sum += x;
    return sum;
  }
  const std::size_t half = values.size() / 2;
  return pairwise_sum(values.first(half)) + pairwise_sum(values.subspan(half));
}

}  // namespace obscura
