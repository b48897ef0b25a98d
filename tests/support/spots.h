// Dense rays through a spot: what the conservative query is held against.
#pragma once

#include <algorithm>
#include <vector>

#include "photon/spot/spot.h"
#include "photon/world/world.h"

namespace obscura::test {

/// A pinhole's spot of given half widths (tangents) about a direction.
inline Spot pinhole_spot(const Vec3d& eye, const Vec3d& toward, double half_width, double half_height,
                         double turn = 0) {
  const Vec3d axis = toward.normalized();
  const auto [a0, b0] = orthonormal_basis(axis);
  const Vec3d a = std::cos(turn) * a0 + std::sin(turn) * b0, b = std::cos(turn) * b0 - std::sin(turn) * a0;
  Spot spot;
  spot.corners[0] = {eye, (axis - half_width * a - half_height * b).normalized(), 0, kInfinity};
  spot.corners[1] = {eye, (axis + half_width * a - half_height * b).normalized(), 0, kInfinity};
  spot.corners[2] = {eye, (axis + half_width * a + half_height * b).normalized(), 0, kInfinity};
  spot.corners[3] = {eye, (axis - half_width * a + half_height * b).normalized(), 0, kInfinity};
  return spot;
}

/// Parallel rays over a parallelogram of half sides a and b.
inline Spot parallel_spot(const Vec3d& middle, const Vec3d& direction, const Vec3d& a, const Vec3d& b) {
  Spot spot;
  spot.corners[0] = {middle - a - b, direction, 0, kInfinity};
  spot.corners[1] = {middle + a - b, direction, 0, kInfinity};
  spot.corners[2] = {middle + a + b, direction, 0, kInfinity};
  spot.corners[3] = {middle - a + b, direction, 0, kInfinity};
  return spot;
}

/// A ray of the spot: x and y in [0, 1] between the corners.
inline Ray ray_in(const Spot& spot, double x, double y) {
  // Planar rectangles: directions scaled to one plane mix linearly.
  const Vec3d axis =
      (spot.corners[0].direction + spot.corners[1].direction + spot.corners[2].direction + spot.corners[3].direction)
          .normalized();
  Vec3d origin(0), direction(0);
  const double weight[4] = {(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y};
  for (std::size_t i = 0; i < 4; ++i) {
    origin += weight[i] * spot.corners[i].origin;
    direction += weight[i] * spot.corners[i].direction / spot.corners[i].direction.dot(axis);
  }
  if (spot.corners[0].origin == spot.corners[1].origin) origin = spot.corners[0].origin;
  return {origin, direction.normalized(), spot.corners[0].t_min, kInfinity};
}

/// What rays have seen, summed up the plain way.
struct Views {
  std::vector<std::uint32_t> surfaces;
  std::vector<int> materials;
  std::vector<Vec3d> normals;
  double near = kInfinity, far = 0, K_low = kInfinity, K_high = -kInfinity;
  bool sky = false;

  void add(const World& world, const Ray& ray, const SurfaceHit& hit) {
    if (!hit.exists()) {
      sky = true;
      return;
    }
    if (std::find(surfaces.begin(), surfaces.end(), hit.id.surface) == surfaces.end())
      surfaces.push_back(hit.id.surface);
    Vec3d normal = world.surfaces().normal(hit.id, ray.at(hit.t));
    const bool back = normal.dot(ray.direction) > 0;
    if (back) normal = -normal;
    if (std::find(normals.begin(), normals.end(), normal) == normals.end()) normals.push_back(normal);
    int material = -2;
    double K = 0;
    if (hit.id.surface < world.objects().size()) {
      const Object& object = world.objects()[hit.id.surface];
      const std::size_t slot = object.mesh && !object.mesh->slots.empty() ? object.mesh->slots[hit.id.face] : 0;
      material = back && !object.double_sided ? -1 : object.materials[slot];
      K = material == -1 ? 0 : object.K[slot];
      if (material >= 0 && object.mesh && !object.mesh->vertex_K.empty()) {
        const auto& f = object.mesh->faces[hit.id.face];
        const auto at = [&](int corner) {
          return static_cast<double>(object.mesh->vertex_K[f[static_cast<std::size_t>(corner)]]);
        };
        K = (1 - hit.u - hit.v) * at(0) + hit.u * at(1) + hit.v * at(2);
      }
    }
    K_low = std::min(K_low, K);
    K_high = std::max(K_high, K);
    if (std::find(materials.begin(), materials.end(), material) == materials.end()) materials.push_back(material);
    near = std::min(near, hit.t);
    far = std::max(far, hit.t);
  }

  double turn() const {
    double most = 0;
    for (const Vec3d& a : normals) {
      for (const Vec3d& b : normals) most = std::max(most, 2 * std::asin(std::min(1.0, 0.5 * (a - b).length())));
    }
    return most;
  }

  /// A threshold is reached by what the rays have seen (materials that permeate are not handled).
  bool reaches(const SpotThresholds& t) const {
    const bool nothing = surfaces.empty();
    if (t.polygons && static_cast<int>(surfaces.size()) + sky >= *t.polygons) return true;
    if (t.materials && static_cast<int>(materials.size()) + sky >= *t.materials) return true;
    if (t.normal && turn() > *t.normal) return true;
    if (t.depth && !nothing && far - near > *t.depth * near) return true;
    return t.temperature_K && !nothing && K_high - K_low > *t.temperature_K;
  }
};

/// side x side rays over the whole spot, its border included.
inline Views look_through(const World& world, const Spot& spot, int side) {
  Views views;
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const Ray ray = ray_in(spot, static_cast<double>(i) / (side - 1), static_cast<double>(j) / (side - 1));
      views.add(world, ray, world.surfaces().intersect(ray));
    }
  }
  return views;
}

}  // namespace obscura::test
