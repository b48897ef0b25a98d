#include "sensor/capture/pixel_sum.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace obscura {
namespace {

/// Differences below this share of the values are rounding.
constexpr double kRounding = 1e-12;

bool finite(const RaySample& ray) noexcept {
  if (std::isnan(ray.depth_m)) return false;
  for (const BandSample& band : ray.bands) {
    double sum = band.direct + band.bias + band.variance + band.transmission + band.transmission_atmosphere;
    for (const double value : band.map) sum += value;
    if (!std::isfinite(sum)) return false;
  }
  return true;
}

}  // namespace

double variance_of_mean(const std::array<double, kBatches>& batch, double mean) noexcept {
  double sum = 0;
  for (const double value : batch) sum += (value - mean) * (value - mean);
  return sum / (kBatches * (kBatches - 1.0));
}

double mean_of(const std::array<double, kBatches>& batch) noexcept {
  double sum = 0;
  for (const double value : batch) sum += value;
  return sum / kBatches;
}

double bend(const RayLight& before, const RayLight& middle, const RayLight& after) noexcept {
  const double foreseen = before.foreseen - 2 * middle.foreseen + after.foreseen;
  return before.radiance - 2 * middle.radiance + after.radiance - (std::isnan(foreseen) ? 0.0 : foreseen);
}

double twist(const RayLight& a, const RayLight& b, const RayLight& c, const RayLight& d) noexcept {
  const double foreseen = a.foreseen - b.foreseen + c.foreseen - d.foreseen;
  return a.radiance - b.radiance + c.radiance - d.radiance - (std::isnan(foreseen) ? 0.0 : foreseen);
}

void PixelSum::reset() noexcept {
  std::fill(bands_.begin(), bands_.end(), Sums{});
  weight_ = weight2_ = 0;
  last_ = {};
  known_ = weights_ = {};
  rays_ = 0;
  anomalies_ = 0;
  depth_m_ = kInfinity;
}

PixelSum::Group PixelSum::group() const noexcept {
  const auto& [d, c, b, a] = last_;
  if (rays_ < 2) return Group::none;
  if (!d.place || !c.place) return rays_ > 2 ? Group::row : Group::none;
  const auto x = [](const Sent& sent) { return sent.place->x_min + 0.5 * sent.place->width; };
  const auto y = [](const Sent& sent) { return sent.place->y_min + 0.5 * sent.place->height; };
  const double near_x = 1e-6 * d.place->width, near_y = 1e-6 * d.place->height;
  const auto alike = [&](const Sent& other) {
    return std::abs(other.place->width - d.place->width) < near_x &&
           std::abs(other.place->height - d.place->height) < near_y;
  };
  if (std::abs(x(c) - x(d)) < near_x && std::abs(y(c) - y(d)) < near_y) return Group::same;
  if (rays_ > 3 && alike(a) && alike(b) && alike(c) && std::abs(x(a) - x(b) + x(c) - x(d)) < near_x &&
      std::abs(y(a) - y(b) + y(c) - y(d)) < near_y)
    return Group::square;
  if (rays_ > 2 && alike(b) && alike(c) && std::abs(x(b) - 2 * x(c) + x(d)) < near_x &&
      std::abs(y(b) - 2 * y(c) + y(d)) < near_y)
    return Group::row;
  return Group::none;
}

