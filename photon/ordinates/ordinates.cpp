#include "photon/ordinates/ordinates.h"

#include <algorithm>
#include <numeric>

#include "octree/base/error.h"
#include "photon/optics/purpose.h"
#include "photon/ordinates/ordinates_data.h"
#include "photon/ordinates/ordinates_solver.h"

namespace obscura {
namespace {

using detail::OrdinatesSolver;

/// Cells thicker than this along every axis are lumped.
constexpr double kLumpedDepth = 2;

/// Where the fluence is negative at a corner of the cell, moves all corners towards the mean until none is. The mean
/// stays; a negative one becomes 0. Returns whether anything was changed.
bool flatten(double* moments, std::size_t stride) noexcept {
  double mean = 0, least = kInfinity;
  for (std::size_t c = 0; c < 8; ++c) {
    mean += moments[c * stride] / 8;
    least = std::min(least, moments[c * stride]);
  }
  if (least >= 0) return false;
  const double keep = mean > 0 ? mean / (mean - least) : 0.0;
  mean = std::max(mean, 0.0);
  for (std::size_t c = 0; c < 8; ++c) moments[c * stride] = std::max(0.0, mean + keep * (moments[c * stride] - mean));
  return true;
}

}  // namespace

OrdinatesSolution::Data::Data(SpectralWorld world_of, const OrdinatesSettings& settings)
    : world(world_of),
      grid(world_of, settings.cells, settings.box),
      surfaces(world_of, grid),
      set(settings.quadrature, settings.order),
      degree(grid.phase_degree(std::clamp(settings.degree.value_or(set.moment_order()), 0, set.moment_order()))),
      gather(std::max(1, settings.gather)),
      angles(set, degree, grid.cell_m(), {grid.uniform(0), grid.uniform(1), grid.uniform(2)}) {
  const auto degrees = static_cast<std::size_t>(degree) + 1;
  const double air = world.air_extinction();
  forward.resize(grid.size());
  extinction.resize(grid.size());
  scatter.resize(grid.size() * degrees);
  lumped.resize(grid.size());
  double thinnest = kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    if (!grid.uniform(axis)) thinnest = std::min(thinnest, grid.cell_m()[axis]);
  }
  std::vector<double> chi(degrees + 1);
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    // Delta-M (Wiscombe, J. Atmos. Sci. 34, 1977): the first moment left out is the share that goes straight on.
    grid.scattering_moments(cell, chi);
    const double share = chi[0] > 0 ? std::max(0.0, chi[degrees] / chi[0]) : 0.0;
    forward[cell] = share;
    extinction[cell] = grid.extinction[cell] - share * grid.scattering[cell] + air;
    lumped[cell] = extinction[cell] * thinnest > kLumpedDepth;
    for (std::size_t l = 0; l < degrees; ++l) scatter[cell * degrees + l] = chi[l] - share * chi[0];
  }
}

double OrdinatesSolution::Data::depth(const Ray& ray) const {
  double sum = 0;
  march(world, grid, ray,
        [&](double begin, double end, const LocalOptics& optics, std::optional<std::size_t> cell, const CellCursor&) {
          sum += (end - begin) * reduced(optics, cell);
          return sum < 750;
        });
  return sum;
}

double OrdinatesSolution::Data::reflected_far(const SurfacePoint& at) const {
  if (!at.reflects()) return 0;
  double sum = at.reflectance(at.cosine) * world.sky();
  for (const Sun& sun : world->suns()) {
    const double cosine = sun.toward.dot(at.normal);
    const Ray shadow{at.position, sun.toward, world->surfaces().clearance(), kInfinity};
    Stream stream = StreamName{}.stream();
    if (!(cosine > 0) || world->blocked(shadow, at.id, stream)) continue;
    sum += at.material->diffuse(cosine, at.cosine) * cosine * world.value_of(sun.irradiance) * std::exp(-depth(shadow));
  }
  return sum;
}

