// Planck's law: spectral, over a band, weighted with a response, and backwards to a temperature.
// Micrometres, kelvin, W/m2/sr (spectral: per um). Formulas: photon/METHODS.md, "Planck"; accuracy:
// photon/MEASURED.md.
#pragma once

#include <vector>

#include "photon/optics/spectrum.h"

namespace obscura {

/// Constants of the SI (CODATA 2018, exact).
inline constexpr double kPlanckConstant = 6.62607015e-34;         // J s
inline constexpr double kSpeedOfLight = 299792458.0;              // m/s
inline constexpr double kBoltzmannConstant = 1.380649e-23;        // J/K
inline constexpr double kStefanBoltzmann = 5.670374419184429e-8;  // W/m2/K4

/// Spectral radiance at one wavelength, W/m2/sr/um; 0 where K <= 0 or the result is below 1e-300.
double planck_spectral(double um, double K) noexcept;
/// Temperature of the blackbody with this spectral radiance; 0 where it is <= 0.
double brightness_temperature(double um, double spectral_radiance) noexcept;

/// Radiance and what interpolation and inversion need, in logarithms so that nothing underflows.
struct LogPlanck {
  double log;     ///< ln of the radiance in W/m2/sr; -infinity where there is none
  double slope;   ///< d log / d ln K
  double second;  ///< K^2 / L * d2L / dK2
};

/// Integral of response(um) B(um, K) over [um_min, um_max], exact for the piecewise-linear response:
/// relative error below 1e-10 for 0.3-100 um and 2-10,000 K, however narrow the band. Immutable;
/// evaluation is noexcept and does not allocate; costs about a quarter of a microsecond per linear
/// piece of the response (see PlanckTable for kernels).
class WeightedPlanck {
 public:
  /// @param response >= 0 in the interval
  WeightedPlanck(double um_min, double um_max, const Spectrum& response);

  /// W/m2/sr; 0 where K <= 0 or the result is below 1e-300.
  double radiance(double K) const noexcept;
  /// W/m2/sr/K
  double derivative(double K) const noexcept;
  /// Inverse of radiance(); 0 where the radiance is <= 0 or the response is zero everywhere.
  double brightness_temperature(double radiance) const noexcept;
  /// For K > 0.
  LogPlanck log_radiance(double K) const noexcept;

  /// A linear piece of the response.
  struct Piece {
    double um_min, um_max;
    double response_min, response_max;  // at um_min and at um_max
  };

 private:
  std::vector<Piece> pieces_;  // by decreasing wavelength; without those of zero response
};

}  // namespace obscura
