#include "sensor/judge/image_error.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "octree/base/error_scale.h"
#include "octree/base/statistics.h"

namespace obscura {
namespace {

/// A pixel's radiance is averaged over more and more neighbours until its relative error is below this.
constexpr double kKnown = 0.1;

/// Sums of radiance and squared error over rectangles of a tile's pixels.
class TileSums {
 public:
  TileSums(const Film& film, int band, const std::array<int, 4>& box)
      : width_(box[2]), height_(box[3]), sums_(static_cast<std::size_t>((width_ + 1) * (height_ + 1))) {
    const std::span<const float> radiance = film.values(band, Film::Value::radiance);
    const std::span<const float> error = film.values(band, Film::Value::error);
    for (int y = 0; y < height_; ++y) {
      Sums row;
      for (int x = 0; x < width_; ++x) {
        const std::size_t p = static_cast<std::size_t>(box[1] + y) * static_cast<std::size_t>(film.columns()) +
                              static_cast<std::size_t>(box[0] + x);
        row.radiance += std::abs(radiance[p]);
        row.variance += static_cast<double>(error[p]) * error[p];
        Sums& here = sums_[place(x + 1, y + 1)];
        here.radiance = sums_[place(x + 1, y)].radiance + row.radiance;
        here.variance = sums_[place(x + 1, y)].variance + row.variance;
      }
    }
  }

  struct Mean {
    double radiance, error;
  };
  /// Over the pixels no farther than `reach` from one, in the tile.
  Mean mean(int x, int y, int reach) const noexcept {
    const int x0 = std::max(0, x - reach), x1 = std::min(width_, x + reach + 1), y0 = std::max(0, y - reach),
              y1 = std::min(height_, y + reach + 1);
    const auto over = [&](double Sums::*of) {
      return sums_[place(x1, y1)].*of - sums_[place(x0, y1)].*of - sums_[place(x1, y0)].*of + sums_[place(x0, y0)].*of;
    };
    const double count = (x1 - x0) * (y1 - y0);
    return {over(&Sums::radiance) / count, std::sqrt(std::max(0.0, over(&Sums::variance))) / count};
  }

 private:
  struct Sums {
    double radiance = 0, variance = 0;
  };
  std::size_t place(int x, int y) const noexcept { return static_cast<std::size_t>(y * (width_ + 1) + x); }

