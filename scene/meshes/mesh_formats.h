// The readers behind read_mesh, one per kind of file, and what they share.
#pragma once

#include <map>
#include <span>

#include "scene/meshes/mesh_io.h"

namespace obscura::detail {

MeshFile read_obj(const std::filesystem::path& file);
MeshFile read_ply(const std::filesystem::path& file);
MeshFile read_stl(const std::filesystem::path& file);
MeshFile read_gltf(const std::filesystem::path& file);

/// Collects what a file holds into a MeshFile: cuts polygons, numbers faces, tells slots apart by name.
class MeshBuilder {
 public:
  explicit MeshBuilder(std::filesystem::path file) : path_(std::move(file)) {}

  std::size_t vertex_count() const noexcept { return out_.mesh.vertices.size(); }
  /// @throws InputError beyond 2^32 - 2 vertices
  void vertex(const Vec3d& position);
  /// Faces that follow have these names.
  void names(const std::vector<std::string>& names);
  /// A face of three or more vertices, all of which were given before.
  void polygon(std::span<const std::uint32_t> corners);
  void vertex_K(float K) { out_.mesh.vertex_K.push_back(K); }
  /// Of the last polygon.
  void polygon_K(float K);

  /// @throws InputError where there is no face
  MeshFile finish();

 private:
  std::filesystem::path path_;
  MeshFile out_;
  std::map<std::vector<std::string>, std::uint16_t> slots_;
  std::uint16_t slot_ = 0;
  std::size_t polygons_ = 0;
};

/// Cuts a polygon of four or more corners into triangles of the same winding, along diagonals inside of
/// it where there are any (ear clipping in the plane of Newell's normal).
/// @param triangles is appended to
void triangulate(std::span<const Vec3d> vertices, std::span<const std::uint32_t> corners,
                 std::vector<std::array<std::uint32_t, 3>>& triangles);

/// "x", "y" or "z": the first coordinate that is not finite; empty where all are.
const char* bad_coordinate(const Vec3d& position) noexcept;

}  // namespace obscura::detail
