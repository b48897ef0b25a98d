// When do two methods agree? Their difference has to be within what their errors and biases explain, and
// these have to be small enough to have seen a difference that matters.
#pragma once

#include <cmath>
#include <span>

#include "octree/base/statistics.h"

namespace obscura {

/// Mean of independent measurements of equal weight; biases are averaged.
Measured mean_of(std::span<const Measured> measurements);

struct AgreementRule {
  double false_alarm = 1e-6;  ///< probability that honest errors fail, of one comparison
  double resolution = 0;      ///< relative difference that has to be seen in 99.9 % of cases; 0: any will do
};

struct Agreement {
  double difference = 0;  ///< a - b
  double error = 0;       ///< joint standard error
  double z = 0;           ///< difference / error; infinite where only the error is 0
  double limit = 0;       ///< most |z| that is allowed to what the biases leave of the difference
  double relative = 0;    ///< difference / larger of the values
  double detectable = 0;  ///< relative difference that is seen in 99.9 % of cases
  bool agree = true;
  bool sharp = true;  ///< `detectable` is within the resolution
  /// Times as many samples with which it would be; infinite: biases, or that there is no light, stand in the way.
  double samples_factor = 1;

  /// Whether it says anything: a difference, or that there is none.
  bool judged() const noexcept { return sharp || !agree; }
};

/// |a - b| <= biases + limit * error, where the limit is Student's for the joint degrees of freedom (Welch
/// and Satterthwaite). Values are taken to be exact to 1e-5: the batched walk is float inside.
Agreement agreement(const Measured& a, const Measured& b, const AgreementRule& rule);

/// A method's picture: one value, error and bias for each pixel.
struct PixelView {
  std::span<const float> value, error, bias;  ///< bias may be empty: none
};

struct PixelAgreement {
  double rms_z = 0;          ///< of what the biases leave of the differences, in units of the joint errors
  double z = 0;              ///< RMS of differences in units of the joint errors
  double inside = 1;         ///< share of pixels whose differences lie within 1.96 joint errors and the biases
  double image_error = 0;    ///< RMS of (a - b) / max(|b|, 0.05 max |b|)
  double low = 0, high = 0;  ///< bounds of z and rms_z for right errors
  std::size_t pixels = 0;    ///< that have an error
  bool agree = true;
};

/// Pixels where both errors are 0 have to be equal to 1e-4. Errors of pixels are estimates from few rays or batches,
/// and neighbours share photons: `slack` is how far from 1 that may carry an honest RMS
/// (scene/METHODS.md, "Verify").
PixelAgreement pixel_agreement(const PixelView& a, const PixelView& b, double slack = 0.3);

}  // namespace obscura
