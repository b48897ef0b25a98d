// Discrete ordinates with an estimate of their own error: three solutions, on two grids and with two
// quadratures. Formulas: photon/METHODS.md, "Discrete ordinates".
#pragma once

#include <vector>

#include "photon/ordinates/ordinates.h"

namespace obscura {

/// Cells of a World's grid: one where a World that repeats does not vary along an axis.
/// @param longest cells of the longest side; 0: as the ordinates choose them, twice as many where there is room (32),
/// so that the coarse grid of their own error holds the voxels too
Vec3i ordinates_cells(const World& world, int longest = 0);

/// Immutable; thread-safe. The World must outlive it.
class OrdinatesReferee {
 public:
  /// @param settings of the finest solution. The others have half its cells along each axis, and half its
  /// order there. Fields that the coarse grid cannot hold show in the error.
  /// @throws as solve_ordinates
  OrdinatesReferee(SpectralWorld world, const OrdinatesSettings& settings, const Progress& progress = {});

  const OrdinatesSolution& finest() const noexcept { return solutions_[0]; }

  /// Fluence at a point, W/m2.
  OrdinatesEstimate fluence_at(const Vec3d& point) const;
  /// Power through a face of the grid, W; as OrdinatesPowers::left.
  OrdinatesEstimate left(int axis, int side) const noexcept;
  /// Power absorbed by the clouds, W, all light included.
  OrdinatesEstimate absorbed() const noexcept;
  /// Radiance along rays. The typical relative error of a call's rays is added to each: where two solutions
  /// happen to cross, neighbours tell.
  /// @param incoming of the finest solution, may be empty
  void radiance(std::span<const Ray> rays, std::span<OrdinatesEstimate> estimates,
                std::span<Incoming> incoming = {}) const;

 private:
  /// @param share of the light that the clouds have changed
  OrdinatesEstimate combine(double fine, double coarse, double low, double share = 1) const noexcept;

  std::vector<OrdinatesSolution> solutions_;  // fine; coarse; coarse and of low order
  double tolerance_;
};

}  // namespace obscura
