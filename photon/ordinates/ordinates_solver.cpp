#include "photon/ordinates/ordinates_solver.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>

#include "octree/base/error.h"

namespace obscura::detail {
namespace {

using Vector = std::vector<double>;

constexpr std::size_t kChunk = 16384;

/// Sums in a fixed order for any number of threads.
double dot(const Vector& a, const Vector& b) {
  return tbb::parallel_deterministic_reduce(
      tbb::blocked_range<std::size_t>(0, a.size(), kChunk), 0.0,
      [&](const tbb::blocked_range<std::size_t>& range, double sum) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) sum += a[i] * b[i];
        return sum;
      },
      std::plus<>());
}

double norm(const Vector& a) { return std::sqrt(dot(a, a)); }

/// y += a x
void add(double a, const Vector& x, Vector& y) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, x.size(), kChunk),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) y[i] += a * x[i];
                    });
}

void scale(double a, Vector& x) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, x.size(), kChunk),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) x[i] *= a;
                    });
}

constexpr double kBytesPerMiB = 1048576.0;

}  // namespace

OrdinatesSolver::OrdinatesSolver(OrdinatesSolution::Data& data, const OrdinatesSettings& settings)
    : data_(data), settings_(settings) {
  moments_size_ = 8 * data.grid.size() * data.moment_count();
  size_ = moments_size_;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    if (!data.grid.periodic(axis) || data.grid.uniform(axis)) continue;
    enter_at_[a] = size_;
    enter_size_[a] = boundary_size(data.angles, data.grid.cells(), axis);
    size_ += enter_size_[a];
  }
  surfaces_at_ = size_;
  size_ += data.surfaces.sides.size();
  irradiance_.resize(data.surfaces.sides.size());
  check_memory();
}

void OrdinatesSolver::check_memory() {
  // External and swept sources, moments, and two vectors beside the Krylov space.
  const double one = static_cast<double>(size_) * sizeof(double);
  double faces = 0;
  for (int axis = 0; axis < 3; ++axis)
    faces += static_cast<double>(boundary_size(data_.angles, data_.grid.cells(), axis)) * sizeof(double) / 8;
  const double limit = settings_.memory_MiB * kBytesPerMiB;
  const auto needs = [&](int vectors) { return (vectors + 6) * one + faces; };
  while (restart_ > 5 && needs(restart_) > limit) --restart_;
  if (needs(restart_) > limit) {
    throw ResourceError("ordinates",
                        "the grid and the moments need " +
                            std::to_string(static_cast<long>(needs(restart_) / kBytesPerMiB)) + " MiB where " +
                            std::to_string(static_cast<long>(settings_.memory_MiB)) + " are allowed",
                        "take fewer cells or a lower order");
  }
}

void OrdinatesSolver::make_diffusion() {
  const auto degrees = static_cast<std::size_t>(data_.degree) + 1;
  Vector absorption, transport;
  for (std::size_t cell = 0; cell < data_.grid.size(); ++cell) {
    const double* const scatter = &data_.scatter[cell * degrees];
    absorption.push_back(std::max(0.0, data_.extinction[cell] - scatter[0]));
    transport.push_back(data_.extinction[cell] - (degrees > 1 ? scatter[1] : 0.0));
  }
  const OrdinatesGrid& grid = data_.grid;
  diffusion_ = std::make_unique<DiffusionCorrection>(
      grid.cells(), grid.cell_m(), std::array<bool, 3>{grid.periodic(0), grid.periodic(1), grid.periodic(2)},
      std::move(absorption), std::move(transport));
  correction_source_.resize(8 * grid.size());
  correction_.resize(8 * grid.size());
}

