#include "sensor/capture/film.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace obscura {
namespace {

// What does not fit a float32 is cut and counted.
float to_float(double value, std::uint64_t& anomalies) noexcept {
  constexpr double largest = std::numeric_limits<float>::max();
  if (std::isfinite(value) && std::abs(value) <= largest) return static_cast<float>(value);
  ++anomalies;
  return std::isnan(value) ? 0.0f : static_cast<float>(std::copysign(largest, value));
}

/// The same of an error: what is above 0 stays so.
float error_to_float(double value, std::uint64_t& anomalies) noexcept {
  return value > 0 ? std::max(to_float(value, anomalies), std::numeric_limits<float>::min()) : 0.0f;
}

int common_channel(int bands, int which) noexcept { return Film::kBandValues * bands + which; }
constexpr int kDepth = 0, kObject = 1, kRays = 2, kCriterion = 3, kCommonChannels = 4;

}  // namespace

void FilmTile::put(int x, int y, const PixelSum& pixel, std::uint32_t object_id, Criterion criterion) {
  assert(x >= x_begin() && x < x_end() && y >= y_begin() && y < y_end());
  const auto plane = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  const auto place = static_cast<std::size_t>((y - y_) * columns_ + (x - x_));
  const int bands = static_cast<int>(totals_.size());
  const auto set = [&](int channel, float value) {
    values_[static_cast<std::size_t>(channel) * plane + place] = value;
  };

  anomalies_ += pixel.anomalies();
  for (int b = 0; b < bands; ++b) {
    const PixelBand band = pixel.band(b);
    const double values[] = {band.radiance, std::sqrt(band.variance), band.bias,
                             std::clamp(band.transmission, 0.0, 1.0), band.transmission_atmosphere};
    for (int v = 0; v < Film::kBandValues; ++v) {
      set(Film::kBandValues * b + v, v == static_cast<int>(Film::Value::error) ? error_to_float(values[v], anomalies_)
                                                                               : to_float(values[v], anomalies_));
    }
    // Darker than float32 holds is 0, and no exact one.
    if (band.radiance != 0 && std::abs(band.radiance) < Film::kLeast) {
      set(Film::kBandValues * b, 0);
      set(Film::kBandValues * b + static_cast<int>(Film::Value::error), Film::kLeast);
    }
    Totals& totals = totals_[static_cast<std::size_t>(b)];
    totals.ray_variance += band.ray_variance;
    put_scatter(place, b, pixel, band);
    for (std::size_t k = 0; k < kBatches; ++k) totals.batch[k] += band.batch[k];
  }
  const double depth = pixel.depth_m();
  set(common_channel(bands, kDepth),
      std::isinf(depth) && depth > 0 ? std::numeric_limits<float>::infinity() : to_float(depth, anomalies_));
  set(common_channel(bands, kObject), static_cast<float>(object_id));
  set(common_channel(bands, kRays), static_cast<float>(pixel.rays()));
  set(common_channel(bands, kCriterion), static_cast<float>(criterion));
  rays_ += pixel.rays();
  ++done_;
}

void FilmTile::put_scatter(std::size_t place, int band, const PixelSum& pixel, const PixelBand& values) {
  const std::size_t plane = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  const auto set = [&](int channel, double value) {
    scatter_[static_cast<std::size_t>(channel) * plane + place] = static_cast<float>(value);
  };
  const int first = Film::kBandPlanes * band, common = Film::kBandPlanes * static_cast<int>(totals_.size());
  if (pixel.rays() == 1) {
    set(first + Film::kForeseen, pixel.foreseen(band));
    set(first + Film::kOwn, std::sqrt(values.ray_variance));
  } else {
    set(first + Film::kSmooth, std::sqrt(values.smooth.square));
    set(first + Film::kComplex, std::sqrt(values.complex.square));
    set(first + Film::kCountedTwice, std::sqrt(values.counted_twice));
  }
  set(first + Film::kMap, std::sqrt(values.map_variance));
  set(common + Film::kKnownSmooth, values.smooth.known);
  set(common + Film::kKnownComplex, values.complex.known);
  set(common + Film::kWeightSmooth, values.smooth.weight);
  set(common + Film::kWeightComplex, values.complex.weight);
}

