#include "photon/ordinates/ordinates_diffusion.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace obscura::detail {
namespace {

/// The inner solution: exact enough that the outer iteration does not notice.
constexpr double kInnerTolerance = 1e-4;
constexpr int kMostInner = 400;

double dot(const std::vector<double>& a, const std::vector<double>& b) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// Eigenvalues and the rotation of a symmetric 2x2 matrix ((a, -c), (-c, a)): (1, 1) and (1, -1).
struct Pair {
  double even, odd;
};

}  // namespace

DiffusionCorrection::DiffusionCorrection(const Vec3i& cells, const Vec3d& cell_m, const std::array<bool, 3>& periodic,
                                         std::vector<double> absorption, std::vector<double> transport)
    : cells_(cells),
      cell_m_(cell_m),
      periodic_(periodic),
      absorption_(std::move(absorption)),
      diffusion_(std::move(transport)) {
  // Where hardly anything scatters light flies across: it spreads no farther than about the grid.
  const double widest = std::max({cells.x * cell_m.x, cells.y * cell_m.y, cells.z * cell_m.z});
  for (double& d : diffusion_) d = 1 / (3 * std::max(d, 0.5 / widest));
  for (int a = 0; a < 3; ++a) vertices_[a] = cells[a] + (periodic[static_cast<std::size_t>(a)] ? 0 : 1);
  assemble();
}

std::size_t DiffusionCorrection::vertex(int i, int j, int k) const noexcept {
  return static_cast<std::size_t>(((k % vertices_.z) * vertices_.y + j % vertices_.y) * vertices_.x + i % vertices_.x);
}

void DiffusionCorrection::assemble() {
  const auto count = static_cast<std::size_t>(vertices_.x) * static_cast<std::size_t>(vertices_.y) *
                     static_cast<std::size_t>(vertices_.z);
  diagonal_.assign(count, 0.0);
  for (std::size_t a = 0; a < 3; ++a) {
    link_[a].assign(count, 0.0);
    next_[a].resize(count);
    for (std::size_t v = 0; v < count; ++v) next_[a][v] = v;
  }
  corner_.resize(8 * absorption_.size());
  const double eighth = cell_m_.x * cell_m_.y * cell_m_.z / 8;
  std::size_t cell = 0;
  for (int k = 0; k < cells_.z; ++k) {
    for (int j = 0; j < cells_.y; ++j) {
      for (int i = 0; i < cells_.x; ++i, ++cell) {
        for (int c = 0; c < 8; ++c) {
          const Vec3i at(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
          const std::size_t v = vertex(at.x, at.y, at.z);
          corner_[8 * cell + static_cast<std::size_t>(c)] = v;
          diagonal_[v] += absorption_[cell] * eighth;
          for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            const double quarter = 2 * eighth / cell_m_[axis];
            if (!(c >> axis & 1)) {
              Vec3i up = at;
              up[axis] += 1;
              const std::size_t w = vertex(up.x, up.y, up.z);
              if (w == v) continue;
              next_[a][v] = w;
              const double link = diffusion_[cell] * quarter / cell_m_[axis];
              link_[a][v] += link;
              diagonal_[v] += link;
              diagonal_[w] += link;
            }
            // Marshak: half of the fluence leaves through the border.
            if (!periodic_[a] && (at[axis] == 0 || at[axis] == cells_[axis])) diagonal_[v] += 0.5 * quarter;
          }
        }
      }
    }
  }
  // Where nothing leaves or is absorbed the matrix is singular; a trace of absorption makes it regular.
  for (double& d : diagonal_) d *= 1 + 1e-12;
  // Modified incomplete factors (Gustafsson, BIT 18, 1978), without the links across a period.
  pivot_ = diagonal_;
  for (std::size_t v = 0; v < count; ++v) {
    double whole = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      if (next_[a][v] > v) whole += link_[a][v];
    }
    pivot_[v] = std::max(pivot_[v], 1e-3 * diagonal_[v]);
    for (std::size_t a = 0; a < 3; ++a) {
      if (next_[a][v] <= v) continue;
      const double link = link_[a][v];
      pivot_[next_[a][v]] -= link * (link + 0.95 * (whole - link)) / pivot_[v];
    }
  }
  for (auto* v : {&x_, &b_, &r_, &z_, &p_, &q_}) v->assign(count, 0.0);
}

