// Phase functions: where a scattered photon goes. A value type for kernels: no virtual, no
// allocation after it is made, cheap to copy. Formulas: photon/METHODS.md, "Phase functions".
// To add one: a struct with the members of PhaseModel in a header of its own, its name in the list of
// PhaseFunction::Any, its words in the scene's keys (scene/file/scene_keys_clouds.h).
#pragma once

#include <concepts>
#include <utility>
#include <variant>
#include <vector>

#include "photon/optics/phase_henyey_greenstein.h"
#include "photon/optics/phase_isotropic.h"
#include "photon/optics/phase_rayleigh.h"
#include "photon/optics/phase_table.h"

namespace obscura {

/// What a type of phase function has: a density over directions per sr, normalised to 1 over the sphere, of the cosine
/// mu between the directions of travel before and after; mu = 1 is forward.
template <class P>
concept PhaseModel = std::copyable<P> && requires(const P phase, double number, int l) {
  /// Per sr, at mu within -1 to 1; 0 for a delta, which has no density.
  { phase.value(number) }
  noexcept->std::same_as<double>;
  /// mu with density 2 pi value(mu), from two numbers that are uniform in [0, 1]: it increases with the first, the
  /// second chooses between lobes. Rounding may carry it a little beyond +-1.
  { phase.sample(number, number) }
  noexcept->std::same_as<double>;
  /// 1 - sample(), without the loss of digits near the forward direction.
  { phase.sample_one_minus(number, number) }
  noexcept->std::same_as<double>;
  /// Largest value, per sr; infinite for a delta.
  { phase.largest() }
  noexcept->std::same_as<double>;
  /// Moment 1.
  { phase.mean_cosine() }
  noexcept->std::same_as<double>;
  /// Integral over the sphere of value times the Legendre polynomial P_l; 1 for l = 0. For set-up.
  { phase.moment(l) } -> std::same_as<double>;
  /// The same with no value above peak / (4 pi), peak > 1: see PhaseFunction::blunted().
  { phase.blunted(number) } -> std::same_as<P>;
};

/// One of the phase functions below.
class PhaseFunction {
 public:
  template <PhaseModel... Models>
  using OneOf = std::variant<Models...>;
  using Any = OneOf<IsotropicPhase, RayleighPhase, HenyeyGreensteinPhase, DoubleHenyeyGreensteinPhase, TablePhase>;

  /// Isotropic.
  PhaseFunction() = default;
  explicit PhaseFunction(Any any) noexcept : any_(std::move(any)) {}

  static PhaseFunction isotropic() { return {}; }
  static PhaseFunction rayleigh() { return PhaseFunction(RayleighPhase()); }
  /// @param g mean cosine, -1 to 1; @throws InputError outside
  static PhaseFunction henyey_greenstein(double g) { return PhaseFunction(HenyeyGreensteinPhase(g)); }
  /// @param weight of g1, 0 to 1; @throws InputError outside
  static PhaseFunction double_henyey_greenstein(double g1, double g2, double weight) {
    return PhaseFunction(DoubleHenyeyGreensteinPhase(g1, g2, weight));
  }
  /// @throws InputError; for the arguments see TablePhase
  static PhaseFunction table(const std::vector<double>& angles_deg, const std::vector<double>& values,
                             double* norm_change = nullptr) {
    return PhaseFunction(TablePhase(angles_deg, values, norm_change));
  }

  /// A smoother copy: convolved with a Henyey-Greenstein lobe just wide enough that no value exceeds peak / (4 pi).
  /// With h the lobe's mean cosine, the Legendre moment l is multiplied by h^l. Where no value is above, the same
  /// function.
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
  double mean_cosine() const noexcept;

  /// Integral over the sphere of value times the Legendre polynomial P_l; 1 for l = 0. For set-up.
  double moment(int l) const;

 private:
  Any any_;
};

}  // namespace obscura