std::optional<NumericalError> unfit_for_ordinates(SpectralWorld world) {
  const auto unsolved = [](const char* what) {
    return NumericalError("ordinates", std::string(what) + " are not solved by discrete ordinates",
                          "use the path tracer");
  };
  if (!world->spheres().empty()) return unsolved("hot spheres and particles");
  if (world->periodic()) {
    // Across the clouds that repeat, along which its light would have to be followed for ever.
    const Affine axes = world->map_to_world();
    for (int axis = 0; axis < 3; ++axis) {
      if (axis < 2 && world->map_period()[axis] > 0) continue;
      const Vec3d free = Vec3d(axes[axis][0], axes[axis][1], axes[axis][2]).normalized();
      for (const Sun& sun : world->suns()) {
        if (std::abs(free.dot(sun.toward)) <= std::sin(0.5 * sun.diameter) + 1e-9)
          return unsolved("suns on the horizon of clouds that repeat");
      }
    }
  }
  if (world->surfaces().empty()) return std::nullopt;
  if (world->periodic()) return unsolved("surfaces among clouds that repeat");
  if (!world->beams().empty() && world.surfaces_reflect()) return unsolved("beams on surfaces that reflect");
  for (std::size_t i = 0; i < world->objects().size(); ++i) {
    const Object& object = world->objects()[i];
    const std::size_t faces = object.mesh && !object.mesh->slots.empty() ? object.mesh->faces.size() : 1;
    for (std::size_t face = 0; face < faces; ++face) {
      const MaterialOptics& material =
          world.material({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(face)});
      if ((material.specular() > 0 && material.reflects()) || material.permeable() > 0)
        return unsolved("mirrors and permeable surfaces");
    }
  }
  return std::nullopt;
}

OrdinatesSolution solve_ordinates(SpectralWorld world, const OrdinatesSettings& settings, const Progress& progress) {
  if (auto refusal = unfit_for_ordinates(world)) throw *refusal;
  auto data = std::make_shared<OrdinatesSolution::Data>(world, settings);
  OrdinatesSolver solver(*data, settings);
  solver.solve(progress);
  // No negative corner, so that light interpolated between the corners is not negative either.
  for (std::size_t cell = 0; cell < data->grid.size(); ++cell) {
    data->flattened += flatten(&data->moments[8 * cell * data->moment_count()], data->moment_count());
  }
  return OrdinatesSolution(std::move(data));
}

double solver_bytes(const OrdinatesSolution& solution) {
  // About 26 vectors of eight corners' moments a cell (ordinates_solver.cpp).
  const int order = solution.ordinates().order();
  const double degree = std::min(solution.grid().phase_degree(order), order - 1);
  return 26 * 8 * sizeof(double) * static_cast<double>(solution.grid().size()) * (degree + 1) * (degree + 1);
}

const OrdinatesGrid& OrdinatesSolution::grid() const noexcept { return data_->grid; }
const OrdinateSet& OrdinatesSolution::ordinates() const noexcept { return data_->set; }
int OrdinatesSolution::iterations() const noexcept { return data_->iterations; }
double OrdinatesSolution::error() const noexcept { return data_->error; }
const OrdinatesPowers& OrdinatesSolution::powers() const noexcept { return data_->powers; }
std::size_t OrdinatesSolution::flattened() const noexcept { return data_->flattened; }

std::span<const double> OrdinatesSolution::leaving(int axis, int side) const noexcept {
  return data_->leaving[static_cast<std::size_t>(axis)][static_cast<std::size_t>(side)];
}

double OrdinatesSolution::fluence(std::size_t cell) const noexcept {
  double sum = 0;
  const std::size_t stride = data_->moment_count();
  for (std::size_t c = 0; c < 8; ++c) sum += data_->moments[(8 * cell + c) * stride];
  return std::sqrt(4 * kPi) * sum / 8 + data_->uncollided[cell];
}

Vec3d OrdinatesSolution::flux(std::size_t cell) const noexcept {
  const double* const f = &data_->flux[3 * cell];
  return {f[0], f[1], f[2]};
}

}  // namespace obscura
