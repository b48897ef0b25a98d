// One sweep of discrete ordinates: angular fluxes from a given source, cell by cell in the direction of
// flight, summed into moments. Knows arrays and directions, no World. Formulas: photon/METHODS.md,
// "Discrete ordinates".
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "photon/ordinates/angular_quadrature.h"

namespace obscura::detail {

/// Ordinates are handled in groups of this many; the last group of an octant is filled up with weight 0.
inline constexpr int kGroup = 4;

/// Ordinates as the kernel reads them: [octant][...] where signs matter, else the same in all octants.
struct SweepAngles {
  SweepAngles(const OrdinateSet& set, int moment_order, const Vec3d& cell_m, const std::array<bool, 3>& uniform);

  int ordinates;                                    ///< per octant, padded
  int moments;                                      ///< (order + 1)^2, padded to a multiple of kGroup unless it is 1
  std::array<std::vector<double>, 3> inverse_path;  ///< |cosine| / cell side, 1/m; 0 along uniform axes
  std::array<std::vector<double>, 3> current;       ///< weight times |cosine|
  std::vector<double> weight;
  std::vector<double> to_ordinate;  ///< [octant][moment][ordinate]: harmonics
  std::vector<double> to_moment;    ///< [octant][ordinate][moment]: harmonics times weight
};

/// Arrays of one sweep. Cells run x fastest; a cell has 8 corners, bit a of the corner is its upper side
/// along axis a; moments run fastest.
struct SweepArrays {
  Vec3i cells;
  const double* extinction;    ///< [cell], 1/m
  const std::uint8_t* lumped;  ///< [cell], whether its matrices are lumped
  const double* source;        ///< [cell][corner][moment], W/m3/sr over harmonics
  double* moments;             ///< [cell][corner][moment], added to
  double* flux = nullptr;      ///< [cell][axis], W/m2, added to; null: not wanted
  double sky = 0;              ///< radiance that comes in where nothing else is given
  /// Angular fluxes that enter through the faces across an axis, [octant][row][ordinate group][corner][lane],
  /// and those that leave there; null: the sky enters, what leaves is not kept.
  std::array<const double*, 3> enter{};
  std::array<double*, 3> leave{};
  /// What leaves through the grid's faces, [axis][side][face], W/m2; null: not wanted. Resized.
  std::array<std::array<std::vector<double>*, 2>, 3> leaving{};
  /// Opaque faces: the number of the surface on the lower face of a cell along an axis, -1 none;
  /// [axis][face], one face more than cells along that axis. null: none.
  std::array<const std::int32_t*, 3> surface{};
  const double* surface_radiance = nullptr;  ///< [surface][side], leaving; side 1 looks up the axis
  double* surface_irradiance = nullptr;      ///< [surface][side], arriving, added to
};

/// Doubles in `enter` and `leave` across an axis, for all octants.
std::size_t boundary_size(const SweepAngles& angles, const Vec3i& cells, int axis) noexcept;

/// Space that a sweep works in, kept between sweeps.
struct SweepScratch {
  std::array<std::vector<double>, 3> faces;
};

void sweep(const SweepAngles& angles, const SweepArrays& arrays, SweepScratch& scratch);

}  // namespace obscura::detail