Film::Film(const FilmSettings& settings)
    : settings_(settings),
      tile_columns_((settings.resolution[0] + kTileSide - 1) / kTileSide),
      tile_rows_((settings.resolution[1] + kTileSide - 1) / kTileSide) {
  assert(columns() >= 1 && rows() >= 1 && bands() >= 1);
  values_.resize(static_cast<std::size_t>(common_channel(bands(), kCommonChannels)) * pixel_count());
  std::ranges::fill(plane(common_channel(bands(), kDepth)), std::numeric_limits<float>::infinity());
  scatter_.resize(static_cast<std::size_t>(scatter_channels()) * pixel_count());
  tiles_.resize(static_cast<std::size_t>(tile_count()));
  totals_.resize(tiles_.size() * static_cast<std::size_t>(bands()));
}

std::span<float> Film::plane(int channel) noexcept {
  return {values_.data() + static_cast<std::size_t>(channel) * pixel_count(), pixel_count()};
}

std::span<const float> Film::plane(int channel) const noexcept {
  return {values_.data() + static_cast<std::size_t>(channel) * pixel_count(), pixel_count()};
}

std::array<int, 4> Film::tile_box(int index) const noexcept {
  const int x = index % tile_columns_ * kTileSide;
  const int y = index / tile_columns_ * kTileSide;
  return {x, y, std::min(kTileSide, columns() - x), std::min(kTileSide, rows() - y)};
}

FilmTile Film::tile(int index) const {
  assert(index >= 0 && index < tile_count());
  FilmTile tile;
  tile.index_ = index;
  const auto [x, y, tile_width, tile_height] = tile_box(index);
  tile.x_ = x;
  tile.y_ = y;
  tile.columns_ = tile_width;
  tile.rows_ = tile_height;
  tile.values_.resize(static_cast<std::size_t>(common_channel(bands(), kCommonChannels)) *
                      static_cast<std::size_t>(tile_width * tile_height));
  tile.scatter_.resize(static_cast<std::size_t>(scatter_channels() * tile_width * tile_height));
  tile.totals_.resize(static_cast<std::size_t>(bands()));
  return tile;
}

void Film::put(FilmTile&& tile) {
  const int area = tile.columns_ * tile.rows_;
  assert(tile.done_ == area);
  TileState& state = tiles_[static_cast<std::size_t>(tile.index_)];
  state = {1, area, tile.rays_, tile.anomalies_};
  std::ranges::copy(tile.totals_, totals_.begin() + static_cast<std::ptrdiff_t>(tile.index_) * bands());

  const auto copy = [&](const std::vector<float>& from, std::vector<float>& to) {
    auto source = from.cbegin();
    for (std::size_t plane = 0; plane < to.size(); plane += pixel_count()) {
      for (int y = tile.y_begin(); y < tile.y_end(); ++y, source += tile.columns_) {
        std::copy_n(source, tile.columns_,
                    to.begin() + static_cast<std::ptrdiff_t>(plane) + static_cast<std::ptrdiff_t>(y) * columns() +
                        tile.x_begin());
      }
    }
  };
  copy(tile.values_, values_);
  copy(tile.scatter_, scatter_);
}

