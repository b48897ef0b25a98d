#include "sensor/judge/picture_error.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "octree/base/error_scale.h"

namespace obscura {
namespace {

/// About so many tiles does the jackknife cut a picture into.
constexpr double kTiles = 48;
/// Errors of pixels darker than this share of the largest radiance are relative to that share (sensor/METHODS.md,

/// Weights of the pixels: the mean of weight times squared difference is the square of the image error.
std::vector<double> weights_of(const std::vector<float>& reference) {
  double largest = 0;
  for (const float value : reference) largest = std::max(largest, std::abs(static_cast<double>(value)));
  std::vector<double> weights(reference.size(), 0.0);
  for (std::size_t p = 0; p < weights.size(); ++p) {
    const double scale = error_scale(reference[p], largest);
    if (scale > 0) weights[p] = 1 / (scale * scale);
  }
  return weights;
}

/// Means over pixels of several quantities, each with a jackknife's error over tiles.
template <std::size_t N>
class TileMeans {
 public:
  TileMeans(int columns, int rows)
      : columns_(columns),
        side_(std::max(1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(columns) * rows / kTiles))))),
        across_((columns + side_ - 1) / side_),
        tiles_(static_cast<std::size_t>(across_ * ((rows + side_ - 1) / side_))) {}

  void add(std::size_t pixel, const std::array<double, N>& values) {
    const int x = static_cast<int>(pixel) % columns_, y = static_cast<int>(pixel) / columns_;
    Tile& tile = tiles_[static_cast<std::size_t>(y / side_ * across_ + x / side_)];
    ++tile.count;
    for (std::size_t k = 0; k < N; ++k) tile.sum[k] += values[k];
  }

  RootError mean(std::size_t k) const {
    double sum = 0, count = 0;
    for (const Tile& tile : tiles_) sum += tile.sum[k], count += tile.count;
    RootError result;
    if (!(count > 0)) return result;
    result.square = sum / count;
    const auto tiles = static_cast<double>(tiles_.size());
    if (tiles < 2) return result;
    double mean = 0, squares = 0;
    const auto without = [&](const Tile& tile) { return (sum - tile.sum[k]) / (count - tile.count); };
    for (const Tile& tile : tiles_) mean += without(tile) / tiles;
    for (const Tile& tile : tiles_) squares += (without(tile) - mean) * (without(tile) - mean);
    result.square_error = std::sqrt((tiles - 1) / tiles * squares);
    return result;
  }

 private:
  struct Tile {
    std::array<double, N> sum{};
    double count = 0;
  };
  int columns_, side_, across_;
  std::vector<Tile> tiles_;
};

}  // namespace

Picture picture_of(const Film& film) {
  Picture picture{film.columns(), film.rows(), {}};
  for (int band = 0; band < film.bands(); ++band) {
    const std::span<const float> values = film.values(band, Film::Value::radiance);
    picture.bands.emplace_back(values.begin(), values.end());
  }
  return picture;
}

ReferencePicture::ReferencePicture(Picture values, Picture errors)
    : mean_(std::move(values)), count_(1), stated_(true) {
  for (const std::vector<float>& band : errors.bands) {
    std::vector<double>& squares = squares_.emplace_back();
    for (const float error : band) squares.push_back(static_cast<double>(error) * error);
  }
}

void ReferencePicture::add(const Picture& picture) {
  if (count_ == 0) {
    mean_ = picture;
    for (const std::vector<float>& band : picture.bands) {
      sum_.emplace_back(band.size(), 0.0);
      squares_.emplace_back(band.size(), 0.0);
    }
  }
  ++count_;
  for (std::size_t b = 0; b < sum_.size(); ++b) {
    for (std::size_t p = 0; p < sum_[b].size(); ++p) {
      const double value = picture.bands[b][p], delta = value - sum_[b][p];
      sum_[b][p] += delta / count_;
      squares_[b][p] += delta * (value - sum_[b][p]);
      mean_.bands[b][p] = static_cast<float>(sum_[b][p]);
    }
  }
}

double ReferencePicture::variance(std::size_t band, std::size_t pixel) const noexcept {
  if (stated_) return squares_[band][pixel];
  return count_ < 2 ? 0.0 : squares_[band][pixel] / (static_cast<double>(count_) * (count_ - 1));
}

Picture ReferencePicture::errors() const {
  Picture result = mean_;
  for (std::size_t b = 0; b < result.bands.size(); ++b) {
    for (std::size_t p = 0; p < result.bands[b].size(); ++p)
      result.bands[b][p] = static_cast<float>(std::sqrt(variance(b, p)));
  }
  return result;
}

double RootError::value() const noexcept { return std::sqrt(std::max(square, 0.0)); }

double RootError::error() const noexcept {
  const double high = std::sqrt(std::max(square, 0.0) + square_error),
               low = std::sqrt(std::max(square - square_error, 0.0));
  return square > 0 ? (high - low) / 2 : high;
}

PictureError picture_error(std::span<const Picture> pictures, const ReferencePicture& reference) {
  const auto count = static_cast<double>(pictures.size());
  PictureError worst;
  for (std::size_t b = 0; b < reference.values().bands.size(); ++b) {
    const std::vector<float>& values = reference.values().bands[b];
    const std::vector<double> weights = weights_of(values);
    TileMeans<3> means(reference.values().columns, reference.values().rows);
    for (std::size_t p = 0; p < values.size(); ++p) {
      double sum = 0, squares = 0;
      for (const Picture& picture : pictures) {
        const double off = static_cast<double>(picture.bands[b][p]) - values[p];
        sum += off;
        squares += off * off;
      }
      const double error2 = squares / count - reference.variance(b, p);
      const double noise2 = std::max(0.0, squares - sum * sum / count) / (count - 1);
      means.add(p, {weights[p] * error2, weights[p] * (error2 - noise2), weights[p] * noise2});
    }
    const PictureError here{b, means.mean(0), means.mean(1), means.mean(2)};
    if (b == 0 || here.error.square > worst.error.square) worst = here;
  }
  return worst;
}

RootError reference_error(const ReferencePicture& reference) {
  RootError worst;
  for (std::size_t b = 0; b < reference.values().bands.size(); ++b) {
    const std::vector<double> weights = weights_of(reference.values().bands[b]);
    TileMeans<1> means(reference.values().columns, reference.values().rows);
    for (std::size_t p = 0; p < weights.size(); ++p) means.add(p, {weights[p] * reference.variance(b, p)});
    const RootError here = means.mean(0);
    if (here.square >= worst.square) worst = here;
  }
  return worst;
}

}  // namespace obscura