void OrdinatesSolver::apply(const Vector& x, bool sources, Vector& y) {
  const auto degrees = static_cast<std::size_t>(data_.degree) + 1;
  const std::size_t stride = data_.moment_count();
  tbb::parallel_for(std::size_t{0}, data_.grid.size(), [&](std::size_t cell) {
    const double* const scatter = &data_.scatter[cell * degrees];
    for (std::size_t n = 8 * cell * stride; n < 8 * (cell + 1) * stride; n += stride) {
      for (std::size_t l = 0, m = 0; l < degrees; ++l) {
        for (; m < (l + 1) * (l + 1); ++m) source_[n + m] = scatter[l] * x[n + m] + (sources ? external_[n + m] : 0.0);
      }
    }
  });
  std::fill(y.begin(), y.end(), 0.0);
  SweepArrays arrays;
  arrays.cells = data_.grid.cells();
  arrays.extinction = data_.extinction.data();
  arrays.lumped = data_.lumped.data();
  arrays.source = source_.data();
  arrays.moments = y.data();
  arrays.sky = sources ? data_.world.sky() : 0.0;
  for (std::size_t a = 0; a < 3; ++a) {
    if (sources && !outside_[a].empty()) arrays.enter[a] = outside_[a].data();
    if (enter_size_[a] == 0) continue;
    arrays.enter[a] = x.data() + enter_at_[a];
    arrays.leave[a] = y.data() + enter_at_[a];
  }
  if (finishing_) {
    arrays.flux = data_.flux.data();
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t side = 0; side < 2; ++side) arrays.leaving[a][side] = &data_.leaving[a][side];
    }
  }
  std::vector<OrdinatesSide>& sides = data_.surfaces.sides;
  std::fill(irradiance_.begin(), irradiance_.end(), 0.0);
  if (!sides.empty()) {
    for (std::size_t a = 0; a < 3; ++a) arrays.surface[a] = data_.surfaces.faces[a].data();
    arrays.surface_radiance = x.data() + surfaces_at_;
    arrays.surface_irradiance = irradiance_.data();
  }
  sweep(data_.angles, arrays, scratch_);
  for (std::size_t n = 0; n < sides.size(); ++n) {
    // A white surface in isotropic light must send off the radiance that arrives: half_flux is pi as the set sums it.
    double radiance = sides[n].reflectance * irradiance_[n] / data_.set.half_flux(sides[n].axis);
    if (sources) radiance += sides[n].emission + sides[n].reflectance * sides[n].sunlight / kPi;
    y[surfaces_at_ + n] = sides[n].inside ? radiance : 0.0;
  }
  ++data_.iterations;
}

void OrdinatesSolver::accelerate(Vector& x) {
  const auto degrees = static_cast<std::size_t>(data_.degree) + 1;
  const std::size_t stride = data_.moment_count();
  for (std::size_t n = 0; n < correction_source_.size(); ++n)
    correction_source_[n] = data_.scatter[n / 8 * degrees] * x[n * stride];
  diffusion_->correct(correction_source_, correction_);
  for (std::size_t n = 0; n < correction_.size(); ++n) x[n * stride] += correction_[n];
}

void OrdinatesSolver::iterate(const Progress& progress) {
  // GMRES, preconditioned from the left (Saad & Schultz, SIAM J. Sci. Stat. Comput. 7, 1986): what it makes
  // small is about the error itself.
  Vector work(size_), residual(size_);
  std::vector<Vector> basis;
  while (true) {
    apply(x_, true, residual);
    add(-1, x_, residual);
    accelerate(residual);
    const double beta = norm(residual), whole = std::max(norm(x_), beta);
    data_.error = whole > 0 ? beta / whole : 0.0;
    progress.report("discrete ordinates", static_cast<std::uint64_t>(data_.iterations), 0);
    if (data_.error <= settings_.tolerance) return;
    if (data_.iterations >= settings_.max_iterations || !std::isfinite(beta)) {
      throw NumericalError(
          "ordinates",
          "no convergence after " + std::to_string(data_.iterations) + " sweeps: error " + std::to_string(data_.error),
          "allow more iterations or a larger tolerance");
    }
    scale(1 / beta, residual);
    if (basis.empty()) basis.emplace_back();
    basis[0] = residual;
    std::vector<std::vector<double>> h;  // columns, rotated
    std::vector<double> cosine, sine, rhs{beta};
    int steps = 0;
    while (steps < restart_) {
      const auto n = static_cast<std::size_t>(steps);
      apply(basis[n], false, work);
      scale(-1, work);
      add(1, basis[n], work);
      accelerate(work);
      std::vector<double>& column = h.emplace_back();
      // Modified Gram-Schmidt.
      for (std::size_t i = 0; i <= n; ++i) {
        column.push_back(dot(work, basis[i]));
        add(-column[i], basis[i], work);
      }
      const double rest = norm(work);
      for (std::size_t i = 0; i < n; ++i) {
        const double a = column[i], b = column[i + 1];
        column[i] = cosine[i] * a + sine[i] * b;
        column[i + 1] = cosine[i] * b - sine[i] * a;
      }
      const double r = std::hypot(column[n], rest);
      cosine.push_back(r > 0 ? column[n] / r : 1.0);
      sine.push_back(r > 0 ? rest / r : 0.0);
      column[n] = r;
      rhs.push_back(-sine[n] * rhs[n]);
      rhs[n] *= cosine[n];
      ++steps;
      progress.report("discrete ordinates", static_cast<std::uint64_t>(data_.iterations), 0);
      // The inner diffusion is solved to 1e-4: beyond that the residual is formed anew.
      if (std::abs(rhs.back()) <= std::max(0.3 * settings_.tolerance * whole, 1e-6 * beta) || !(rest > 0) ||
          data_.iterations >= settings_.max_iterations || progress.cancelled()) {
        break;
      }
      if (basis.size() <= n + 1) basis.emplace_back();
      scale(1 / rest, work);
      basis[n + 1] = work;
    }
    for (std::size_t i = static_cast<std::size_t>(steps); i-- > 0;) {
      for (std::size_t j = i + 1; j < static_cast<std::size_t>(steps); ++j) rhs[i] -= h[j][i] * rhs[j];
      rhs[i] = h[i][i] != 0 ? rhs[i] / h[i][i] : 0.0;
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(steps); ++i) add(rhs[i], basis[i], x_);
    if (progress.cancelled()) return;
  }
}