void DiffusionCorrection::multiply(const std::vector<double>& x, std::vector<double>& y) const {
  for (std::size_t v = 0; v < x.size(); ++v) y[v] = diagonal_[v] * x[v];
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t v = 0; v < x.size(); ++v) {
      const std::size_t w = next_[a][v];
      y[v] -= link_[a][v] * x[w];
      y[w] -= link_[a][v] * x[v];
    }
  }
}

void DiffusionCorrection::precondition(const std::vector<double>& r, std::vector<double>& z) const {
  const std::size_t count = r.size();
  z = r;
  for (std::size_t v = 0; v < count; ++v) {
    const double scaled = z[v] / pivot_[v];
    for (std::size_t a = 0; a < 3; ++a) {
      if (next_[a][v] > v) z[next_[a][v]] += link_[a][v] * scaled;
    }
  }
  for (std::size_t v = count; v-- > 0;) {
    double sum = z[v];
    for (std::size_t a = 0; a < 3; ++a) {
      if (next_[a][v] > v) sum += link_[a][v] * z[next_[a][v]];
    }
    z[v] = sum / pivot_[v];
  }
}

void DiffusionCorrection::solve() {
  std::fill(x_.begin(), x_.end(), 0.0);
  r_ = b_;
  const double goal = kInnerTolerance * kInnerTolerance * dot(b_, b_);
  if (!(goal > 0)) return;
  precondition(r_, z_);
  p_ = z_;
  double rz = dot(r_, z_);
  for (int step = 0; step < kMostInner; ++step) {
    multiply(p_, q_);
    const double curvature = dot(p_, q_);
    if (!(curvature > 0)) return;
    const double alpha = rz / curvature;
    for (std::size_t v = 0; v < x_.size(); ++v) {
      x_[v] += alpha * p_[v];
      r_[v] -= alpha * q_[v];
    }
    if (dot(r_, r_) <= goal) return;
    precondition(r_, z_);
    const double next = dot(r_, z_);
    const double beta = next / rz;
    rz = next;
    for (std::size_t v = 0; v < x_.size(); ++v) p_[v] = z_[v] + beta * p_[v];
  }
}

void DiffusionCorrection::correct(const std::vector<double>& source, std::vector<double>& fluence) {
  const double eighth = cell_m_.x * cell_m_.y * cell_m_.z / 8;
  std::fill(b_.begin(), b_.end(), 0.0);
  for (std::size_t n = 0; n < source.size(); ++n) b_[corner_[n]] += eighth * source[n];
  solve();
  tbb::parallel_for(std::size_t{0}, absorption_.size(), [&](std::size_t cell) {
    // The cell by itself, its corners as unknowns: a sum of one matrix for each axis, whose eigenvectors are
    // the sum and difference of the corners.
    Pair axis[3];
    for (int a = 0; a < 3; ++a) {
      const double h = cell_m_[a];
      const double leak = std::max(0.25, diffusion_[cell] / h);
      const bool uniform = periodic_[static_cast<std::size_t>(a)] && cells_[a] == 1;
      axis[a] = uniform ? Pair{0, 0} : Pair{2 * leak / h, 2 * (leak + diffusion_[cell] / h) / h};
    }
    double v[8];
    for (std::size_t c = 0; c < 8; ++c) v[c] = source[8 * cell + c];
    const auto butterfly = [&v](std::size_t bit) {
      for (std::size_t c = 0; c < 8; ++c) {
        if (c & bit) continue;
        const double a = v[c], b = v[c | bit];
        v[c] = a + b;
        v[c | bit] = a - b;
      }
    };
    for (const std::size_t bit : {1U, 2U, 4U}) butterfly(bit);
    for (std::size_t c = 0; c < 8; ++c) {
      const double value = absorption_[cell] + (c & 1 ? axis[0].odd : axis[0].even) +
                           (c & 2 ? axis[1].odd : axis[1].even) + (c & 4 ? axis[2].odd : axis[2].even);
      v[c] = value > 0 ? v[c] / (8 * value) : 0.0;
    }
    for (const std::size_t bit : {1U, 2U, 4U}) butterfly(bit);
    for (std::size_t c = 0; c < 8; ++c) fluence[8 * cell + c] = x_[corner_[8 * cell + c]] + v[c];
  });
}

}  // namespace obscura::detail
