// The lobe of Henyey & Greenstein (Astrophys. J. 93, 1941), and the sum of two.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "octree/base/error.h"
#include "octree/base/math.h"

namespace obscura {

/// One lobe. At g = +-1 it is a delta: samples are exact, value() is 0 everywhere because a delta has no density.
/// For the members see PhaseModel in phase.h.
class HenyeyGreensteinPhase {
 public:
  /// @param g mean cosine, -1 to 1; @throws InputError outside
  /// @param name of g in that message
  explicit HenyeyGreensteinPhase(double g, const char* name = "g") : g_(g) {
    if (!(g >= -1 && g <= 1)) {
      throw InputError("phase function", std::string(name) + " is not within -1 to 1",
                       "it is the mean cosine of the scattering angle");
    }
  }

  bool is_delta() const noexcept { return g_ == 1 || g_ == -1; }

  // With the sine of half the angle in place of the cosine nothing cancels near the peak:
  // 1 + g^2 - 2 g mu = (1 - g)^2 + 2 g (1 - mu) = (1 + g)^2 - 2 g (1 + mu).
  double value(double mu) const noexcept {
    if (is_delta()) return 0;
    const double distance2 =
        g_ >= 0 ? (1 - g_) * (1 - g_) + 2 * g_ * (1 - mu) : (1 + g_) * (1 + g_) - 2 * g_ * (1 + mu);
    return 0.25 / kPi * (1 - g_) * (1 + g_) / (distance2 * std::sqrt(distance2));
  }

  double sample(double u1, double) const noexcept {
    const Cosine c = inverse(u1);
    return c.one_minus < 1 ? 1 - c.one_minus : c.one_plus - 1;
  }
  double sample_one_minus(double u1, double) const noexcept { return inverse(u1).one_minus; }

  /// Convex in the cosine: highest at one of its ends.
  double largest() const noexcept { return is_delta() ? kInfinity : std::max(value(1), value(-1)); }
  double mean_cosine() const noexcept { return g_; }
  double moment(int l) const noexcept { return std::pow(g_, l); }

  /// The g whose lobe's height is peak / (4 pi), (1 + g) / (1 - g)^2 = peak, or the own one where that is lower.
  HenyeyGreensteinPhase blunted(double peak) const {
    const double most = 1 + (1 - std::sqrt(1 + 8 * peak)) / (2 * peak);
    return HenyeyGreensteinPhase(std::clamp(g_, -most, most));
  }

 private:
  struct Cosine {
    double one_minus, one_plus;
  };

  // 1 - mu and 1 + mu such that a share u of the density lies below mu (METHODS.md): the usual
  // inverse, rearranged so that neither cancels and g = 0 needs no case of its own.
  Cosine inverse(double u) const noexcept {
    const double g = g_;
    if (g == 1) return {0, 2};
    if (g == -1) return {2, 0};
    const double v = 1 - u;
    const double d = g >= 0 ? (1 - g) + 2 * g * u : (1 + g) - 2 * g * v;
    const double scale = 2 / (d * d);
    return {scale * (1 - g) * (1 - g) * v * (g >= 0 ? 1 + g * u : (1 + g) - g * v),
            scale * (1 + g) * (1 + g) * u * (g >= 0 ? (1 - g) + g * u : 1 - g * v)};
  }

  double g_;
};

/// weight * HG(g1) + (1 - weight) * HG(g2). For the members see PhaseModel in phase.h.
class DoubleHenyeyGreensteinPhase {
 public:
  /// @param weight 0 to 1; @throws InputError outside
  DoubleHenyeyGreensteinPhase(double g1, double g2, double weight)
      : first_(g1, "g1"), second_(g2, "g2"), weight_(weight) {
    if (!(weight >= 0 && weight <= 1)) {
      throw InputError("phase function", "weight is not within 0 to 1", "it is the share of the lobe g1");
    }
  }

  double value(double mu) const noexcept { return weight_ * first_.value(mu) + (1 - weight_) * second_.value(mu); }
  double sample(double u1, double u2) const noexcept { return chosen(u2).sample(u1, u2); }
  double sample_one_minus(double u1, double u2) const noexcept { return chosen(u2).sample_one_minus(u1, u2); }
  /// The sum of what is convex in the cosine is convex too.
  double largest() const noexcept {
    if ((weight_ > 0 && first_.is_delta()) || (weight_ < 1 && second_.is_delta())) return kInfinity;
    return std::max(value(1), value(-1));
  }
  double mean_cosine() const noexcept { return weight_ * first_.mean_cosine() + (1 - weight_) * second_.mean_cosine(); }
  double moment(int l) const noexcept {
    return l == 0 ? 1 : weight_ * first_.moment(l) + (1 - weight_) * second_.moment(l);
  }
  DoubleHenyeyGreensteinPhase blunted(double peak) const {
    return {first_.blunted(peak).mean_cosine(), second_.blunted(peak).mean_cosine(), weight_};
  }

 private:
  const HenyeyGreensteinPhase& chosen(double u2) const noexcept { return u2 < weight_ ? first_ : second_; }

  HenyeyGreensteinPhase first_, second_;
  double weight_;
};

}  // namespace obscura
