// Surfaces for tests: squares, boxes and spheres in one grey band.
#pragma once

#include <memory>

#include "photon/world/world.h"

namespace obscura::test {

/// A parallelogram from its corner, front towards u x v.
inline std::shared_ptr<Mesh> parallelogram(const Vec3d& corner, const Vec3d& u, const Vec3d& v) {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {corner, corner + u, corner + u + v, corner + v};
  mesh->faces = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

/// A sheet of 2 n n triangles, facing up where i goes along x and j along y: place(i, j) for i and j from 0 to n.
template <class Place>
std::shared_ptr<Mesh> sheet_mesh(std::uint32_t n, const Place& place) {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices.reserve(std::size_t{n + 1} * (n + 1));
  mesh->faces.reserve(std::size_t{2} * n * n);
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i) mesh->vertices.push_back(place(i, j));
  }
  const auto at = [n](std::uint32_t i, std::uint32_t j) { return j * (n + 1) + i; };
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      mesh->faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh->faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

/// A closed box, its fronts inward or outward.
inline std::shared_ptr<Mesh> box_mesh(const Vec3d& low, const Vec3d& high, bool inward) {
  auto mesh = std::make_shared<Mesh>();
  for (int i = 0; i < 8; ++i) {
    mesh->vertices.push_back({i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
  }
  const std::array<std::array<std::uint32_t, 4>, 6> outward = {
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& q : outward) {
    if (inward) {
      mesh->faces.push_back({q[0], q[2], q[1]});
      mesh->faces.push_back({q[0], q[3], q[2]});
    } else {
      mesh->faces.push_back({q[0], q[1], q[2]});
      mesh->faces.push_back({q[0], q[2], q[3]});
    }
  }
  return mesh;
}

/// An object of the World's material `material`, with a black body's radiance in the one grey band.
inline Object grey_object(std::shared_ptr<const Mesh> mesh, int material, double radiance) {
  Object object;
  object.mesh = std::move(mesh);
  object.materials = {material};
  object.radiance = {radiance};
  return object;
}

inline Object grey_sphere(const Vec3d& center, double radius, int material, double radiance) {
  Object object = grey_object(nullptr, material, radiance);
  object.radius = radius;
  object.local_to_world = placement(center, Vec3d(0), 1);
  return object;
}

inline Material grey_material(double emissivity, double specular = 0, double roughness = 0) {
  Material material;
  material.emissivity = {emissivity};
  material.specular = specular;
  material.roughness = roughness;
  return material;
}

/// Nothing but one grey band and a sky.
inline WorldContents empty_contents(double sky = 0) {
  WorldContents contents;
  contents.bands.emplace_back("grey");
  contents.sky = {sky};
  return contents;
}

}  // namespace obscura::test
