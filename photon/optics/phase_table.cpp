#include "photon/optics/phase_table.h"

#include <string>
#include <utility>

#include "octree/base/error.h"
#include "octree/base/math.h"
#include "photon/optics/quadrature.h"

namespace obscura {

TablePhase::TablePhase(const std::vector<double>& angles_deg, const std::vector<double>& values, double* norm_change) {
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

  auto nodes = std::make_shared<Nodes>();
  for (std::size_t i = n; i-- > 0;) {
    const double half_sine = std::sin(angles_deg[i] * (kPi / 360));
    nodes->one_minus.push_back(2 * half_sine * half_sine);
    nodes->value.push_back(values[i]);
  }
  nodes->one_minus.front() = 2;

  double sum = 0;
  nodes->below.push_back(0);
  for (std::size_t i = 1; i < n; ++i) {
    sum += kPi * (nodes->one_minus[i - 1] - nodes->one_minus[i]) * (nodes->value[i - 1] + nodes->value[i]);
    nodes->below.push_back(sum);
  }
  if (!(sum > 0) || !std::isfinite(sum)) fail("the integral of the table is not a positive number");
  for (double& v : nodes->value) v /= sum;
  for (double& b : nodes->below) b /= sum;
  if (norm_change) *norm_change = sum - 1;

  nodes_ = std::move(nodes);
  mean_cosine_ = moment(1);
}

TablePhase TablePhase::blunted(double peak) const {
  if (4 * kPi * largest() <= peak) return *this;

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
  for (std::size_t i = 0; i + 1 < nodes_->value.size(); ++i) {
    const double start = nodes_->one_minus[i], width = start - nodes_->one_minus[i + 1];
    for (std::size_t k = 0; k < rule.node.size(); ++k) {
      const double value = nodes_->value[i] + rule.node[k] * (nodes_->value[i + 1] - nodes_->value[i]);
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
    values.push_back(std::max(0.0, sum * (0.25 / kPi)));
  }
  return {angles, values};
}

double TablePhase::moment(int l) const {
  if (l == 0) return 1;
  // Gauss-Legendre is exact for a linear piece times P_l.
  const GaussLegendre rule(l / 2 + 2);
  double sum = 0;
  for (std::size_t i = 0; i + 1 < nodes_->value.size(); ++i) {
    const double start = nodes_->one_minus[i];
    const double width = start - nodes_->one_minus[i + 1];
    for (std::size_t k = 0; k < rule.node.size(); ++k) {
      const double mu = 1 - (start - width * rule.node[k]);
      const double value = nodes_->value[i] + rule.node[k] * (nodes_->value[i + 1] - nodes_->value[i]);
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
