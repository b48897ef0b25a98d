#include "scene/meshes/mesh_shapes.h"

#include <catch2/catch.hpp>

using namespace obscura;

namespace {

Vec3d normal_of(const Mesh& mesh, const std::array<std::uint32_t, 3>& f) {
  return 0.5 * (mesh.vertices[f[1]] - mesh.vertices[f[0]]).cross(mesh.vertices[f[2]] - mesh.vertices[f[0]]);
}

}  // namespace

TEST_CASE("a plane lies in z = 0 and faces up", "[scene][shapes]") {
  const Mesh mesh = plane_mesh({4, 2});
  double area = 0;
  for (const auto& face : mesh.faces) {
    CHECK(normal_of(mesh, face).z > 0);
    area += normal_of(mesh, face).length();
  }
  CHECK(area == Approx(8));
  Box3d box;
  for (const Vec3d& vertex : mesh.vertices) box.extendBy(vertex);
  CHECK(box.min == Vec3d(-2, -1, 0));
  CHECK(box.max == Vec3d(2, 1, 0));
}

TEST_CASE("a box is closed and faces outward", "[scene][shapes]") {
  const Mesh mesh = box_mesh({1, 2, 3});
  CHECK(mesh.faces.size() == 12);
  double area = 0, volume = 0;
  Vec3d sum(0);
  for (const auto& face : mesh.faces) {
    const Vec3d normal = normal_of(mesh, face);
    area += normal.length();
    volume += normal.dot(mesh.vertices[face[0]]) / 3;
    sum += normal;
  }
  CHECK(area == Approx(2 * (2 + 3 + 6)));
  CHECK(volume == Approx(6));  // below 0 for a face that looks inward
  CHECK(sum.length() < 1e-12);
}
