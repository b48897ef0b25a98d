// A phase function that is given at angles, such as a measured one or one from Mie's theory.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

namespace obscura {

/// Linear in the cosine between nodes; normalised here. Copies share the nodes. For the members see PhaseModel in
/// phase.h.
class TablePhase {
 public:
  /// @param angles_deg strictly increasing from 0 (forward) to 180
  /// @param values as many, >= 0, not all 0, in any unit
  /// @param norm_change if not null: integral of the given values over the sphere, less 1
  /// @throws InputError
  TablePhase(const std::vector<double>& angles_deg, const std::vector<double>& values, double* norm_change = nullptr);

  double value(double mu) const noexcept { return nodes_->value_at(1 - mu); }
  double sample(double u1, double) const noexcept { return 1 - nodes_->sample_one_minus(u1); }
  double sample_one_minus(double u1, double) const noexcept { return nodes_->sample_one_minus(u1); }
  double largest() const noexcept { return *std::max_element(nodes_->value.begin(), nodes_->value.end()); }
  double mean_cosine() const noexcept { return mean_cosine_; }
  double moment(int l) const;
  TablePhase blunted(double peak) const;

 private:
  // Nodes by decreasing angle, so that the cosine increases; each with 1 - cosine, which keeps the
  // digits of small angles.
  struct Nodes {
    std::vector<double> one_minus;  // decreasing from 2 to 0
    std::vector<double> value;      // per sr
    std::vector<double> below;      // probability of a smaller cosine; from 0 to 1

    // The piece i (between nodes i and i + 1) that holds 1 - cosine = c.
    std::size_t piece_at(double c) const noexcept {
      const auto it = std::lower_bound(one_minus.begin() + 1, one_minus.end() - 1, c,
                                       [](double node, double x) { return node > x; });
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

  std::shared_ptr<const Nodes> nodes_;
  double mean_cosine_ = 0;
};

}  // namespace obscura
