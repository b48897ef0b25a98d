#include "photon/ordinates/ordinates_sweep.h"

#include <tbb/parallel_for.h>

#include <algorithm>

// Sizeless vectors cannot be in arrays; NEON serves such machines too.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "photon/ordinates/ordinates_sweep.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "photon/ordinates/ordinates_kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace obscura::detail::HWY_NAMESPACE {

void row(const RowJob& job, int j, int k) {
  job.angles->moments == 1 ? run_row<true>(job, j, k) : run_row<false>(job, j, k);
}

}  // namespace obscura::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace obscura::detail {
namespace {

HWY_EXPORT(row);

/// Work below which a diagonal of rows is not worth dealing out to threads, in cells times ordinates.
constexpr int kWorthThreads = 2000;

/// Faces across an axis, rows counted with the first of the other two axes fastest.
std::size_t face_count(const Vec3i& cells, int axis) noexcept {
  const int a = axis == 0 ? 1 : 0, b = axis == 2 ? 1 : 2;
  return static_cast<std::size_t>(cells[a]) * static_cast<std::size_t>(cells[b]);
}

/// Surface on a face of the grid, or none; the face is counted in grid cells.
std::int32_t surface_on(const SweepArrays& arrays, const Vec3i& face, int axis) noexcept {
  const std::int32_t* const numbers = arrays.surface[static_cast<std::size_t>(axis)];
  if (!numbers) return -1;
  Vec3i size = arrays.cells;
  size[axis] += 1;
  return numbers[(face.z * size.y + face.y) * size.x + face.x];
}

/// Adds what has come out of an octant's last cells to the faces of the grid that they lie at, or to the
/// surfaces there.
void sum_leaving(const RowJob& job, int axis) {
  const auto a = static_cast<std::size_t>(axis);
  const SweepArrays& arrays = *job.arrays;
  const bool downward = job.octant >> axis & 1;
  std::vector<double>* const to = arrays.leaving[a][downward ? 0 : 1];
  if (!to && !arrays.surface[a]) return;
  const Vec3i& n = arrays.cells;
  const int first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
  if (to) to->resize(face_count(n, axis));
  const auto count = static_cast<std::size_t>(job.angles->ordinates);
  for (int v = 0; v < n[second]; ++v) {
    for (int u = 0; u < n[first]; ++u) {
      Vec3i face;
      face[axis] = downward ? 0 : n[axis];
      face[first] = job.octant >> first & 1 ? n[first] - 1 - u : u;
      face[second] = job.octant >> second & 1 ? n[second] - 1 - v : v;
      const std::int32_t surface = surface_on(arrays, face, axis);
      if (!to && surface < 0) continue;
      const double* const f = job.face[a] + static_cast<std::size_t>(v * n[first] + u) * 4 * count;
      double sum = 0;
      for (std::size_t o = 0; o < count; ++o) {
        sum += job.angles->current[a][o] * 0.25 * (f[o] + f[count + o] + f[2 * count + o] + f[3 * count + o]);
      }
      if (surface >= 0) {
        arrays.surface_irradiance[2 * static_cast<std::size_t>(surface) + (downward ? 1 : 0)] += sum;
      } else {
        (*to)[static_cast<std::size_t>(face[second] * n[first] + face[first])] += sum;
      }
    }
  }
}

}  // namespace

