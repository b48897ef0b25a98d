// What tests of mesh files share: faces, their normals, and what is said of files that are broken.
#pragma once

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <string>

#include "octree/base/error.h"
#include "scene/meshes/mesh_io.h"

namespace obscura::test {

using Face = std::array<std::uint32_t, 3>;

inline Vec3d normal_of(const Mesh& mesh, std::size_t face) {
  const Face& f = mesh.faces[face];
  return (mesh.vertices[f[1]] - mesh.vertices[f[0]]).cross(mesh.vertices[f[2]] - mesh.vertices[f[0]]);
}

/// Reads what is no mesh, and looks at what is said.
inline void check_refused(const std::filesystem::path& file, const std::string& where, const std::string& says) {
  try {
    read_mesh(file);
    FAIL_CHECK(file << " was read; expected: " << says);
  } catch (const InputError& error) {
    INFO(error.what());
    REQUIRE(error.problems().size() == 1);
    const Problem& problem = error.problems()[0];
    CHECK(problem.where == file.string() + where);
    CHECK(problem.problem.find(says) != std::string::npos);
    CHECK_FALSE(problem.hint.empty());
  }
}

inline const std::string kTetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";

}  // namespace obscura::test
