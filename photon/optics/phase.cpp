#include "photon/optics/phase.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "octree/base/error.h"
#include "octree/base/math.h"
#include "photon/optics/quadrature.h"

namespace obscura {
namespace {

constexpr double kInverseSphere = 0.25 / kPi;

// With the sine of half the angle in place of the cosine nothing cancels near the peak:
// 1 + g^2 - 2 g mu = (1 - g)^2 + 2 g (1 - mu) = (1 + g)^2 - 2 g (1 + mu).
double hg_value(double g, double cosine) noexcept {
  if (g == 1 || g == -1) return 0;
  const double distance2 = g >= 0 ? (1 - g) * (1 - g) + 2 * g * (1 - cosine) : (1 + g) * (1 + g) - 2 * g * (1 + cosine);
  return kInverseSphere * (1 - g) * (1 + g) / (distance2 * std::sqrt(distance2));
}

// 1 - mu and 1 + mu such that a share u of the density lies below mu (METHODS.md): the usual
// inverse, rearranged so that neither cancels and g = 0 needs no case of its own.
struct Cosine {
  double one_minus, one_plus;
};

Cosine hg_sample(double g, double u) noexcept {
  if (g == 1) return {0, 2};
  if (g == -1) return {2, 0};
  const double v = 1 - u;
  const double d = g >= 0 ? (1 - g) + 2 * g * u : (1 + g) - 2 * g * v;
  const double scale = 2 / (d * d);
  return {scale * (1 - g) * (1 - g) * v * (g >= 0 ? 1 + g * u : (1 + g) - g * v),
          scale * (1 + g) * (1 + g) * u * (g >= 0 ? (1 - g) + g * u : 1 - g * v)};
}

double cosine_of(const Cosine& c) noexcept { return c.one_minus < 1 ? 1 - c.one_minus : c.one_plus - 1; }

// Root of mu^3 + 3 mu = 8 u - 4 by the hyperbolic form of Cardano's formula.
double rayleigh_sample(double u) noexcept { return 2 * std::sinh(std::asinh(4 * u - 2) / 3); }

double clamp_cosine(double cosine) noexcept { return std::clamp(cosine, -1.0, 1.0); }

double check_g(double g, const char* name) {
  if (!(g >= -1 && g <= 1)) {
    throw InputError("phase function", std::string(name) + " is not within -1 to 1",
                     "it is the mean cosine of the scattering angle");
  }
  return g;
}

}  // namespace

// Nodes by decreasing angle, so that the cosine increases; each with 1 - cosine, which keeps the
// digits of small angles.
struct PhaseFunction::Table {
  std::vector<double> one_minus;  // decreasing from 2 to 0
  std::vector<double> value;      // per sr
  std::vector<double> below;      // probability of a smaller cosine; from 0 to 1

  // The piece i (between nodes i and i + 1) that holds 1 - cosine = c.
  std::size_t piece_at(double c) const noexcept {
    const auto it =
        std::lower_bound(one_minus.begin() + 1, one_minus.end() - 1, c, [](double node, double x) { return node > x; });
    return static_cast<std::size_t>(it - one_minus.begin()) - 1;
  }

  double value_at(double c) const noexcept {
    const std::size_t i = piece_at(c);
    const double share = (one_minus[i] - c) / (one_minus[i] - one_minus[i + 1]);
    return value[i] + share * (value[i + 1] - value[i]);
  }

  // How far into a piece a share v of its probability reaches, where the density goes linearly
  // from a to b: the inverse of a quadratic.
  static double share_of(double v, double a, double b) noexcept {
    const double root = a + std::sqrt(a * a + v * (b * b - a * a));
    return root > 0 ? std::min(v * (a + b) / root, 1.0) : 0.0;
  }