void PixelSum::add(const RaySample& ray, const RayPart& part) noexcept {
  const double weight = part.weight;
  assert(ray.bands.size() == bands_.size() && weight > 0 && part.paths > 0);
  if (!finite(ray)) {
    ++anomalies_;
    return;
  }
  ++rays_;
  depth_m_ = std::min(depth_m_, ray.depth_m);
  weight_ += weight;
  weight2_ += weight * weight;
  std::ranges::move_backward(last_.begin(), last_.end() - 1, last_.end());
  last_[0] = {part.place, weight, 1.0 / part.paths, part.complex};
  weights_[part.complex] += weight * weight / part.paths;

  const Group group = this->group();
  const std::size_t count = group == Group::square ? 4 : group == Group::row ? 3 : group == Group::same ? 2 : 0;
  // What a difference sees of complex parts is theirs alone: smooth ones scatter little beside them.
  double weight2 = 0, known = 0, complex_known = 0;
  bool complex = false;
  for (std::size_t i = 0; i < count; ++i) {
    const double own = last_[i].weight * last_[i].weight;
    weight2 += own;
    known += own * last_[i].noise;
    complex = complex || last_[i].complex;
    if (last_[i].complex) complex_known += own * last_[i].noise;
  }
  if (count > 0) known_[complex] += complex ? complex_known : known;

  for (std::size_t b = 0; b < bands_.size(); ++b) {
    const BandSample& sample = ray.bands[b];
    Sums& sums = bands_[b];
    const double map = mean_of(sample.map);
    std::ranges::move_backward(sums.last.begin(), sums.last.end() - 1, sums.last.end());
    sums.last[0] = {sample.direct + map, part.foreseen.empty() ? std::nan("") : part.foreseen[b]};
    const auto& [d, c, bb, a] = sums.last;
    double difference = 0, times = 1;
    switch (group) {
      case Group::none:
        break;
      case Group::same:
        difference = d.radiance - c.radiance;
        times = 2;
        break;
      case Group::row:
        difference = bend(bb, c, d);
        times = 6;
        break;
      case Group::square:
        difference = twist(a, bb, c, d);
        times = 4;
    }
    if (std::abs(difference) > kRounding * std::abs(d.radiance))
      sums.squares[complex] += weight2 * difference * difference / times;
    const double radiance = sums.last[0].radiance;
    sums.radiance += (radiance - sums.radiance) * (weight / weight_);
    sums.ray_noise += weight * variance_of_mean(sample.map, map);
    sums.bias += weight * sample.bias;
    sums.variance += weight * sample.variance;
    sums.transmission += weight * sample.transmission;
    sums.transmission_atmosphere += weight * sample.transmission_atmosphere;
    sums.direct += weight * sample.direct;
    for (std::size_t k = 0; k < kBatches; ++k) sums.map[k] += weight * sample.map[k];
  }
}

void PixelSum::ask_pairs(const Sums& sums, Scatter& smooth, Scatter& complex) const noexcept {
  const double all2 = weight_ * weight_;
  for (std::size_t i = 0; i + 1 < std::min<std::size_t>(rays_, last_.size()); ++i) {
    const Sent &a = last_[i], &b = last_[i + 1];
    const RayLight &la = sums.last[i], &lb = sums.last[i + 1];
    const double foreseen = la.foreseen - lb.foreseen;
    const double difference = la.radiance - lb.radiance - (std::isnan(foreseen) ? 0.0 : foreseen);
    Scatter& to = a.complex || b.complex ? complex : smooth;
    const double weight2 = a.weight * a.weight + b.weight * b.weight;
    if (std::abs(difference) > kRounding * std::abs(la.radiance))
      to.square += weight2 * difference * difference / 2 / all2;
    to.known += (a.weight * a.weight * a.noise + b.weight * b.weight * b.noise) / all2;
  }
}

PixelBand PixelSum::band(int index) const noexcept {
  PixelBand result;
  if (rays_ == 0) return result;
  const Sums& sums = bands_[static_cast<std::size_t>(index)];
  result.radiance = sums.radiance;
  result.bias = sums.bias / weight_;
  result.transmission = sums.transmission / weight_;
  result.transmission_atmosphere = sums.transmission_atmosphere / weight_;

  // Batches are replicas of the map: their scatter holds all of its noise, shared by the rays or not.
  std::array<double, kBatches> map;
  for (std::size_t k = 0; k < kBatches; ++k) {
    map[k] = sums.map[k] / weight_;
    result.batch[k] = sums.direct / weight_ + map[k];
  }
  const double batch_variance = result.map_variance = variance_of_mean(map, mean_of(map));

  // Rays are stratified and successive ones are neighbours: a slope of the picture is no noise, and differences that
  // no slope moves do not see it.
  // Rays scatter by what they see and by the map's noise that they do not share; the latter is in
  // the batches already and comes off (sensor/METHODS.md, "The error of a pixel").
  const double all2 = weight_ * weight_;
  result.smooth = {sums.squares[0] / all2, known_[0] / all2, weights_[0] / all2};
  result.complex = {sums.squares[1] / all2, known_[1] / all2, weights_[1] / all2};
  if (rays_ > 1 && !(known_[0] + known_[1] > 0)) ask_pairs(sums, result.smooth, result.complex);
  if (rays_ == 1) result.ray_variance = std::max(0.0, sums.variance / weight_ - batch_variance) + sums.spread;
  if (rays_ > 1) {
    const double share2 = weight2_ / all2;  // 1/n where all weigh the same
    result.counted_twice = std::max(0.0, (sums.ray_noise / weight_ - batch_variance) * share2 / (1 - share2));
    // Rays of a kind without neighbours that tell are taken for those of the other.
    const auto variance = [](const Scatter& own, const Scatter& other) {
      return own.known > 0 || !(other.known > 0) ? own.variance() : own.weight * other.square / other.known;
    };
    result.ray_variance = std::max(
        0.0, variance(result.smooth, result.complex) + variance(result.complex, result.smooth) - result.counted_twice);
  }
  result.variance = batch_variance + result.ray_variance;
  return result;
}

}  // namespace obscura
