#include "sensor/picture/point_spread.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cassert>
#include <cmath>
#include <numeric>

namespace obscura {
namespace {

void normalise(std::vector<double>& weights) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (double& weight : weights) weight /= sum;
}

// Index of the pixel that is seen at i in the endless row of mirror pictures: ... 1 0 | 0 1 ... n-1 | n-1 n-2 ...
std::size_t mirrored(int i, int n) noexcept {
  const int period = 2 * n;
  const int within = ((i % period) + period) % period;
  return static_cast<std::size_t>(within < n ? within : period - 1 - within);
}

}  // namespace

PointSpread PointSpread::transposed() const {
  PointSpread result{rows, columns, std::vector<double>(weights.size())};
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      result.weights[static_cast<std::size_t>(x * rows + y)] = weights[static_cast<std::size_t>(y * columns + x)];
    }
  }
  return result;
}

PointSpread gaussian_row(double sigma_px) {
  assert(sigma_px > 0);
  const int reach = static_cast<int>(std::ceil(6 * sigma_px));
  const double scale = 1 / (std::sqrt(2.0) * sigma_px);
  PointSpread row{2 * reach + 1, 1, {}};
  for (int i = -reach; i <= reach; ++i) {
    // By the complement, so that the tails keep their digits.
    const double near = std::abs(i) - 0.5, far = std::abs(i) + 0.5;
    row.weights.push_back(0.5 * (std::erfc(near * scale) - std::erfc(far * scale)));
  }
  normalise(row.weights);
  return row;
}

PointSpread point_spread_of(const Image& picture) {
  const auto refuse = [](std::string problem, const char* hint) {
    throw InputError("point spread", std::move(problem), hint);
  };
  if (picture.channels().size() != 1) {
    refuse(fmt::format("it has {} channels", picture.channels().size()), "give an image of one channel");
  }
  if (picture.columns() % 2 == 0 || picture.rows() % 2 == 0) {
    refuse(fmt::format("it has {} x {} pixels and so no pixel in the middle", picture.columns(), picture.rows()),
           "give an image with odd sides, the point in the middle");
  }
  PointSpread result{picture.columns(), picture.rows(), {}};
  double sum = 0;
  for (const float value : picture.channel(picture.channels().front())) {
    if (!(value >= 0) || !std::isfinite(value)) {
      refuse(fmt::format("it holds the value {:g}", value), "give values of at least 0");
    }
    sum += result.weights.emplace_back(value);
  }
  if (!(sum > 0)) refuse("it is black", "give an image with a value above 0");
  normalise(result.weights);
  return result;
}

std::vector<double> spread(std::span<const double> values, int columns, int rows, const PointSpread& by) {
  assert(values.size() == static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  const auto width = static_cast<std::size_t>(columns);
  const int right = by.columns / 2, down = by.rows / 2;
  std::vector<double> result(values.size());
  tbb::parallel_for(tbb::blocked_range<int>(0, rows), [&](const tbb::blocked_range<int>& range) {
    // A row of the image with its mirror pictures at both ends.
    std::vector<double> row(width + static_cast<std::size_t>(2 * right));
    for (int y = range.begin(); y != range.end(); ++y) {
      double* const out = &result[static_cast<std::size_t>(y) * width];
      for (int j = 0; j < by.rows; ++j) {
        const double* const in = &values[mirrored(y - (j - down), rows) * width];
        for (std::size_t x = 0; x < row.size(); ++x) row[x] = in[mirrored(static_cast<int>(x) - right, columns)];
        for (int i = 0; i < by.columns; ++i) {
          const double weight = by.weights[static_cast<std::size_t>(j * by.columns + i)];
          const double* const from = &row[static_cast<std::size_t>(by.columns - 1 - i)];
          for (std::size_t x = 0; x < width; ++x) out[x] += weight * from[x];
        }
      }
    }
  });
  return result;
}

}  // namespace obscura
