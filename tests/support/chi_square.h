// Does a sampler follow its density? Pearson's chi-square test over bins.
#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <ostream>
#include <vector>

#include "octree/base/math.h"
#include "tests/support/distributions.h"

namespace obscura::test {

struct ChiSquare {
  double statistic = 0;
  double degrees_of_freedom = 0;
  double p_value = 1;
  double limit = 1e-6;  ///< false-alarm rate
  explicit operator bool() const { return p_value >= limit; }
};

inline std::ostream& operator<<(std::ostream& out, const ChiSquare& c) {
  return out << "chi-square " << c.statistic << " with " << c.degrees_of_freedom
             << " degrees of freedom: p = " << c.p_value << " (limit " << c.limit << ")";
}

/// @param observed how many samples fell into each bin
/// @param expected how many should have; both must count the same samples. Bins that expect fewer
///   than 5 are pooled. A sample where nothing is expected fails the test.
/// @param comparisons how many such tests share the false-alarm rate of 1e-6
inline ChiSquare chi_square(const std::vector<double>& observed, const std::vector<double>& expected,
                            double comparisons = 1) {
  ChiSquare result;
  result.limit = 1e-6 / comparisons;
  double pooled_observed = 0, pooled_expected = 0;
  int bins = 0;
  const auto add = [&](double o, double e) {
    result.statistic += (o - e) * (o - e) / e;
    ++bins;
  };
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (expected[i] >= 5) {
      add(observed[i], expected[i]);
    } else {
      pooled_observed += observed[i];
      pooled_expected += expected[i];
      if (pooled_expected >= 5) {
        add(pooled_observed, pooled_expected);
        pooled_observed = pooled_expected = 0;
      }
    }
  }
  // What is left over is too little for the law; much more than expected is wrong all the same.
  if (pooled_expected > 0 || pooled_observed > 0) add(pooled_observed, std::max(pooled_expected, 1e-3));
  result.degrees_of_freedom = std::max(bins - 1, 1);
  result.p_value = chi_square_tail(result.statistic, result.degrees_of_freedom);
  return result;
}

/// Samples of one number against the integral of its density over each bin.
/// @param draw () -> double
/// @param edges increasing; samples outside fall into bins of their own, where none is expected
/// @param probability (low, high) -> double
template <class Draw, class Probability>
ChiSquare chi_square_numbers(Draw&& draw, const std::vector<double>& edges, Probability&& probability, int samples,
                             double comparisons = 1) {
  std::vector<double> observed(edges.size() + 1), expected(edges.size() + 1);
  for (int i = 0; i < samples; ++i) {
    const auto above = std::upper_bound(edges.begin(), edges.end(), draw());
    ++observed[static_cast<std::size_t>(above - edges.begin())];
  }
  // A sample on the last edge belongs to the last bin.
  observed[edges.size() - 1] += observed[edges.size()];
  observed[edges.size()] = 0;
  for (std::size_t i = 1; i < edges.size(); ++i) {
    expected[i] = samples * probability(edges[i - 1], edges[i]);
  }
  return chi_square(observed, expected, comparisons);
}

/// Directions against their density per sr, over bins of equal solid angle around z.
/// @param draw () -> unit Vec3d
/// @param density unit Vec3d -> per sr; integrated with `cubature` midpoints squared a bin
template <class Draw, class Density>
ChiSquare chi_square_directions(Draw&& draw, Density&& density, int samples, int bins_z = 16, int bins_phi = 16,
                                int cubature = 16, double comparisons = 1) {
  std::vector<double> observed(static_cast<std::size_t>(bins_z * bins_phi));
  std::vector<double> expected(observed.size());
  const auto index = [](double share, int bins) { return std::clamp(static_cast<int>(share * bins), 0, bins - 1); };
  for (int i = 0; i < samples; ++i) {
    const Vec3d w = draw();
    const int z = index(0.5 * (w.z + 1), bins_z);
    const int phi = index(std::atan2(w.y, w.x) / (2 * kPi) + 0.5, bins_phi);
    ++observed[static_cast<std::size_t>(z * bins_phi + phi)];
  }
  const double element = 4 * kPi / (static_cast<double>(bins_z) * bins_phi * cubature * cubature);
  for (int z = 0; z < bins_z * cubature; ++z) {
    for (int phi = 0; phi < bins_phi * cubature; ++phi) {
      const double cosine = -1 + 2 * (z + 0.5) / (bins_z * cubature);
      const double angle = -kPi + 2 * kPi * (phi + 0.5) / (bins_phi * cubature);
      const double sine = std::sqrt(1 - cosine * cosine);
      expected[static_cast<std::size_t>(z / cubature * bins_phi + phi / cubature)] +=
          samples * element * density(Vec3d(sine * std::cos(angle), sine * std::sin(angle), cosine));
    }
  }
  return chi_square(observed, expected, comparisons);
}

}  // namespace obscura::test
