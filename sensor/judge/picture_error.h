// The image error of a way to make a picture, bias and noise apart, against a reference whose own error is known
// and taken off. Formulas: sensor/METHODS.md, "Error against a reference".
#pragma once

#include <span>
#include <vector>

#include "sensor/capture/film.h"

namespace obscura {

/// Radiance, row by row from the top left, per band.
struct Picture {
  int columns = 0, rows = 0;
  std::vector<std::vector<float>> bands;
};
Picture picture_of(const Film& film);

/// What others are measured against: the mean of independent pictures, whose scatter is its error; or one picture
/// that states its errors.
class ReferencePicture {
 public:
  ReferencePicture() = default;
  /// One that states its standard errors, per band and pixel.
  ReferencePicture(Picture values, Picture errors);

  /// One more independent picture. @pre of the same size, none was stated
  void add(const Picture& picture);
  int count() const noexcept { return count_; }
  /// Whether its error is known.
  bool known() const noexcept { return stated_ || count_ >= 2; }

  const Picture& values() const noexcept { return mean_; }
  /// Variance of the mean of a pixel; 0 while it is not known.
  double variance(std::size_t band, std::size_t pixel) const noexcept;
  Picture errors() const;

 private:
  Picture mean_;
  std::vector<std::vector<double>> sum_;      // means, in double
  std::vector<std::vector<double>> squares_;  // of deviations from the mean; stated: variances
  int count_ = 0;
  bool stated_ = false;
};

/// A root of a mean square that was estimated with an error: the square may come out below 0.
struct RootError {
  double square = 0;              ///< estimate; may be negative
  double square_error = 0;        ///< its standard error
  double value() const noexcept;  ///< root of the square, 0 where it is negative
  double error() const noexcept;  ///< half of how far the root of square +- error reaches
};

/// Image errors as fractions (sensor/METHODS.md, "Comparing images"), of the band where the error is largest.
struct PictureError {
  std::size_t band = 0;
  RootError error;  ///< of one picture
  RootError bias;   ///< what repetitions share
  RootError noise;  ///< what they do not; error^2 = bias^2 + noise^2
};

/// Of independent pictures made alike. Standard errors are a jackknife's over tiles of pixels.
/// @pre two pictures or more, of the reference's size, whose error is known
PictureError picture_error(std::span<const Picture> pictures, const ReferencePicture& reference);

/// The reference's own image error, by what is known of its scatter.
RootError reference_error(const ReferencePicture& reference);

}  // namespace obscura
