// A spectral band: its intervals, and what a spectral quantity or a temperature is worth in each.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "photon/optics/planck.h"
#include "photon/optics/spectrum.h"

namespace obscura {

/// One of the equal-width wavelength intervals of a band; everything optical is solved per
/// interval.
struct Interval {
  double um_min = 0, um_max = 0;
  double um_effective = 0;  ///< mean weighted with the response; the middle where that is 0
  double weight = 1;        ///< integral of the response over the interval / over the band
};

/// Grey: one interval without wavelength, all quantities are the band's values in any one unit.
/// Otherwise radiances are integrals over the response, which is not normalised: W/m2/sr.
class Band {
 public:
  /// Grey.
  explicit Band(std::string name);

  /// @param um_min, um_max edges, 0 < um_min < um_max
  /// @param samples number of intervals, >= 1
  /// @param response >= 0, not zero everywhere in the band
  /// @throws InputError
  Band(std::string name, double um_min, double um_max, int samples = 1, Spectrum response = 1);

  const std::string& name() const noexcept { return name_; }
  bool grey() const noexcept { return planck_.empty(); }
  /// 0 for grey.
  double um_min() const noexcept { return intervals_.front().um_min; }
  double um_max() const noexcept { return intervals_.back().um_max; }
  const Spectrum& response() const noexcept { return response_; }
  int interval_count() const noexcept { return static_cast<int>(intervals_.size()); }
  std::span<const Interval> intervals() const noexcept { return intervals_; }

  /// Exact response-weighted Planck radiance of one interval, W/m2/sr. Not for grey bands: there is
  /// no temperature (the reader refuses `K`); NaN.
  double planck(int interval, double kelvin) const noexcept;
  /// Of the whole band: the sum over its intervals.
  double planck(double kelvin) const noexcept;
  /// d planck / dK of the whole band, W/m2/sr/K.
  double planck_derivative(double kelvin) const noexcept;
  /// Temperature of the blackbody with this radiance in the whole band; 0 where it is <= 0.
  /// Not for grey bands: NaN.
  double brightness_temperature(double radiance) const noexcept;

  /// Response-weighted integral over the interval of a quantity per um (radiance, irradiance,
  /// power): exact but for rounding. Grey: the quantity itself.
  double integrate(int interval, const Spectrum& per_um) const;
  /// A dimensionless or optical quantity in the interval: its value at the effective wavelength.
  double optics(int interval, const Spectrum& quantity) const noexcept;

  /// The Planck integral of one interval. Not for grey bands.
  const WeightedPlanck& weighted_planck(int interval) const noexcept;

 private:
  std::string name_;
  Spectrum response_{1};
  std::vector<Interval> intervals_;
  std::vector<WeightedPlanck> planck_;  // per interval; empty for grey
  std::vector<WeightedPlanck> whole_;   // the whole band, for the inverse; empty for grey
};

}  // namespace obscura
