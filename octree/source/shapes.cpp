// Shapes as voxels: a descent through cubes that finds the uniform ones, and exact cell means at the border.
#include "octree/source/shapes.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "octree/base/error.h"

namespace obscura {
namespace {

/// Abscissae on (-1, 1) and weights of the 12-point Gauss-Legendre rule (Abramowitz & Stegun, table 25.4).
constexpr std::array<std::pair<double, double>, 6> kGauss12{{
    {0.125233408511468915, 0.249147045813402785},
    {0.367831498998180194, 0.233492536538354809},
    {0.587317954286617447, 0.203167426723065922},
    {0.769902674194304687, 0.160078328543346226},
    {0.904117256370474857, 0.106939325995318431},
    {0.981560634246719251, 0.047175336386511827},
}};

/// Integral over [a, b] of a function that is smooth inside and may have roots' kinks at its ends:
/// x = 10u^3 - 15u^4 + 6u^5 flattens them before the Gauss rule. Long intervals take four panels.
template <class F>
double integrate(double a, double b, F&& f) noexcept {
  const int panels = b - a > 0.1 ? 4 : 1;
  double sum = 0;
  for (int panel = 0; panel < panels; ++panel)
    for (const auto& [node, weight] : kGauss12)
      for (const double side : {-1.0, 1.0}) {
        const double u = (panel + 0.5 + 0.5 * side * node) / panels;
        const double slope = 30 * u * u * (1 - u) * (1 - u);
        sum += 0.5 * weight * slope * f(a + (b - a) * u * u * u * (10 - 15 * u + 6 * u * u));
      }
  return (b - a) * sum / panels;
}

/// Area of the disc of radius r inside [0,a] x [0,b]; odd in a and in b.
double disc_in_corner(double a, double b, double r) noexcept {
  const double sign = (a < 0) == (b < 0) ? 1 : -1;
  a = std::min(std::abs(a), r);
  b = std::min(std::abs(b), r);
  if (a * a + b * b <= r * r) return sign * a * b;
  return sign * 0.5 *
         (a * std::sqrt(r * r - a * a) + b * std::sqrt(r * r - b * b) +
          r * r * (std::asin(a / r) + std::asin(b / r) - kPi / 2));
}

enum class Fill { empty, full, mixed };

/// Pours a lattice of `resolution` cells: whole cubes where `fill` knows them, cell by cell elsewhere.
template <class FillOf, class CellOf>
void pour_cells(const VoxelSink& sink, const Vec3i& resolution, FillOf&& fill_of, CellOf&& cell_of) {
  // Divides one cube over everything until cubes are uniform or bricks.
  struct Cube {
    Vec3i corner;
    int level;
  };
  int top = 3;
  while ((1 << top) < std::max({resolution.x, resolution.y, resolution.z})) ++top;
  std::vector<Cube> open{{Vec3i(0), top}};
  std::vector<Vec3i> bricks;
  const float one = 1;
  while (!open.empty()) {
    const Cube cube = open.back();
    open.pop_back();
    if (cube.corner.x >= resolution.x || cube.corner.y >= resolution.y || cube.corner.z >= resolution.z) continue;
    const Fill fill = fill_of(cube.corner, cube.corner + Vec3i(1 << cube.level));
    if (fill == Fill::empty) continue;
    if (fill == Fill::full) {
      sink.tile(cube.corner, cube.level, {&one, 1});
    } else if (cube.level == 3) {
      bricks.push_back(cube.corner);
    } else {
      const int half = 1 << (cube.level - 1);
      for (int child = 0; child < 8; ++child)
        open.push_back({cube.corner + Vec3i(child & 1, (child >> 1) & 1, child >> 2) * half, cube.level - 1});
    }
  }

  tbb::parallel_for(std::size_t{0}, bricks.size(), [&](std::size_t i) {
    std::array<float, 512> values;
    for (int v = 0; v < 512; ++v) {
      const Vec3i cell = bricks[i] + Vec3i(v & 7, (v >> 3) & 7, v >> 6);
      const bool inside = cell.x < resolution.x && cell.y < resolution.y && cell.z < resolution.z;
      values[v] = inside ? static_cast<float>(cell_of(cell)) : 0.0f;
    }
    const float* pointer = values.data();
    sink.brick(bricks[i], &pointer);
  });
}

void require_length(const char* what, double value) {
  if (!(value > 0) || !std::isfinite(value))
    throw InputError(what, fmt::format("is {}", value), "must be a positive length in metres");
}

/// Cells along an axis: enough to hold the size, and no more where the voxel divides it up to rounding.
int cells_along(double size_m, double voxel_m) {
  const double cells = size_m / voxel_m;
  if (!(cells < 1 << 20))
    throw InputError("voxel_m", fmt::format("{} m gives {:.3g} cells along an axis", voxel_m, cells),
                     fmt::format("at most {} are possible; take a larger voxel", 1 << 20));
  return std::max(1, static_cast<int>(std::ceil(cells * (1 - 1e-12))));
}

VoxelStream centred_stream(std::string name, const Vec3i& resolution, double voxel_m) {
  VoxelStream stream;
  stream.name = std::move(name);
  stream.channels = {"density"};
  stream.background = {0.0f};
  stream.bounds = Box3i(Vec3i(0), resolution);
  stream.index_to_local.setScale(voxel_m);
  const Vec3d shift = Vec3d(resolution) * (-0.5 * voxel_m);
  for (int axis = 0; axis < 3; ++axis) stream.index_to_local[3][axis] = shift[axis];
  return stream;
}

/// The part of cell i that lies in a centred interval of `size` cells on an axis of n cells.
std::pair<double, double> overlap(int i, int n, double size) noexcept {
  const double centre = 0.5 * n;
  return {std::max<double>(i, centre - 0.5 * size) - centre, std::min<double>(i + 1, centre + 0.5 * size) - centre};
}

}  // namespace

namespace detail {

double unit_sphere_in_box(const Vec3d& low, const Vec3d& high) noexcept {
  const double bottom = std::max(low.z, -1.0);
  const double top = std::min(high.z, 1.0);
  if (!(bottom < top)) return 0;

  // Slices at height z are discs; the area inside the rectangle has kinks where the disc's edge
  // passes a side or a corner of it.
  std::array<double, 18> knots{bottom, top};
  int count = 2;
  const auto add_knot = [&](double distance2) {
    if (distance2 >= 1) return;
    const double z = std::sqrt(1 - distance2);
    for (const double knot : {-z, z})
      if (knot > bottom && knot < top) knots[count++] = knot;
  };
  for (const double x : {low.x, high.x}) add_knot(x * x);
  for (const double y : {low.y, high.y}) add_knot(y * y);
  for (const double x : {low.x, high.x})
    for (const double y : {low.y, high.y}) add_knot(x * x + y * y);
  std::sort(knots.begin(), knots.begin() + count);

  const auto area = [&](double z) noexcept {
    const double r = std::sqrt(std::max(0.0, 1 - z * z));
    if (r == 0) return 0.0;
    return disc_in_corner(high.x, high.y, r) - disc_in_corner(low.x, high.y, r) - disc_in_corner(high.x, low.y, r) +
           disc_in_corner(low.x, low.y, r);
  };
  double volume = 0;
  for (int i = 0; i + 1 < count; ++i)
    if (knots[i] < knots[i + 1]) volume += integrate(knots[i], knots[i + 1], area);
  return volume;
}

}  // namespace detail

VoxelStream sphere_stream(double radius_m, double voxel_m) {
  require_length("radius_m", radius_m);
  require_length("voxel_m", voxel_m);
  const int n = cells_along(2 * radius_m, voxel_m);
  VoxelStream stream = centred_stream("sphere", Vec3i(n), voxel_m);

  const double cell = voxel_m / radius_m;  // in radii
  const double centre = 0.5 * n;
  stream.pour = [n, cell, centre](const VoxelSink& sink) {
    const auto fill_of = [=](const Vec3i& low, const Vec3i& high) {
      double nearest2 = 0, farthest2 = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const double a = (low[axis] - centre) * cell;
        const double b = (high[axis] - centre) * cell;
        const double near = a > 0 ? a : b < 0 ? b : 0;
        const double far = std::max(std::abs(a), std::abs(b));
        nearest2 += near * near;
        farthest2 += far * far;
      }
      return farthest2 <= 1 ? Fill::full : nearest2 >= 1 ? Fill::empty : Fill::mixed;
    };
    const auto cell_of = [=](const Vec3i& corner) {
      const Fill fill = fill_of(corner, corner + Vec3i(1));
      if (fill != Fill::mixed) return fill == Fill::full ? 1.0 : 0.0;
      // Folded into one octant, so that the sphere is symmetric to the last bit.
      Vec3d low, high;
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = (corner[axis] - centre) * cell;
        high[axis] = (corner[axis] + 1 - centre) * cell;
        if (high[axis] <= 0) low[axis] = -std::exchange(high[axis], -low[axis]);
      }
      return std::clamp(detail::unit_sphere_in_box(low, high) / (cell * cell * cell), 0.0, 1.0);
    };
    pour_cells(sink, Vec3i(n), fill_of, cell_of);
  };
  return stream;
}

