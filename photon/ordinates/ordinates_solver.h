// The iteration of discrete ordinates: Krylov's method over sweeps, with diffusion to speed it up.
#pragma once

#include <memory>
#include <vector>

#include "octree/base/progress.h"
#include "photon/ordinates/ordinates_data.h"
#include "photon/ordinates/ordinates_diffusion.h"

namespace obscura::detail {

class OrdinatesSolver {
 public:
  /// @throws ResourceError where the settings' memory does not do
  OrdinatesSolver(OrdinatesSolution::Data& data, const OrdinatesSettings& settings);

  /// Fills moments, flux, powers and what leaves. @throws NumericalError without convergence
  void solve(const Progress& progress);

 private:
  using Vector = std::vector<double>;

  void check_memory();
  void make_sources();
  /// Light that enters the grid from surfaces beyond it, where there are any.
  void look_outside();
  void make_diffusion();
  /// One sweep: y is the light that x makes by scattering and reflection, with or without the World's sources.
  void apply(const Vector& x, bool sources, Vector& y);
  /// Adds to x what diffusion predicts for the collisions that are still to come.
  void accelerate(Vector& x);
  void iterate(const Progress& progress);
  void finish();

  OrdinatesSolution::Data& data_;
  const OrdinatesSettings& settings_;
  std::size_t moments_size_ = 0;  // of x: moments, then what enters across periodic axes,
  std::array<std::size_t, 3> enter_at_{}, enter_size_{};
  std::size_t surfaces_at_ = 0;  // then the radiance of every side of a surface
  Vector irradiance_;            // of every side, in a sweep
  std::size_t size_ = 0;
  int restart_ = 20;
  Vector external_;                        // [cell][corner][moment]
  std::array<Vector, 3> outside_;          // what enters the grid, as SweepArrays::enter; empty: the sky
  Vector source_;                          // of a sweep
  Vector correction_source_, correction_;  // [cell][corner]
  std::unique_ptr<DiffusionCorrection> diffusion_;
  SweepScratch scratch_;
  bool finishing_ = false;  // the sweep that keeps currents and what leaves
  Vector x_;
};

}  // namespace obscura::detail
