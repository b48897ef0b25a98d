// What discrete ordinates start from: emission, first collisions, and light from surfaces beyond the grid.
#include <tbb/parallel_for.h>

#include "photon/optics/purpose.h"
#include "photon/ordinates/ordinates_solver.h"

namespace obscura::detail {

void OrdinatesSolver::make_sources() {
  external_.assign(moments_size_, 0.0);
  add_first_collisions(data_, external_);
  const double air = data_.world.air_extinction() * data_.world.air_radiance();
  const double volume = data_.grid.cell_volume(), isotropic = std::sqrt(4 * kPi);
  for (std::size_t cell = 0; cell < data_.grid.size(); ++cell) {
    const double emission = data_.grid.emission[cell] + air;
    data_.powers.emitted += 4 * kPi * emission * volume;
    for (std::size_t c = 0; c < 8; ++c) external_[(8 * cell + c) * data_.moment_count()] += isotropic * emission;
  }
}

void OrdinatesSolver::look_outside() {
  const SpectralWorld world = data_.world;
  const OrdinatesGrid& grid = data_.grid;
  const Vec3d extent = grid.extent_m();
  bool beyond = false;
  for (const Object& object : world->objects()) {
    const Box3d box = transform_box(grid.world_to_grid(), bounds_of(object));
    for (int a = 0; a < 3; ++a)
      beyond = beyond || box.min[a] < -1e-6 * extent[a] || box.max[a] > (1 + 1e-6) * extent[a];
  }
  if (!beyond) return;
  const Vec3i n = grid.cells();
  const auto count = static_cast<std::size_t>(data_.angles.ordinates);
  for (int axis = 0; axis < 3; ++axis) {
    const int first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
    Vector& enter = outside_[static_cast<std::size_t>(axis)];
    enter.assign(boundary_size(data_.angles, n, axis), world.sky());
    const int rows = n[first] * n[second];
    tbb::parallel_for(0, 8 * rows, [&](int task) {
      const int octant = task / rows, u = task % rows % n[first], v = task % rows / n[first];
      Vec3d point;
      point[axis] = octant >> axis & 1 ? extent[axis] : 0.0;
      point[first] = ((octant >> first & 1 ? n[first] - 1 - u : u) + 0.5) * grid.cell_m()[first];
      point[second] = ((octant >> second & 1 ? n[second] - 1 - v : v) + 0.5) * grid.cell_m()[second];
      const Vec3d from = transform_point(grid.grid_to_world(), point);
      for (int o = 0; o < data_.set.per_octant(); ++o) {
        const Ray ray{from, -transform_direction(grid.grid_to_world(), data_.set.direction(octant, o)), 0, kInfinity};
        Stream stream = StreamName{}.stream();
        const SurfaceHit hit = world->meet(ray, {}, stream);
        if (!hit.exists()) continue;
        const SurfacePoint at = world.surface_at(ray, hit);
        const double radiance = at.emission(at.cosine) + data_.reflected_far(at);
        for (std::size_t c = 0; c < 4; ++c)
          enter[(static_cast<std::size_t>(task) * 4 + c) * count + static_cast<std::size_t>(o)] = radiance;
      }
    });
  }
}

}  // namespace obscura::detail