void Film::merge(const Film& other) {
  assert(other.settings_.resolution == settings_.resolution && other.bands() == bands());
  const int object = common_channel(bands(), kObject), criterion = common_channel(bands(), kCriterion);
  for (int t = 0; t < tile_count(); ++t) {
    TileState& state = tiles_[static_cast<std::size_t>(t)];
    const TileState& theirs = other.tiles_[static_cast<std::size_t>(t)];
    if (theirs.passes == 0) continue;
    const double share = static_cast<double>(theirs.passes) / (state.passes + theirs.passes);
    const double own = 1 - share;

    const auto [x, y, tile_width, tile_height] = tile_box(t);
    for (int channel = 0; channel < common_channel(bands(), kCommonChannels); ++channel) {
      if ((channel == object || channel == criterion) && state.passes > 0) continue;
      const std::span<float> to = plane(channel);
      const std::span<const float> from = other.plane(channel);
      const bool error = channel < object - kObject && channel % kBandValues == static_cast<int>(Value::error);
      for (int row = y; row < y + tile_height; ++row) {
        for (int column = x; column < x + tile_width; ++column) {
          const auto place =
              static_cast<std::size_t>(row) * static_cast<std::size_t>(columns()) + static_cast<std::size_t>(column);
          const double a = to[place], b = from[place];
          if (channel == object || channel == criterion) {
            to[place] = from[place];
          } else if (channel == common_channel(bands(), kDepth)) {
            to[place] = std::min(to[place], from[place]);
          } else if (channel == common_channel(bands(), kRays)) {
            to[place] += from[place];
          } else {
            to[place] = static_cast<float>(error ? std::hypot(own * a, share * b) : own * a + share * b);
          }
        }
      }
    }
    for (int b = 0; b < bands(); ++b) {
      const auto place = static_cast<std::size_t>(t * bands() + b);
      FilmTile::Totals& to = totals_[place];
      const FilmTile::Totals& from = other.totals_[place];
      to.ray_variance = own * own * to.ray_variance + share * share * from.ray_variance;
      for (std::size_t k = 0; k < kBatches; ++k) {
        to.batch[k] = own * to.batch[k] + share * from.batch[k];
      }
    }
    state.passes += theirs.passes;
    state.pixels = theirs.pixels;
    state.rays += theirs.rays;
    state.anomalies += theirs.anomalies;
  }
}

int Film::passes(int x, int y) const noexcept {
  return tiles_[static_cast<std::size_t>(y / kTileSide * tile_columns_ + x / kTileSide)].passes;
}

std::uint64_t Film::pixels_done() const noexcept {
  std::uint64_t sum = 0;
  for (const TileState& tile : tiles_) sum += static_cast<std::uint64_t>(tile.pixels);
  return sum;
}

bool Film::partial() const noexcept { return pixels_done() < pixel_count(); }

std::uint64_t Film::rays() const noexcept {
  std::uint64_t sum = 0;
  for (const TileState& tile : tiles_) sum += tile.rays;
  return sum;
}

std::uint64_t Film::anomalies() const noexcept {
  std::uint64_t sum = 0;
  for (const TileState& tile : tiles_) sum += tile.anomalies;
  return sum;
}

std::uint64_t Film::too_dark(int band) const noexcept {
  const std::span<const float> radiance = values(band, Value::radiance), error = values(band, Value::error);
  std::uint64_t count = 0;
  for (std::size_t p = 0; p < radiance.size(); ++p) count += radiance[p] == 0 && error[p] == kLeast;
  return count;
}

std::span<const float> Film::values(int band, Value value) const noexcept {
  return plane(kBandValues * band + static_cast<int>(value));
}
std::span<const float> Film::depth_m() const noexcept { return plane(common_channel(bands(), kDepth)); }
std::span<const float> Film::object_id() const noexcept { return plane(common_channel(bands(), kObject)); }
std::span<const float> Film::ray_count() const noexcept { return plane(common_channel(bands(), kRays)); }
std::span<const float> Film::criterion() const noexcept { return plane(common_channel(bands(), kCriterion)); }

ImageMean Film::mean(int band) const { return mean_over(0, tile_count(), band); }

ImageMean Film::mean_of_tile(int tile, int band) const { return mean_over(tile, tile + 1, band); }

ImageMean Film::mean_over(int first_tile, int tile_end, int band) const {
  ImageMean result;
  double pixels = 0, ray_variance = 0;
  for (int t = first_tile; t < tile_end; ++t) {
    pixels += tiles_[static_cast<std::size_t>(t)].pixels;
    const FilmTile::Totals& totals = totals_[static_cast<std::size_t>(t * bands() + band)];
    ray_variance += totals.ray_variance;
    for (std::size_t k = 0; k < kBatches; ++k) result.batch[k] += totals.batch[k];
  }
  if (pixels == 0) return {};
  for (double& value : result.batch) value /= pixels;
  result.mean = mean_of(result.batch);
  result.standard_error = std::sqrt(variance_of_mean(result.batch, result.mean) + ray_variance / (pixels * pixels));
  return result;
}

}  // namespace obscura