VoxelStream box_stream(const Vec3d& size_m, double voxel_m) {
  require_length("voxel_m", voxel_m);
  Vec3i resolution;
  Vec3d size;  // in cells
  for (int axis = 0; axis < 3; ++axis) {
    require_length("size_m", size_m[axis]);
    resolution[axis] = cells_along(size_m[axis], voxel_m);
    size[axis] = size_m[axis] / voxel_m;
    // Where the voxel divides the size up to rounding there are no border cells.
    if (std::abs(size[axis] - resolution[axis]) < 1e-9 * size[axis]) size[axis] = resolution[axis];
  }
  VoxelStream stream = centred_stream("box", resolution, voxel_m);
  stream.pour = [resolution, size](const VoxelSink& sink) {
    const auto fill_of = [=](const Vec3i& low, const Vec3i& high) {
      for (int axis = 0; axis < 3; ++axis) {
        const double centre = 0.5 * resolution[axis];
        if (low[axis] < centre - 0.5 * size[axis] || high[axis] > centre + 0.5 * size[axis]) return Fill::mixed;
      }
      return Fill::full;
    };
    const auto cell_of = [=](const Vec3i& cell) {
      double fraction = 1;
      for (int axis = 0; axis < 3; ++axis) {
        const auto [low, high] = overlap(cell[axis], resolution[axis], size[axis]);
        fraction *= std::clamp(high - low, 0.0, 1.0);
      }
      return fraction;
    };
    pour_cells(sink, resolution, fill_of, cell_of);
  };
  return stream;
}

