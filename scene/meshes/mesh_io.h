// Triangle meshes from files, with the names by which a scene may call their parts, and tables of
// temperature for them. Placing, materials and optics are build_surfaces' business.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "photon/world/object.h"

namespace obscura {

/// What a mesh or terrain file holds.
struct MeshFile {
  Mesh mesh;  ///< in the file's own axes and units; duplicate and degenerate faces are kept
  /// What each slot of the mesh may be called, the most telling name first: groups, object or node, then
  /// material. At least one slot; its list may be empty.
  std::vector<std::vector<std::string>> slot_names;
  /// The file's own numbers, from 0: of each triangle the file's face (a polygon is one), of each vertex
  /// the file's vertex. Empty: the same as the mesh's.
  std::vector<std::uint32_t> face_numbers, vertex_numbers;
  std::uint64_t face_count = 0, vertex_count = 0;  ///< in the file
};

/// Reads .obj, .ply, .stl, .gltf or .glb, by extension. Polygons are cut into triangles, nodes are put
/// where they stand. A vertex or face property `K` of a PLY file is its temperature.
/// OBJ, PLY and STL take memory for the mesh alone, whatever the file's size.
/// @throws InputError naming file, and line of a text, where it is absent, broken, cut off or empty
MeshFile read_mesh(const std::filesystem::path& file);

/// Gives faces or vertices the kelvin of a table with the header `face,K` or `vertex,K`, in place of any
/// that the mesh has; numbers are the file's. Rows left out stay without (NaN).
/// @throws InputError naming table and line where it is not such a table or the mesh has no such face
void read_temperatures(const std::filesystem::path& table, MeshFile& mesh);

}  // namespace obscura
