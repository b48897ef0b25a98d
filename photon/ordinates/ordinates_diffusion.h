// Diffusion on the grid of discrete ordinates: what makes its iteration fast. An approximation that no
// result depends on.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "octree/base/math.h"

namespace obscura::detail {

/// Unknowns are the 8 corners of every cell, as in the sweep. Two levels are added: continuous diffusion on
/// the grid's vertices, and each cell by itself with leaks through its faces, for what jumps between cells.
class DiffusionCorrection {
 public:
  /// @param absorption per cell, 1/m; @param transport extinction less forward scattering, 1/m
  DiffusionCorrection(const Vec3i& cells, const Vec3d& cell_m, const std::array<bool, 3>& periodic,
                      std::vector<double> absorption, std::vector<double> transport);

  /// Fluence that a source (W/m3, per corner) adds by diffusion. Not thread-safe: it works in its own memory.
  void correct(const std::vector<double>& source, std::vector<double>& fluence);

 private:
  void assemble();
  std::size_t vertex(int i, int j, int k) const noexcept;
  void multiply(const std::vector<double>& x, std::vector<double>& y) const;
  void precondition(const std::vector<double>& r, std::vector<double>& z) const;
  void solve();

  Vec3i cells_, vertices_;
  Vec3d cell_m_;
  std::array<bool, 3> periodic_;
  std::vector<double> absorption_, diffusion_;
  std::vector<std::size_t> corner_;  // [cell][corner], its vertex
  std::vector<double> diagonal_, pivot_;
  std::array<std::vector<double>, 3> link_;       // to the next vertex along an axis
  std::array<std::vector<std::size_t>, 3> next_;  // that vertex; itself where there is none
  std::vector<double> x_, b_, r_, z_, p_, q_;
};

}  // namespace obscura::detail