  int width_, height_;
  std::vector<Sums> sums_;
};

/// Radiance of each pixel without its noise, as neighbours know it; 0 where pixels are not done.
struct Levels {
  std::vector<double> radiance;
  double brightest = 0;
};
Levels levels(const Film& film, int band) {
  std::vector<double> result(film.values(band, Film::Value::radiance).size());
  double brightest = 0, fallback = 0;
  for (int t = 0; t < film.tile_count(); ++t) {
    const std::array<int, 4> box = film.tile_box(t);
    if (film.passes(box[0], box[1]) == 0) continue;
    const TileSums sums(film, band, box);
    for (int y = 0; y < box[3]; ++y) {
      for (int x = 0; x < box[2]; ++x) {
        TileSums::Mean mean = sums.mean(x, y, 0);
        for (int reach = 1; mean.error > kKnown * mean.radiance && reach < Film::kTileSide; reach *= 2)
          mean = sums.mean(x, y, reach);
        // The largest of many noisy values exceeds the true maximum: two standard errors come off.
        brightest = std::max(brightest, mean.radiance - 2 * mean.error);
        fallback = std::max(fallback, mean.radiance);
        result[static_cast<std::size_t>(box[1] + y) * static_cast<std::size_t>(film.columns()) +
               static_cast<std::size_t>(box[0] + x)] = mean.radiance;
      }
    }
  }
  return {std::move(result), brightest > 0 ? brightest : fallback};
}

/// Share of the pixels that a kelvin error holds for.
constexpr double kMostPixels = 0.95;
/// Half-width of a 95 % interval over its standard error.
constexpr double kHalfWidth = 1.96;

/// The value that a share of them stays below; 0 of none.
double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

/// Errors and biases of pixels in units of their scales.
/// @param scale of each pixel; 0: its error does not count
/// @param share of the pixels whose errors the result's stays above; none: it is their root mean square
FilmError error_over(const Film& film, int band, const std::vector<double>& scale, std::optional<double> share) {
  std::vector<double> relatives;
  const std::span<const float> error = film.values(band, Film::Value::error);
  const std::span<const float> bias = film.values(band, Film::Value::bias);
  const auto columns = static_cast<std::size_t>(film.columns());
  FilmError result;
  double sum = 0, squares = 0;
  std::uint64_t pixels = 0;
  for (int t = 0; t < film.tile_count(); ++t) {
    const auto [x0, y0, width, height] = film.tile_box(t);
    if (film.passes(x0, y0) == 0) continue;
    double own = 0, own_squares = 0, variance = 0;
    for (int y = y0; y < y0 + height; ++y) {
      for (int x = x0; x < x0 + width; ++x) {
        const std::size_t p = static_cast<std::size_t>(y) * columns + static_cast<std::size_t>(x);
        if (share && film.ray_count()[p] > 0) relatives.push_back(0);
        if (!(error[p] > 0) || !(scale[p] > 0)) continue;
        const double square = static_cast<double>(error[p]) * error[p];
        const double relative = square / (scale[p] * scale[p]);
        if (share) relatives.back() = relative;
        own += relative;
        own_squares += relative * relative;
        variance += square;
      }
    }
    const int count = width * height;
    pixels += static_cast<std::uint64_t>(count);
    sum += own;
    // How many pixels err together: the square of the mean's error over what it would be for independent pixels.
    const double of_mean = film.mean_of_tile(t, band).standard_error;
    const double together =
        variance > 0 ? std::clamp(of_mean * of_mean * count * count / variance, 1.0, static_cast<double>(count)) : 1.0;
    squares += together * own_squares;

    for (int y = y0; y < y0 + height; y += FilmError::kBlock) {
      for (int x = x0; x < x0 + width; x += FilmError::kBlock) {
        Moments block;
        for (int v = y; v < std::min(y + FilmError::kBlock, y0 + height); ++v) {
          for (int u = x; u < std::min(x + FilmError::kBlock, x0 + width); ++u) {
            const std::size_t p = static_cast<std::size_t>(v) * columns + static_cast<std::size_t>(u);
            block.add(scale[p] > 0 ? bias[p] / scale[p] : 0.0);
          }
        }
        result.bias.push_back(block.mean());
      }
    }
  }
  if (pixels > 0) result.square = share ? quantile(std::move(relatives), *share) : sum / static_cast<double>(pixels);
  if (squares > 0) result.freedom = sum * sum / squares;
  return result;
}

}  // namespace

FilmError film_error(const Film& film, int band) {
  Levels scale = levels(film, band);
  for (double& value : scale.radiance) value = error_scale(value, scale.brightest);
  return error_over(film, band, scale.radiance, std::nullopt);
}

FilmError film_error_K(const Film& film, int band, const Band& spectral) {
  // A kelvin is worth the derivative of the band's radiance where the pixel's level is its own error at least: what is
  // all noise has no temperature to speak of.
  std::vector<double> scale = levels(film, band).radiance, whole;
  const std::span<const float> error = film.values(band, Film::Value::error);
  for (std::size_t p = 0; p < scale.size(); ++p) {
    const double radiance = std::max(scale[p], static_cast<double>(error[p]));
    if (!(radiance > 0)) continue;
    const double per_kelvin = spectral.planck_derivative(spectral.brightness_temperature(radiance));
    scale[p] = per_kelvin / kHalfWidth;
    if (per_kelvin > 0) whole.push_back(radiance / per_kelvin);
  }
  FilmError result = error_over(film, band, scale, kMostPixels);
  result.whole = quantile(std::move(whole), kMostPixels);
  return result;
}

BiasSquare bias_square(const std::vector<std::vector<double>>& estimates) {
  const auto n = static_cast<double>(estimates.size());
  Moments products;
  for (std::size_t block = 0; block < estimates.front().size(); ++block) {
    double sum = 0, squares = 0;
    for (const std::vector<double>& estimate : estimates) {
      sum += estimate[block];
      squares += estimate[block] * estimate[block];
    }
    products.add((sum * sum - squares) / (n * (n - 1)));
  }
  return {products.mean(), products.count() > 1 ? products.standard_error() : 0.0};
}

}  // namespace obscura