void OrdinatesSolver::finish() {
  // One more sweep, in which currents and leaving light are kept: they fit the moments that it makes.
  const auto degrees = static_cast<std::size_t>(data_.degree) + 1;
  Vector y(size_);
  const OrdinatesGrid& grid = data_.grid;
  data_.flux.assign(3 * grid.size(), 0.0);
  finishing_ = true;
  apply(x_, true, y);
  finishing_ = false;
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    double mean = 0;
    for (std::size_t c = 0; c < 8; ++c) mean += y[(8 * cell + c) * data_.moment_count()] / 8;
    data_.powers.absorbed +=
        (data_.extinction[cell] - data_.scatter[cell * degrees]) * std::sqrt(4 * kPi) * mean * grid.cell_volume();
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (grid.periodic(axis)) continue;
    const auto a = static_cast<std::size_t>(axis);
    for (std::size_t side = 0; side < 2; ++side) {
      const std::vector<double>& faces = data_.leaving[a][side];
      for (const double face : faces) data_.powers.left[a][side] += face * grid.face_area(axis);
      if (outside_[a].empty()) {
        data_.powers.entered +=
            data_.world.sky() * data_.set.half_flux(axis) * grid.face_area(axis) * static_cast<double>(faces.size());
      }
    }
  }
  for (std::size_t a = 0; a < 3; ++a) {
    const auto count = static_cast<std::size_t>(data_.angles.ordinates);
    for (std::size_t n = 0; n < outside_[a].size(); ++n) {
      data_.powers.entered +=
          0.25 * data_.angles.current[a][n % count] * outside_[a][n] * grid.face_area(static_cast<int>(a));
    }
  }
  for (std::size_t n = 0; n < data_.surfaces.sides.size(); ++n) {
    OrdinatesSide& side = data_.surfaces.sides[n];
    side.reflected = y[surfaces_at_ + n] - side.emission;
    data_.powers.surfaces +=
        grid.face_area(side.axis) * (data_.set.half_flux(side.axis) * x_[surfaces_at_ + n] - irradiance_[n]);
  }
  y.resize(moments_size_);
  y.shrink_to_fit();
  data_.moments = std::move(y);
}

void OrdinatesSolver::solve(const Progress& progress) {
  make_sources();
  look_outside();
  make_diffusion();
  source_.assign(moments_size_, 0.0);
  x_.assign(size_, 0.0);
  // Start from the sky's radiance everywhere: in a furnace that is the solution.
  const double sky = data_.world.sky();
  for (std::size_t n = 0; n < moments_size_; n += data_.moment_count()) x_[n] = std::sqrt(4 * kPi) * sky;
  std::fill(x_.begin() + static_cast<std::ptrdiff_t>(moments_size_), x_.end(), sky);
  iterate(progress);
  finish();
}

}  // namespace obscura::detail
