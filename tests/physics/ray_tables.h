// What the tests of ray integrals share: rows of the tables a1 to a9, columns of voxels, and rays through them.
#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/csv.h"
#include "tests/support/ray_radiance.h"
#include "tests/support/verified.h"

namespace obscura::test {

inline constexpr double kSource = 3.7;       // B of the tables
inline constexpr double kBackground = 1.25;  // I0 of the tables

inline Csv table(const char* name) { return reference_table(name); }

/// Gathers for VERIFICATION.md what the checks beside it demand.
inline Verified verified_walk(const char* file, const char* what, const char* asked) {
  return {file, "octree walk", what, asked};
}

inline double relative(double value, double reference) { return std::abs(value - reference) / std::abs(reference); }

inline Ray row_ray(const Csv& csv, std::size_t i, double t_min = 0, double t_max = kInfinity) {
  return line(Vec3d(csv.number(i, "ox"), csv.number(i, "oy"), csv.number(i, "oz")),
              Vec3d(csv.number(i, "dx"), csv.number(i, "dy"), csv.number(i, "dz")), t_min, t_max);
}

inline Affine scaled(const Vec3d& voxel_m, const Vec3d& corner_m = Vec3d(0, 0, 0)) {
  Affine map;
  map.setScale(voxel_m);
  for (int axis = 0; axis < 3; ++axis) map[3][axis] = corner_m[axis];
  return map;
}

// A column of n voxels along z, over `length` metres; f(channel, share of the way at the voxel's
// middle); `shift` moves the place of evaluation, in voxels.
template <class F>
Octree column(int n, double length, std::vector<std::string> channels, F&& f, double shift = 0) {
  return lossless(field_stream(
      Box3i(Vec3i(0, 0, 0), Vec3i(1, 1, n)), std::move(channels),
      [=](int channel, const Vec3i& v) { return static_cast<float>(f(channel, (v.z + 0.5 + shift) / n)); },
      scaled(Vec3d(1, 1, length / n))));
}

inline const Ray kUp = line(Vec3d(0.5, 0.5, -1), Vec3d(0, 0, 1));

inline auto channel(int c) {
  return [c](const Walk& w) { return static_cast<double>(w.value(c)); };
}
inline auto constant(double value) {
  return [value](const Walk&) { return value; };
}

}  // namespace obscura::test