  double sample_one_minus(double u) const noexcept {
    // A piece without probability is never chosen: u lies in [below[i], below[i + 1]).
    const auto it = std::upper_bound(below.begin() + 1, below.end() - 1, u);
    const std::size_t i = static_cast<std::size_t>(it - below.begin()) - 1;
    const double mass = below[i + 1] - below[i];
    if (!(mass > 0)) return one_minus[i];
    // From the nearer end of the piece, so that small angles keep their digits.
    const double up = (u - below[i]) / mass;
    if (up < 0.5) {
      return one_minus[i] + share_of(std::max(up, 0.0), value[i], value[i + 1]) * (one_minus[i + 1] - one_minus[i]);
    }
    const double down = std::max((below[i + 1] - u) / mass, 0.0);
    return one_minus[i + 1] + share_of(down, value[i + 1], value[i]) * (one_minus[i] - one_minus[i + 1]);
  }
};

PhaseFunction PhaseFunction::rayleigh() {
  PhaseFunction p;
  p.kind_ = Kind::rayleigh;
  return p;
}

PhaseFunction PhaseFunction::henyey_greenstein(double g) {
  PhaseFunction p;
  p.kind_ = Kind::henyey_greenstein;
  p.g1_ = p.mean_cosine_ = check_g(g, "g");
  return p;
}

PhaseFunction PhaseFunction::double_henyey_greenstein(double g1, double g2, double weight) {
  if (!(weight >= 0 && weight <= 1)) {
    throw InputError("phase function", "weight is not within 0 to 1", "it is the share of the lobe g1");
  }
  PhaseFunction p;
  p.kind_ = Kind::double_hg;
  p.g1_ = check_g(g1, "g1");
  p.g2_ = check_g(g2, "g2");
  p.weight_ = weight;
  p.mean_cosine_ = weight * g1 + (1 - weight) * g2;
  return p;
}

PhaseFunction PhaseFunction::table(const std::vector<double>& angles_deg, const std::vector<double>& values,
                                   double* norm_change) {
  const std::size_t n = angles_deg.size();
  const auto fail = [](const std::string& problem, const std::string& hint = {}) {
    throw InputError("phase function", problem, hint);
  };
  if (n < 2) fail("the table has fewer than two rows", "give at least 0 and 180 degrees");
  if (values.size() != n) fail("the table has not one value per angle");
  if (angles_deg.front() != 0 || angles_deg.back() != 180) {
    fail("the angles do not go from 0 to 180 degrees", "0 is forward, 180 is backward");
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::string row = "row " + std::to_string(i + 1);
    if (i > 0 && !(angles_deg[i] > angles_deg[i - 1])) fail(row + ": the angle does not increase");
    if (!(values[i] >= 0) || !std::isfinite(values[i])) {
      fail(row + ": the value is not a finite number >= 0");
    }
  }

  auto table = std::make_shared<Table>();
  for (std::size_t i = n; i-- > 0;) {
    const double half_sine = std::sin(angles_deg[i] * (kPi / 360));
    table->one_minus.push_back(2 * half_sine * half_sine);
    table->value.push_back(values[i]);
  }
  table->one_minus.front() = 2;

  double sum = 0;
  table->below.push_back(0);
  for (std::size_t i = 1; i < n; ++i) {
    sum += kPi * (table->one_minus[i - 1] - table->one_minus[i]) * (table->value[i - 1] + table->value[i]);
    table->below.push_back(sum);
  }
  if (!(sum > 0) || !std::isfinite(sum)) fail("the integral of the table is not a positive number");
  for (double& v : table->value) v /= sum;
  for (double& b : table->below) b /= sum;
  if (norm_change) *norm_change = sum - 1;

  PhaseFunction p;
  p.kind_ = Kind::table;
  p.table_ = std::move(table);
  p.mean_cosine_ = p.moment(1);
  return p;
}

namespace {

/// The g whose lobe's height is peak / (4 pi), or the given one where that is lower.
double blunted_g(double g, double peak) {
  // (1 + g) / (1 - g)^2 = peak
  const double most = 1 + (1 - std::sqrt(1 + 8 * peak)) / (2 * peak);
  return std::clamp(g, -most, most);
}

}  // namespace

PhaseFunction PhaseFunction::blunted(double peak) const {
  switch (kind_) {
    case Kind::isotropic:
    case Kind::rayleigh:
      return *this;
    case Kind::henyey_greenstein:
      return henyey_greenstein(blunted_g(g1_, peak));
    case Kind::double_hg:
      return double_henyey_greenstein(blunted_g(g1_, peak), blunted_g(g2_, peak), weight_);
    case Kind::table:
      break;
  }
  const double highest = *std::max_element(table_->value.begin(), table_->value.end());
  if (4 * kPi * highest <= peak) return *this;

  // All moments at once: every piece of the table by Gauss's rule, the polynomials by their recurrence.
  constexpr int kMoments = 400;
  const GaussLegendre rule(8);
  std::vector<double> moments(kMoments, 0.0);
  const auto polynomials = [](double mu, auto&& visit) {
    double p = 1, previous = 0;
    for (int l = 0; l < kMoments; ++l) {
      visit(l, p);
      const double next = ((2 * l + 1) * mu * p - l * previous) / (l + 1);
      previous = p;
      p = next;
    }
  };
  for (std::size_t i = 0; i + 1 < table_->value.size(); ++i) {
    const double start = table_->one_minus[i], width = start - table_->one_minus[i + 1];
    for (std::size_t k = 0; k < rule.node.size(); ++k) {
      const double value = table_->value[i] + rule.node[k] * (table_->value[i + 1] - table_->value[i]);
      const double weight = 2 * kPi * width * rule.weight[k] * value;
      polynomials(1 - (start - width * rule.node[k]),
                  [&](int l, double p) { moments[static_cast<std::size_t>(l)] += weight * p; });
    }
  }
  // A bound of the height is the sum of the moduli: h by bisection.
  double low = 0, high = 1;
  for (int i = 0; i < 40; ++i) {
    const double h = 0.5 * (low + high);
    double sum = 0, power = 1;
    for (int l = 0; l < kMoments; ++l, power *= h)
      sum += (2 * l + 1) * power * std::abs(moments[static_cast<std::size_t>(l)]);
    (sum > peak ? high : low) = h;
  }
  std::vector<double> angles, values;
  for (int step = 0; step <= 1800; step += step < 300 || step >= 1500 ? 1 : 5) {
    angles.push_back(0.1 * step);
    double sum = 0, power = 1;
    polynomials(std::cos(angles.back() * kPi / 180), [&](int l, double p) {
      sum += (2 * l + 1) * power * moments[static_cast<std::size_t>(l)] * p;
      power *= low;
    });
    values.push_back(std::max(0.0, sum * kInverseSphere));
  }
  return table(angles, values);
}

double PhaseFunction::largest() const noexcept {
  // Henyey and Greenstein's and Rayleigh's are convex in the cosine, and so are their sums; a table's peaks are nodes.
  const auto is_delta = [](double g) { return g == 1 || g == -1; };
  switch (kind_) {
    case Kind::table:
      return *std::max_element(table_->value.begin(), table_->value.end());
    case Kind::henyey_greenstein:
      if (is_delta(g1_)) return kInfinity;
      break;
    case Kind::double_hg:
      if ((weight_ > 0 && is_delta(g1_)) || (weight_ < 1 && is_delta(g2_))) return kInfinity;
      break;
    case Kind::isotropic:
    case Kind::rayleigh:
      break;
  }
  return std::max(value(1), value(-1));
}

double PhaseFunction::value(double cosine) const noexcept {
  const double mu = clamp_cosine(cosine);
  switch (kind_) {
    case Kind::isotropic:
      return kInverseSphere;
    case Kind::rayleigh:
      return 0.75 * kInverseSphere * (1 + mu * mu);
    case Kind::henyey_greenstein:
      return hg_value(g1_, mu);
    case Kind::double_hg:
      return weight_ * hg_value(g1_, mu) + (1 - weight_) * hg_value(g2_, mu);
    case Kind::table:
      return table_->value_at(1 - mu);
  }
  return 0;
}

double PhaseFunction::sample(double u1, double u2) const noexcept {
  switch (kind_) {
    case Kind::isotropic:
      return 2 * u1 - 1;
    case Kind::rayleigh:
      return clamp_cosine(rayleigh_sample(u1));
    case Kind::henyey_greenstein:
      return clamp_cosine(cosine_of(hg_sample(g1_, u1)));
    case Kind::double_hg:
      return clamp_cosine(cosine_of(hg_sample(u2 < weight_ ? g1_ : g2_, u1)));
    case Kind::table:
      return clamp_cosine(1 - table_->sample_one_minus(u1));
  }
  return 0;
}

double PhaseFunction::sample_one_minus(double u1, double u2) const noexcept {
  switch (kind_) {
    case Kind::isotropic:
      return 2 * (1 - u1);
    case Kind::rayleigh: {
      // mu = 2 sinh(a/3) and 1 = 2 sinh(a1/3) with a1 = asinh(2): their difference as a product.
      const double a = std::asinh(4 * u1 - 2) / 3;
      const double a1 = std::asinh(2.0) / 3;
      // a1 - a from asinh(x) - asinh(y) = asinh(x sqrt(1 + y^2) - y sqrt(1 + x^2)).
      const double y = 4 * u1 - 2;
      const double gap = 4 * (1 - u1) * (2 + y) / (2 * std::sqrt(1 + y * y) + y * std::sqrt(5.0));
      const double half = y > -1 ? std::asinh(gap) / 6 : 0.5 * (a1 - a);
      return 4 * std::cosh(0.5 * (a1 + a)) * std::sinh(half);
    }
    case Kind::henyey_greenstein:
      return hg_sample(g1_, u1).one_minus;
    case Kind::double_hg:
      return hg_sample(u2 < weight_ ? g1_ : g2_, u1).one_minus;
    case Kind::table:
      return table_->sample_one_minus(u1);
  }
  return 0;
}

double PhaseFunction::moment(int l) const {
  if (l == 0) return 1;
  switch (kind_) {
    case Kind::isotropic:
      return 0;
    case Kind::rayleigh:
      return l == 2 ? 0.1 : 0;
    case Kind::henyey_greenstein:
      return std::pow(g1_, l);
    case Kind::double_hg:
      return weight_ * std::pow(g1_, l) + (1 - weight_) * std::pow(g2_, l);
    case Kind::table:
      break;
  }
  // Gauss-Legendre is exact for a linear piece times P_l.
  const GaussLegendre rule(l / 2 + 2);
  double sum = 0;
  for (std::size_t i = 0; i + 1 < table_->value.size(); ++i) {
    const double start = table_->one_minus[i];
    const double width = start - table_->one_minus[i + 1];
    for (std::size_t k = 0; k < rule.node.size(); ++k) {
      const double mu = 1 - (start - width * rule.node[k]);
      const double value = table_->value[i] + rule.node[k] * (table_->value[i + 1] - table_->value[i]);
      double p = 1, previous = 0;
      for (int n = 1; n <= l; ++n) {
        const double next = ((2 * n - 1) * mu * p - (n - 1) * previous) / n;
        previous = p;
        p = next;
      }
      sum += 2 * kPi * width * rule.weight[k] * value * p;
    }
  }
  return sum;
}

}  // namespace obscura
