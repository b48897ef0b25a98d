// What a film knows of its own image error: RMS over pixels of (L - L_true) / max(|L_true|, 0.05 max |L_true|),
// from the pixels' standard errors. Formulas: sensor/METHODS.md, "What a film knows of its image error".
#pragma once

#include <cstdint>
#include <vector>

#include "sensor/capture/film.h"

namespace obscura {

/// Of one band.
struct FilmError {
  double square = 0;  ///< expected square of the image error, biases apart
  /// Degrees of freedom of `square`: as many independent equal squares would be as uncertain. Pixels that share photons
  /// count less, and so do many small errors beside a few large ones. 0: no pixel has an error.
  double freedom = 0;
  /// Mean of the estimated bias, in units of the image error, of each block of kBlock x kBlock pixels that are done.
  std::vector<double> bias;

  static constexpr int kBlock = 4;
};

/// @param band of the film; only pixels that are done count
FilmError film_error(const Film& film, int band);

/// Mean over blocks of the squared bias, from independent estimates of it: products of different ones have no noise in
/// their mean. May be negative, by noise. @pre two or more estimates, equally many blocks in each
struct BiasSquare {
  double mean = 0;
  double standard_error = 0;
};
BiasSquare bias_square(const std::vector<std::vector<double>>& estimates);

}  // namespace obscura
