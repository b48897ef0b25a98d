#include "scene/meshes/mesh_shapes.h"

namespace obscura {

Mesh plane_mesh(const std::array<double, 2>& size_m) {
  const double x = size_m[0] / 2, y = size_m[1] / 2;
  Mesh mesh;
  mesh.vertices = {{-x, -y, 0}, {x, -y, 0}, {x, y, 0}, {-x, y, 0}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

Mesh box_mesh(const Vec3d& size_m) {
  const Vec3d h = 0.5 * size_m;
  Mesh mesh;
  // Bit 0 of a vertex's number is x, bit 1 y, bit 2 z.
  for (unsigned v = 0; v < 8; ++v) {
    mesh.vertices.emplace_back(v & 1 ? h.x : -h.x, v & 2 ? h.y : -h.y, v & 4 ? h.z : -h.z);
  }
  mesh.faces = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5},   // -x, +x
                {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},   // -y, +y
                {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};  // -z, +z
  return mesh;
}

}  // namespace obscura