SweepAngles::SweepAngles(const OrdinateSet& set, int moment_order, const Vec3d& cell_m,
                         const std::array<bool, 3>& uniform) {
  const int real = set.per_octant();
  ordinates = (real + kGroup - 1) / kGroup * kGroup;
  const int harmonics = (moment_order + 1) * (moment_order + 1);
  moments = harmonics == 1 ? 1 : (harmonics + kGroup - 1) / kGroup * kGroup;
  const auto count = static_cast<std::size_t>(ordinates), all = static_cast<std::size_t>(moments);
  weight.assign(count, 0.0);
  to_ordinate.assign(8 * all * count, 0.0);
  to_moment.assign(8 * all * count, 0.0);
  std::vector<double> values(static_cast<std::size_t>(harmonics));
  for (std::size_t o = 0; o < count; ++o) {
    const int i = std::min(static_cast<int>(o), real - 1);
    if (static_cast<int>(o) < real) weight[o] = set.weight(i);
    for (int octant = 0; octant < 8; ++octant) {
      spherical_harmonics(set.direction(octant, i), moment_order, values.data());
      const auto base = static_cast<std::size_t>(octant) * all * count;
      for (std::size_t m = 0; m < values.size(); ++m) {
        to_ordinate[base + m * count + o] = values[m];
        to_moment[base + o * all + m] = weight[o] * values[m];
      }
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    for (std::size_t o = 0; o < count; ++o) {
      const double cosine = set.magnitude(std::min(static_cast<int>(o), real - 1))[axis];
      inverse_path[a].push_back(uniform[a] ? 0.0 : cosine / cell_m[axis]);
      current[a].push_back(weight[o] * cosine);
    }
  }
}

std::size_t boundary_size(const SweepAngles& angles, const Vec3i& cells, int axis) noexcept {
  return 8 * face_count(cells, axis) * 4 * static_cast<std::size_t>(angles.ordinates);
}

void pass_surfaces(const RowJob& job, const Vec3i& cell, const std::array<double*, 3>& faces) noexcept {
  const SweepArrays& arrays = *job.arrays;
  const auto count = static_cast<std::size_t>(job.angles->ordinates);
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const bool downward = job.octant >> axis & 1;
    Vec3i face = cell;
    if (downward) face[axis] += 1;
    const std::int32_t surface = surface_on(arrays, face, axis);
    if (surface < 0) continue;
    // Light that goes up the axis arrives at the side that looks down and leaves from the other.
    const std::size_t arrives = 2 * static_cast<std::size_t>(surface) + (downward ? 1 : 0);
    const std::size_t leaves = 2 * static_cast<std::size_t>(surface) + (downward ? 0 : 1);
    double sum = 0;
    for (std::size_t o = 0; o < count; ++o) {
      const double* const f = faces[a] + o;
      sum += job.angles->current[a][o] * 0.25 * (f[0] + f[count] + f[2 * count] + f[3 * count]);
    }
    arrays.surface_irradiance[arrives] += sum;
    std::fill_n(faces[a], 4 * count, arrays.surface_radiance[leaves]);
  }
}

void sweep(const SweepAngles& angles, const SweepArrays& arrays, SweepScratch& scratch) {
  const Vec3i n = arrays.cells;
  RowJob job{&angles, &arrays, 0, arrays.surface[0] || arrays.surface[1] || arrays.surface[2], {}};
  for (job.octant = 0; job.octant < 8; ++job.octant) {
    // What enters the grid.
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      std::vector<double>& faces = scratch.faces[a];
      const std::size_t size = boundary_size(angles, n, axis) / 8;
      faces.resize(size);
      job.face[a] = faces.data();
      if (arrays.enter[a]) {
        std::copy_n(arrays.enter[a] + static_cast<std::size_t>(job.octant) * size, size, faces.data());
      } else {
        std::fill(faces.begin(), faces.end(), arrays.sky);
      }
    }
    // Rows on a diagonal of (y, z) do not depend on one another.
    for (int diagonal = 0; diagonal < n.y + n.z - 1; ++diagonal) {
      const int first = std::max(0, diagonal - n.z + 1), last = std::min(diagonal, n.y - 1);
      const auto one = [&](int j) { HWY_DYNAMIC_DISPATCH(row)(job, j, diagonal - j); };
      if ((last - first + 1) * n.x * angles.ordinates < kWorthThreads || first == last) {
        for (int j = first; j <= last; ++j) one(j);
      } else {
        tbb::parallel_for(first, last + 1, one);
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const std::size_t size = scratch.faces[a].size();
      sum_leaving(job, axis);
      if (arrays.leave[a])
        std::copy_n(job.face[a], size, arrays.leave[a] + static_cast<std::size_t>(job.octant) * size);
    }
  }
}

}  // namespace obscura::detail

#endif  // HWY_ONCE
