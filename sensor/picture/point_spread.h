// Point spread: the picture that optics make of a point, laid over an image of pixels.
#pragma once

#include <span>
#include <vector>

#include "sensor/picture/image.h"

namespace obscura {

/// Weights of a point's picture, row by row from the top left, the point in the middle. Their sum is 1.
struct PointSpread {
  /// Odd; 0 for none.
  int columns = 0;
  int rows = 0;
  std::vector<double> weights;

  bool empty() const noexcept { return weights.empty(); }
  /// Rows for columns.
  PointSpread transposed() const;
};

/// One row of a gaussian, integrated over each pixel and cut where 2e-9 of it is left out. A round one is this
/// and its transpose, one after the other.
/// @param sigma_px standard deviation, pixels, > 0
PointSpread gaussian_row(double sigma_px);

/// From the first channel of an image whose sides are odd, normalised.
/// @throws InputError where it has several channels, an even side, a value below 0 or none above
PointSpread point_spread_of(const Image& picture);

/// Each pixel's value laid out as the spread says and added up. Beyond its edge the image is continued by its
/// mirror picture: a uniform image stays as it is, and where the spread is symmetric no energy is lost.
/// Costs pixels times weights; the same bits for any number of threads.
std::vector<double> spread(std::span<const double> values, int columns, int rows, const PointSpread& by);

}  // namespace obscura
