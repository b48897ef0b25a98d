#include "photon/ordinates/ordinates_surfaces.h"

#include <algorithm>

#include "photon/optics/purpose.h"

namespace obscura {
namespace {

/// Rays between the middles of cells start this share of a cell beside them, where a surface hardly ever lies exactly.
constexpr double kBeside = 1.1e-4;

std::size_t face_index(const Vec3i& face, Vec3i size, int axis) noexcept {
  size[axis] += 1;
  return static_cast<std::size_t>((face.z * size.y + face.y) * size.x + face.x);
}

}  // namespace

OrdinatesSurfaces::OrdinatesSurfaces(SpectralWorld world, const OrdinatesGrid& grid) {
  if (world->surfaces().empty()) return;
  touched.assign(grid.size(), false);
  const Vec3i n = grid.cells();
  const Vec3d h = grid.cell_m();
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<std::int32_t>& numbers = faces[static_cast<std::size_t>(axis)];
    Vec3i count = n;
    count[axis] += 1;
    numbers.assign(
        static_cast<std::size_t>(count.x) * static_cast<std::size_t>(count.y) * static_cast<std::size_t>(count.z), -1);
    Vec3i face;
    for (face.z = 0; face.z < count.z; ++face.z) {
      for (face.y = 0; face.y < count.y; ++face.y) {
        for (face.x = 0; face.x < count.x; ++face.x) {
          Vec3d above, below;
          for (int a = 0; a < 3; ++a) above[a] = below[a] = (face[a] + 0.5 + kBeside) * h[a];
          below[axis] -= h[axis];
          const Vec3d low = transform_point(grid.grid_to_world(), below),
                      high = transform_point(grid.grid_to_world(), above);
          const Vec3d up = (high - low).normalized();
          std::array<OrdinatesSide, 2> pair;
          int met = 0;
          for (const bool looks_up : {false, true}) {
            const Ray ray{looks_up ? high : low, looks_up ? -up : up, 0, h[axis]};
            Stream stream = StreamName{}.stream();
            const SurfaceHit hit = world->meet(ray, {}, stream);
            OrdinatesSide& side = pair[looks_up ? 1 : 0];
            side.axis = axis;
            side.cell = face;
            if (!looks_up) side.cell[axis] -= 1;
            side.inside = side.cell[axis] >= 0 && side.cell[axis] < n[axis];
            if (!hit.exists()) continue;
            ++met;
            const SurfacePoint at = world.surface_at(ray, hit);
            side.id = at.id;
            side.position = at.position;
            side.normal = at.normal;
            if (!side.inside) continue;
            const double emissivity = at.material ? at.material->hemispherical_emissivity() : 1.0;
            side.emission = emissivity * at.black;
            side.reflectance = 1 - emissivity;
          }
          if (met == 0) continue;
          numbers[face_index(face, n, axis)] = static_cast<std::int32_t>(sides.size() / 2);
          sides.insert(sides.end(), pair.begin(), pair.end());
          for (const OrdinatesSide& side : pair) {
            if (side.inside) touched[grid.index(side.cell)] = true;
          }
        }
      }
    }
  }
}

const OrdinatesSide* OrdinatesSurfaces::nearest(const OrdinatesGrid& grid, const Vec3d& world_point,
                                                const Vec3d& world_normal) const noexcept {
  const Vec3d point = transform_point(grid.world_to_grid(), world_point),
              normal = transform_direction(grid.world_to_grid(), world_normal);
  const Vec3i n = grid.cells();
  const Vec3d h = grid.cell_m();
  Vec3i middle;
  for (int a = 0; a < 3; ++a) middle[a] = static_cast<int>(std::floor(point[a] / h[a]));
  const OrdinatesSide* best = nullptr;
  double best_score = -1.5;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<std::int32_t>& numbers = faces[static_cast<std::size_t>(axis)];
    if (numbers.empty()) continue;
    for (int k = -1; k <= 2; ++k) {
      for (int j = -1; j <= 2; ++j) {
        for (int i = -1; i <= 2; ++i) {
          const Vec3i face = middle + Vec3i(i, j, k);
          bool exists = true;
          double distance2 = 0;
          for (int a = 0; a < 3; ++a) {
            exists = exists && face[a] >= 0 && face[a] < n[a] + (a == axis ? 1 : 0);
            const double away = point[a] / h[a] - (face[a] + (a == axis ? 0.0 : 0.5));
            distance2 += away * away;
          }
          if (!exists) continue;
          const std::int32_t number = numbers[face_index(face, n, axis)];
          if (number < 0) continue;
          const OrdinatesSide& side = sides[2 * static_cast<std::size_t>(number) + (normal[axis] > 0 ? 1 : 0)];
          const double score = std::abs(normal[axis]) - std::sqrt(distance2);
          if (side.inside && side.id.exists() && side.normal.dot(world_normal) > 0.3 && score > best_score) {
            best_score = score;
            best = &side;
          }
        }
      }
    }
  }
  return best;
}

}  // namespace obscura