VoxelStream gaussian_stream(double sigma_m, const Vec3d& size_m, double voxel_m) {
  require_length("sigma_m", sigma_m);
  require_length("voxel_m", voxel_m);
  Vec3i resolution;
  for (int axis = 0; axis < 3; ++axis) {
    require_length("size_m", size_m[axis]);
    resolution[axis] = cells_along(size_m[axis], voxel_m);
  }
  // The Gaussian is a product, and so is its mean over a cell: one table per axis.
  // integral of exp(-x^2 / 2 s^2) over [a, b] = s sqrt(pi/2) (erf(b / s sqrt 2) - erf(a / s sqrt 2))
  std::array<std::vector<double>, 3> means;
  const double sigma = sigma_m / voxel_m;
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < resolution[axis]; ++i) {
      auto [a, b] = overlap(i, resolution[axis], size_m[axis] / voxel_m);
      if (b <= 0) a = -std::exchange(b, -a);
      const double scale = 1 / (sigma * std::numbers::sqrt2);
      // erfc keeps the digits of the far tail.
      const double difference =
          a >= 0 ? std::erfc(a * scale) - std::erfc(b * scale) : std::erf(b * scale) - std::erf(a * scale);
      means[axis].push_back(b > a ? sigma * std::sqrt(kPi / 2) * difference : 0.0);
    }
  VoxelStream stream = centred_stream("gaussian", resolution, voxel_m);
  stream.pour = [resolution, means](const VoxelSink& sink) {
    pour_cells(
        sink, resolution, [](const Vec3i&, const Vec3i&) { return Fill::mixed; },
        [&](const Vec3i& cell) { return means[0][cell.x] * means[1][cell.y] * means[2][cell.z]; });
  };
  return stream;
}

}  // namespace obscura
