#include "photon/optics/spectrum.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "octree/base/error.h"

namespace obscura {
namespace {

// Extreme value over an interval: linear pieces have theirs at a node or at an end.
template <class Better>
double extreme(const Spectrum& s, double um_min, double um_max, Better better) noexcept {
  double best = s.value(um_min);
  if (const double end = s.value(um_max); better(end, best)) best = end;
  const std::vector<double>& um = s.nodes_um();
  for (std::size_t i = 0; i < um.size(); ++i) {
    if (um[i] > um_min && um[i] < um_max && better(s.values()[i], best)) best = s.values()[i];
  }
  return best;
}

}  // namespace

Spectrum Spectrum::table(std::vector<double> um, std::vector<double> value) {
  if (um.empty()) throw InputError("spectrum", "the table has no rows", "give at least one");
  if (um.size() != value.size()) {
    throw InputError("spectrum",
                     std::to_string(um.size()) + " wavelengths but " + std::to_string(value.size()) + " values",
                     "give one value per wavelength");
  }
  for (std::size_t i = 0; i < um.size(); ++i) {
    const std::string row = "row " + std::to_string(i + 1);
    if (!(um[i] > 0) || !std::isfinite(um[i])) {
      throw InputError("spectrum", row + ": the wavelength is not a positive number", "wavelengths are in micrometres");
    }
    if (i > 0 && um[i] <= um[i - 1]) {
      throw InputError("spectrum", row + ": the wavelength does not increase",
                       "sort the rows by wavelength and give each one once");
    }
    if (!std::isfinite(value[i])) {
      throw InputError("spectrum", row + ": the value is not a finite number");
    }
  }
  Spectrum result;
  result.um_ = std::move(um);
  result.value_ = std::move(value);
  return result;
}

double Spectrum::value(double um) const noexcept {
  if (um_.size() < 2 || !(um > um_.front())) return value_.front();
  if (um >= um_.back()) return value_.back();
  const auto above = std::upper_bound(um_.begin(), um_.end(), um);
  const std::size_t i = static_cast<std::size_t>(above - um_.begin());
  const double share = (um - um_[i - 1]) / (um_[i] - um_[i - 1]);
  return value_[i - 1] + share * (value_[i] - value_[i - 1]);
}

bool Spectrum::is_constant() const noexcept {
  return std::all_of(value_.begin(), value_.end(), [&](double v) { return v == value_.front(); });
}

double Spectrum::min(double um_min, double um_max) const noexcept {
  return extreme(*this, um_min, um_max, [](double a, double b) { return a < b; });
}
double Spectrum::max(double um_min, double um_max) const noexcept {
  return extreme(*this, um_min, um_max, [](double a, double b) { return a > b; });
}
double Spectrum::min() const noexcept { return *std::min_element(value_.begin(), value_.end()); }
double Spectrum::max() const noexcept { return *std::max_element(value_.begin(), value_.end()); }

std::vector<double> linear_pieces(const Spectrum& a, const Spectrum& b, double um_min, double um_max) {
  std::vector<double> cuts{um_min};
  for (const Spectrum* s : {&a, &b}) {
    for (const double um : s->nodes_um()) {
      if (um > um_min && um < um_max) cuts.push_back(um);
    }
  }
  cuts.push_back(um_max);
  std::sort(cuts.begin(), cuts.end());
  cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
  return cuts;
}

double integral(const Spectrum& a, double um_min, double um_max) {
  return integral_of_product(a, Spectrum(1), um_min, um_max);
}

double integral_of_product(const Spectrum& a, const Spectrum& b, double um_min, double um_max) {
  const std::vector<double> cuts = linear_pieces(a, b, um_min, um_max);
  double sum = 0;
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    // Simpson's rule is exact for the quadratic that the product is.
    const double lower = cuts[i - 1];
    const double upper = cuts[i];
    const double a0 = a.value(lower), a1 = a.value(upper);
    const double b0 = b.value(lower), b1 = b.value(upper);
    sum += (upper - lower) / 6 * (a0 * b0 + (a0 + a1) * (b0 + b1) + a1 * b1);
  }
  return sum;
}

double first_moment(const Spectrum& a, double um_min, double um_max) {
  const std::vector<double> cuts = linear_pieces(a, Spectrum(1), um_min, um_max);
  double sum = 0;
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    const double lower = cuts[i - 1];
    const double upper = cuts[i];
    const double a0 = a.value(lower), a1 = a.value(upper);
    sum += (upper - lower) / 6 * (a0 * lower + (a0 + a1) * (lower + upper) + a1 * upper);
  }
  return sum;
}

}  // namespace obscura
