#include "sensor/sampler.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "photon/purpose.h"

namespace obscura {

Stratum stratum(int index, int count) noexcept {
  // Row r holds cells [r * count / rows, (r + 1) * count / rows): its height is its share of them.
  const int rows = std::max(1, static_cast<int>(std::lround(std::sqrt(static_cast<double>(count)))));
  const auto first_of = [&](int row) {
    return static_cast<int>(static_cast<std::int64_t>(row) * count / rows);
  };
  int row = static_cast<int>(static_cast<std::int64_t>(index) * rows / count);
  while (first_of(row + 1) <= index) ++row;
  while (first_of(row) > index) --row;

  const int first = first_of(row);
  const int cells = first_of(row + 1) - first;
  Stratum cell;
  cell.width = 1.0 / cells;
  cell.height = static_cast<double>(cells) / count;
  // There and back, so that successive cells touch.
  cell.x_min = (row % 2 ? first + cells - 1 - index : index - first) * cell.width;
  cell.y_min = static_cast<double>(first) / count;
  return cell;
}

std::optional<PixelRay> PixelRays::next() noexcept {
  if (index_ == count_) return std::nullopt;
  const Stratum cell = stratum(index_, count_);
  PixelRay result;
  result.px = x_ + cell.x_min + cell.width * stream_.uniform();
  result.py = y_ + cell.y_min + cell.height * stream_.uniform();
  result.ray = camera_->ray(result.px, result.py);
  result.history = history_ + static_cast<std::uint64_t>(index_);
  ++index_;
  return result;
}

Sampler::Sampler(const Camera& camera, const SamplerSettings& settings)
    : camera_(&camera), settings_(settings) {
  assert(settings.max_oversampling >= 1);
}

PixelRays Sampler::pixel(int x, int y) const noexcept {
  const auto pixels = static_cast<std::uint64_t>(camera_->columns()) *
                      static_cast<std::uint64_t>(camera_->rows());
  const std::uint64_t pixel = static_cast<std::uint64_t>(settings_.pass) * pixels +
                              static_cast<std::uint64_t>(y) *
                                  static_cast<std::uint64_t>(camera_->columns()) +
                              static_cast<std::uint64_t>(x);
  const int count = settings_.max_oversampling;
  return PixelRays(*camera_, x, y, count, pixel * static_cast<std::uint64_t>(count),
                   Stream(settings_.seed, pixel, purpose_id(Purpose::pixel)));
}

}  // namespace obscura
