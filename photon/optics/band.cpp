#include "photon/optics/band.h"

#include <cassert>
#include <cmath>
#include <limits>

#include "octree/base/error.h"

namespace obscura {
namespace {
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
}

Band::Band(std::string name) : name_(std::move(name)), intervals_(1) {}

Band::Band(std::string name, double um_min, double um_max, int samples, Spectrum response)
    : name_(std::move(name)), response_(std::move(response)) {
  const std::string where = "band \"" + name_ + "\"";
  if (!(um_min > 0) || !(um_max > um_min) || !std::isfinite(um_max)) {
    throw InputError(where, "the edges are not two increasing positive wavelengths",
                     "give [shortest, longest] in micrometres");
  }
  if (samples < 1) throw InputError(where, "has no intervals", "give samples >= 1");
  if (response_.min(um_min, um_max) < 0) throw InputError(where, "the response is negative");
  const double whole = integral(response_, um_min, um_max);
  if (!(whole > 0)) {
    throw InputError(where, "the response is zero in the whole band", "give response wavelengths inside the band");
  }

  double edge = um_min;
  for (int j = 0; j < samples; ++j) {
    const double next = j + 1 == samples ? um_max : um_min + (um_max - um_min) * (j + 1) / samples;
    const double part = integral(response_, edge, next);
    double effective = 0.5 * (edge + next);
    if (part > 0) {
      // Rounding must not carry it out of the interval.
      effective = std::fmin(std::fmax(first_moment(response_, edge, next) / part, edge), next);
    }
    intervals_.push_back({edge, next, effective, part / whole});
    planck_.emplace_back(edge, next, response_);
    edge = next;
  }
  whole_.emplace_back(um_min, um_max, response_);
}

double Band::planck(int interval, double kelvin) const noexcept {
  assert(!grey());
  return grey() ? kNone : planck_[interval].radiance(kelvin);
}

double Band::planck(double kelvin) const noexcept {
  assert(!grey());
  if (grey()) return kNone;
  double sum = 0;
  for (const WeightedPlanck& part : planck_) sum += part.radiance(kelvin);
  return sum;
}

double Band::planck_derivative(double kelvin) const noexcept {
  assert(!grey());
  return grey() ? kNone : whole_.front().derivative(kelvin);
}

double Band::brightness_temperature(double radiance) const noexcept {
  assert(!grey());
  return grey() ? kNone : whole_.front().brightness_temperature(radiance);
}

double Band::integrate(int interval, const Spectrum& per_um) const {
  if (grey()) return per_um.values().front();
  const Interval& range = intervals_[interval];
  return integral_of_product(per_um, response_, range.um_min, range.um_max);
}

double Band::optics(int interval, const Spectrum& quantity) const noexcept {
  if (grey()) return quantity.values().front();
  return quantity.value(intervals_[interval].um_effective);
}

const WeightedPlanck& Band::weighted_planck(int interval) const noexcept {
  assert(!grey());
  return planck_[interval];
}

}  // namespace obscura
