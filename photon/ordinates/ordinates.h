// Discrete ordinates: deterministic light in the clouds at one spectral interval, on a uniform grid. A
// referee for the photon map and the path tracer, with none of their code. Formulas: photon/METHODS.md,
// "Discrete ordinates".
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>

#include "octree/base/error.h"
#include "octree/base/progress.h"
#include "photon/ordinates/angular_quadrature.h"
#include "photon/ordinates/ordinates_grid.h"
#include "photon/paths/radiance.h"
#include "photon/world/spectral_world.h"

namespace obscura {

struct OrdinatesSettings {
  /// Cells along the axes of the grid (OrdinatesGrid); 0: chosen, at most 32 on the longest side. Clouds that
  /// repeat and do not vary along x or y need one cell there.
  Vec3i cells{0, 0, 0};
  std::optional<Box3d> box;  ///< of the grid, world metres; absent: the bounds of the clouds, or one period
  int order = 8;             ///< N of S_N, even, 2 to 32
  AngularQuadrature quadrature = AngularQuadrature::double_gauss;
  /// Most moments of phase functions, from 0; none: what the quadrature can hold. Fewer are faster, with more
  /// left to delta-M.
  std::optional<int> degree;
  /// Where a ray meets a surface that reflects, what comes there is gathered by 2 n^2 rays.
  int gather = 16;
  double tolerance = 1e-7;   ///< of the iteration: estimated error relative to the solution, in the mean square
  int max_iterations = 200;  ///< sweeps
  double memory_MiB = 6144;  ///< more is refused
};

/// Powers in W, of the cell that repeats where the World does. Light of sun, moon and beams counts from its
/// first collision on, or from the first surface.
struct OrdinatesPowers {
  double emitted = 0;                           ///< by the clouds
  double entered = 0;                           ///< from the sky through the grid's faces
  double first_scattered = 0;                   ///< of sun, moon and beams
  double first_absorbed = 0;                    ///< of sun, moon and beams before any scattering; in no other
  double absorbed = 0;                          ///< by the clouds, of all the rest
  double surfaces = 0;                          ///< given off by surfaces less absorbed by them
  std::array<std::array<double, 2>, 3> left{};  ///< through the faces, [axis][lower, upper]
  /// What came in less what went, over what came in.
  double residual() const noexcept {
    double in = emitted + entered + first_scattered, out = absorbed - surfaces;
    for (const auto& sides : left) out += sides[0] + sides[1];
    return in > 0 ? (in - out) / in : 0.0;
  }
};

struct OrdinatesEstimate {
  double value = 0;
  double error = 0;  ///< about one standard error: |value - truth| below twice of it is agreement
};

/// Immutable; thread-safe. The World must outlive it.
class OrdinatesSolution {
 public:
  const OrdinatesGrid& grid() const noexcept;
  const OrdinateSet& ordinates() const noexcept;
  /// Sweeps made.
  int iterations() const noexcept;
  /// Estimated error of the iteration, relative to the solution, in the mean square.
  double error() const noexcept;
  const OrdinatesPowers& powers() const noexcept;
  /// Power that leaves through a part of a face of the grid, W/m2: cells of the face, the first of the other
  /// two axes fastest.
  std::span<const double> leaving(int axis, int side) const noexcept;

  /// Mean over a cell, W/m2, light of sun, moon and beams included.
  double fluence(std::size_t cell) const noexcept;
  /// Net flux in a cell, W/m2, in the grid's frame; without light of sun, moon and beams that has not collided.
  Vec3d flux(std::size_t cell) const noexcept;
  /// Cells where the fluence would have been negative somewhere and was made flatter.
  std::size_t flattened() const noexcept;

  /// Fluence at a point, W/m2: the radiance from all directions, found adaptively, and the discs. Beams count
  /// from their first scattering on. The error is that of the directions alone.
  OrdinatesEstimate fluence_at(const Vec3d& point) const;

  /// Radiance along rays: Incoming's direct, transmission and distance. The World's own segments attenuate
  /// and emit; scattered light comes from the solution, the first scattering of sun and moon from the exact
  /// phase function and exact shadows. Directions are unit vectors.
  void radiance(std::span<const Ray> rays, std::span<Incoming> incoming) const;

  struct Data;
  explicit OrdinatesSolution(std::shared_ptr<const Data> data) : data_(std::move(data)) {}
  const Data& data() const noexcept { return *data_; }

 private:
  std::shared_ptr<const Data> data_;
};

/// Why discrete ordinates cannot serve the World: hot spheres, mirrors, permeable surfaces, surfaces or beams where
/// they are not solved; none: they can.
std::optional<NumericalError> unfit_for_ordinates(SpectralWorld world);

/// @throws InputError      a box without volume, or an order that does not exist
/// @throws ResourceError   memory above the limit
/// @throws NumericalError  as unfit_for_ordinates() answers; no convergence
OrdinatesSolution solve_ordinates(SpectralWorld world, const OrdinatesSettings& settings,
                                  const Progress& progress = {});

/// Bytes that the solver has held while it iterated.
double solver_bytes(const OrdinatesSolution& solution);

}  // namespace obscura
