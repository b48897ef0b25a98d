// A quantity that depends on wavelength: one number, or a table that is linear in between and
// constant outside. What the quantity is (albedo, W/m2/sr/um ...) is its owner's business.
#pragma once

#include <vector>

namespace obscura {

class Spectrum {
 public:
  /// The same value at all wavelengths.
  Spectrum(double value = 0) : value_{value} {}
  static Spectrum constant(double value) { return Spectrum(value); }

  /// @param um wavelengths in micrometres, finite, > 0, strictly increasing, at least one
  /// @param value as many, finite
  /// @throws InputError where they are not
  static Spectrum table(std::vector<double> um, std::vector<double> value);

  /// Linear between the nodes of a table, constant outside. noexcept, no allocation.
  double value(double um) const noexcept;
  double operator()(double um) const noexcept { return value(um); }

  /// The same at all wavelengths: a number, or a table whose values are all equal.
  bool is_constant() const noexcept;

  /// Least and greatest value over [um_min, um_max], attained.
  double min(double um_min, double um_max) const noexcept;
  double max(double um_min, double um_max) const noexcept;
  /// Over all wavelengths.
  double min() const noexcept;
  double max() const noexcept;

  /// Nodes of the table; empty for a number.
  const std::vector<double>& nodes_um() const noexcept { return um_; }
  /// Values at the nodes; one value for a number.
  const std::vector<double>& values() const noexcept { return value_; }

  /// Equal at every node (not: equal as functions).
  friend bool operator==(const Spectrum&, const Spectrum&) = default;

 private:
  std::vector<double> um_;
  std::vector<double> value_;
};

/// Wavelengths (um) that cut [um_min, um_max] into pieces on which both spectra are linear,
/// both ends included, increasing.
std::vector<double> linear_pieces(const Spectrum& a, const Spectrum& b, double um_min, double um_max);

/// Integral over [um_min, um_max] of a(um) d um, and of a(um) b(um) d um: exact but for rounding.
double integral(const Spectrum& a, double um_min, double um_max);
double integral_of_product(const Spectrum& a, const Spectrum& b, double um_min, double um_max);
/// Integral of um * a(um) d um.
double first_moment(const Spectrum& a, double um_min, double um_max);

}  // namespace obscura
