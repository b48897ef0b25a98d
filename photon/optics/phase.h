// Phase functions: where a scattered photon goes. A value type for kernels: no virtual, no
// allocation after it is made, cheap to copy. Formulas: METHODS.md, Phase functions.
#pragma once

#include <memory>
#include <vector>

namespace obscura {

/// Density over directions per sr, normalised to 1 over the sphere, of the cosine between the
/// directions of travel before and after: 1 is forward.
class PhaseFunction {
 public:
  /// Isotropic.
  PhaseFunction() = default;
  static PhaseFunction isotropic() { return {}; }
  static PhaseFunction rayleigh();

  /// Henyey & Greenstein (Astrophys. J. 93, 1941). At g = +-1 it is a delta: sample() is exact,
  /// value() is 0 everywhere because a delta has no density.
  /// @param g mean cosine, -1 to 1; @throws InputError outside
  static PhaseFunction henyey_greenstein(double g);

  /// weight * HG(g1) + (1 - weight) * HG(g2).
  /// @param weight 0 to 1; @throws InputError outside
  static PhaseFunction double_henyey_greenstein(double g1, double g2, double weight);

  /// Linear in the cosine between nodes; normalised here.
  /// @param angles_deg strictly increasing from 0 (forward) to 180
  /// @param values as many, >= 0, not all 0, in any unit
  /// @param norm_change if not null: integral of the given values over the sphere, less 1
  /// @throws InputError
  static PhaseFunction table(const std::vector<double>& angles_deg, const std::vector<double>& values,
                             double* norm_change = nullptr);

  /// The same light scattered into somewhat other directions: convolved with as wide a Henyey-Greenstein lobe as
  /// leaves no value above peak / (4 pi). Moments l are multiplied by h^l. Where none is above, the same function.
  /// @param peak > 1
  PhaseFunction blunted(double peak) const;

  /// Per sr. A cosine that rounding carried beyond +-1 counts as +-1.
  double value(double cosine) const noexcept;

  /// Cosine of the scattering angle with density 2 pi value(cosine). Both numbers are uniform in
  /// [0, 1]; the cosine increases with u1; u2 chooses between lobes (double HG only).
  double sample(double u1, double u2) const noexcept;

  /// 1 - sample(u1, u2), without the loss of digits near the forward direction.
  double sample_one_minus(double u1, double u2) const noexcept;

  /// Largest value(), per sr; infinite where a lobe has g = +-1.
  double largest() const noexcept;

  /// First moment, g.
  double mean_cosine() const noexcept { return mean_cosine_; }

  /// Integral over the sphere of value times the Legendre polynomial P_l; 1 for l = 0. For set-up.
  double moment(int l) const;

 private:
  enum class Kind : unsigned char { isotropic, rayleigh, henyey_greenstein, double_hg, table };
  struct Table;

  Kind kind_ = Kind::isotropic;
  double g1_ = 0;
  double g2_ = 0;
  double weight_ = 1;
  double mean_cosine_ = 0;
  std::shared_ptr<const Table> table_;
};

}  // namespace obscura
