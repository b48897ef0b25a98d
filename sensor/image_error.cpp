#include "sensor/image_error.h"

#include <algorithm>
#include <cmath>

#include "octree/base/statistics.h"

namespace obscura {
namespace {

/// Dark pixels count against this share of the brightest, as the image error has it.
constexpr double kFloor = 0.05;
/// Pixels with larger relative errors take their neighbours' mean for their radiance: their own would be divided by noise.
constexpr double kKnown = 0.1;

/// What differences of each pixel are divided by; 0 where it is not done.
std::vector<double> scales(const Film& film, int band) {
  const std::span<const float> radiance = film.values(band, Film::Value::radiance);
  const std::span<const float> error = film.values(band, Film::Value::error);
  const int columns = film.columns(), rows = film.rows();
  const auto place = [columns](int x, int y) { return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x); };
  // The brightest of many noisy pixels is brighter than the brightest.
  double brightest = 0, fallback = 0;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      if (film.passes(x, y) == 0) continue;
      const double value = std::abs(radiance[place(x, y)]);
      brightest = std::max(brightest, value - 2.0 * error[place(x, y)]);
      fallback = std::max(fallback, value);
    }
  }
  if (!(brightest > 0)) brightest = fallback;
  std::vector<double> result(radiance.size());
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      if (film.passes(x, y) == 0) continue;
      double value = std::abs(radiance[place(x, y)]);
      if (error[place(x, y)] > kKnown * value) {
        double sum = 0;
        int count = 0;
        for (int v = std::max(0, y - 1); v <= std::min(rows - 1, y + 1); ++v) {
          for (int u = std::max(0, x - 1); u <= std::min(columns - 1, x + 1); ++u) {
            if (film.passes(u, v) == 0) continue;
            sum += std::abs(radiance[place(u, v)]);
            ++count;
          }
        }
        value = sum / count;
      }
      result[place(x, y)] = std::max(value, kFloor * brightest);
    }
  }
  return result;
}

}  // namespace

FilmError film_error(const Film& film, int band) {
  const std::vector<double> scale = scales(film, band);
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
        if (!(error[p] > 0)) continue;
        const double square = static_cast<double>(error[p]) * error[p];
        const double relative = square / (scale[p] * scale[p]);
        own += relative;
        own_squares += relative * relative;
        variance += square;
      }
    }
    const int count = width * height;
    pixels += static_cast<std::uint64_t>(count);
    sum += own;
    // Pixels that err together: by how much the tile's mean errs more than independent ones would let it.
    const double of_mean = film.mean_of_tile(t, band).standard_error;
    const double together = variance > 0 ? std::clamp(of_mean * of_mean * count * count / variance, 1.0, static_cast<double>(count)) : 1.0;
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
  if (pixels > 0) result.square = sum / static_cast<double>(pixels);
  if (squares > 0) result.freedom = sum * sum / squares;
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
