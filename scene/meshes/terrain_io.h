// Terrain from rasters of heights.
#pragma once

#include <filesystem>

#include "scene/meshes/mesh_io.h"

namespace obscura {

/// An ESRI ASCII grid, also packed with gzip: a vertex at the centre of each cell that has a height, two
/// triangles between four, one between three. x is east, y north, z up, all in the file's units and
/// coordinates; the front faces up. File numbers: a vertex is a cell, a face is the square between four,
/// row by row from the north-west.
/// @throws InputError naming file and line where it is absent, broken, cut off or without a triangle
MeshFile read_terrain(const std::filesystem::path& file);

}  // namespace obscura
