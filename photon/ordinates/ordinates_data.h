// What a solution of discrete ordinates is made of; for the files of that solver alone.
#pragma once

#include <vector>

#include "photon/ordinates/ordinates.h"
#include "photon/ordinates/ordinates_surfaces.h"
#include "photon/ordinates/ordinates_sweep.h"

namespace obscura {

struct OrdinatesSolution::Data {
  Data(SpectralWorld world_of, const OrdinatesSettings& settings);

  SpectralWorld world;
  OrdinatesGrid grid;
  OrdinatesSurfaces surfaces;
  OrdinateSet set;
  int degree;  ///< of the harmonics
  int gather;
  detail::SweepAngles angles;
  std::vector<double> forward;       ///< share of the scattering that counts as not scattered (delta-M), per cell
  std::vector<double> extinction;    ///< 1/m, less the forward share, air included, per cell
  std::vector<std::uint8_t> lumped;  ///< whether a cell is so thick that its matrices are lumped
  std::vector<double> scatter;       ///< [cell][degree], 1/m
  std::vector<double> moments;       ///< [cell][corner][moment] of collided light, sky and emission
  std::vector<double> flux;          ///< [cell][axis]
  std::vector<double> uncollided;    ///< mean fluence per cell of sun, moon and beams
  std::array<std::array<std::vector<double>, 2>, 3> leaving;
  /// What light of one direction scatters first in each cell, W/m3: of every sun, then of every beam.
  struct FirstLight {
    Vec3d direction;
    bool sun;
    std::vector<double> scattered;
  };
  std::vector<FirstLight> first;
  OrdinatesPowers powers;
  int iterations = 0;
  double error = 0;
  std::size_t flattened = 0;

  /// Extinction of a segment less the share that is scattered forward.
  double reduced(const LocalOptics& optics, std::optional<std::size_t> cell) const noexcept {
    return cell ? optics.extinction - forward[*cell] * optics.scattering : optics.extinction;
  }
  /// Reduced optical depth along a ray.
  double depth(const Ray& ray) const;
  /// What a surface reflects that the grid does not hold: the light of sun and moon, behind the clouds, and the
  /// sky as if it were free.
  double reflected_far(const SurfacePoint& at) const;
  std::size_t moment_count() const noexcept { return static_cast<std::size_t>(angles.moments); }
};

namespace detail {

/// Adds the light of sun, moon and beams at its first scattering to the source ([cell][corner][moment], per m3)
/// and its fluence to Data::uncollided, its powers to Data::powers.
void add_first_collisions(OrdinatesSolution::Data& data, std::vector<double>& source);

/// Radiance along a ray without the discs of sun and moon, their first scattering as the grid has it.
double seen_quickly(const OrdinatesSolution::Data& data, const Ray& ray);

}  // namespace detail
}  // namespace obscura
