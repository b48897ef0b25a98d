// Radiative transfer along a segment of constant extinction: what passes, what is gained. Each
// function keeps its relative accuracy from optical depth 0 to infinity (tests: 1e-13).
#pragma once

#include <cmath>

namespace obscura {

/// 1 - e^-tau: the share of the light that is lost on the optical depth tau >= 0.
inline double one_minus_exp(double tau) noexcept { return -std::expm1(-tau); }

/// Transmission over a distance, which may be infinite, through something of the same extinction everywhere; 1 where
/// that is 0.
inline double transmission_over(double extinction, double distance) noexcept {
  return extinction > 0 ? std::exp(-extinction * distance) : 1.0;
}

/// (1 - e^-tau) / tau: transmission averaged over the way; 1 at tau = 0, 0 at infinity.
inline double mean_transmission(double tau) noexcept { return tau > 0 ? -std::expm1(-tau) / tau : 1.0; }

/// Integral of e^(-k s) over s from 0 to `length`, metres: what a source of 1 W/m3/sr at constant
/// extinction k (1/m, >= 0) adds to the radiance at the near end, the solution of dL/ds = -k L + 1
/// (Chandrasekhar, Radiative Transfer, 1960, I.7). Right for k = 0 (the length itself) and for an
/// infinite length (1 / k).
inline double effective_length(double extinction, double length) noexcept {
  const double tau = extinction * length;
  if (tau < 1) return length * mean_transmission(tau);
  return extinction > 0 ? -std::expm1(-tau) / extinction : length;
}

/// Weights of a source function that is linear in optical depth: the gain of the segment is
/// near * S(near end) + far * S(far end), and near + far = 1 - e^-tau.
struct LinearSourceWeights {
  double near;  ///< (tau - 1 + e^-tau) / tau
  double far;   ///< (1 - e^-tau - tau e^-tau) / tau
};

/// The closed forms cancel below tau = 1: there, the Taylor series of the integrals of
/// tau (1 - x) e^(-tau x) and tau x e^(-tau x) over x from 0 to 1.
inline LinearSourceWeights linear_source_weights(double tau) noexcept {
  if (tau < 1) {
    // near / tau = sum (-tau)^n / (n+2)!, far / tau = sum (-tau)^n / (n! (n+2)), by Horner.
    double near = 1;
    double far = 1.0 / 20;
    for (int n = 18; n > 0; --n) {
      near = 1 - near * tau / (n + 2);
      far = 1.0 / (n + 1) - far * tau / n;
    }
    return {0.5 * tau * near, tau * far};
  }
  const double mean = mean_transmission(tau);
  return {1 - mean, mean - std::exp(-tau)};
}

}  // namespace obscura
