// What a film knows of its own image error: RMS over pixels of (L - L_true) / max(|L_true|, 0.05 max |L_true|),
// from the pixels' standard errors; or its half-widths of apparent temperature. Formulas: sensor/METHODS.md, "What a
// film knows of its image error".
#pragma once

#include <cstdint>
#include <vector>

#include "photon/optics/band.h"
#include "sensor/capture/film.h"

namespace obscura {

/// What errors of an image are told in.
enum class ErrorUnit {
  /// The image error, a fraction.
  fraction,
  /// The half-width of the 95 % interval of apparent temperature that 95 % of the pixels stay below.
  kelvin
};

/// An image error that is asked for.
struct ErrorTarget {
  double value = 0;
  ErrorUnit unit = ErrorUnit::fraction;

  bool operator==(const ErrorTarget&) const = default;
};

/// Shortest wavelength of bands in which ordinary things glow, um: the apparent temperature of others is for nobody.
inline constexpr double kThermal_um = 2.5;

/// Of one band.
struct FilmError {
  double square = 0;  ///< expected square of the image's error, biases apart
  /// Degrees of freedom of `square`: as many independent equal squares would be as uncertain. Pixels that share photons
  /// count less, and so do many small errors beside a few large ones. 0: no pixel has an error.
  double freedom = 0;
  /// Error, in its unit, where pixels are wrong by their whole radiance: what factors become by which all may be wrong.
  double whole = 1;
  /// Mean of the estimated bias, in units of the error, of each block of kBlock x kBlock pixels that are done.
  std::vector<double> bias;

  static constexpr int kBlock = 4;
};

/// @param band of the film; only pixels that are done count
FilmError film_error(const Film& film, int band);
/// The same as half-widths of apparent temperature, K. @param spectral the film's band, not grey
FilmError film_error_K(const Film& film, int band, const Band& spectral);

/// Mean over blocks of the squared bias, from independent estimates of it: products of different ones have no noise in
/// their mean. May be negative, by noise. @pre two or more estimates, equally many blocks in each
struct BiasSquare {
  double mean = 0;
  double standard_error = 0;
};
BiasSquare bias_square(const std::vector<std::vector<double>>& estimates);

}  // namespace obscura
