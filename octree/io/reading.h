// What the readers of volume files share: how a place is named in messages, names that must be there, files whose
// grids are trees. Internal to octree/io.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "octree/io/volume_formats.h"
#include "octree/source/sparse_grid.h"

namespace obscura::detail {

/// "file: grid 'name'", as messages name a place.
std::string where_of(const std::filesystem::path& file, const std::string& grid);

/// Every requested name is there, and asked for once.
/// @throws InputError that lists what the file holds.
void check_names(const std::filesystem::path& file, const std::vector<std::string>& present,
                 const std::vector<GridRequest>& requests);

/// Reads the requested grids of a file as trees of bricks and tiles.
using ReadSparse = std::vector<SparseGrid> (*)(const std::filesystem::path& file,
                                               const std::vector<GridRequest>& requests);

/// Streams of what `read` reads. Pouring them gives the trees' memory back brick by brick; a stream that is poured
/// again calls `read` again.
/// @throws InputError where `read` does, or where a value is one that its request forbids
std::vector<VoxelStream> open_sparse(const std::filesystem::path& file, const std::vector<GridRequest>& requests,
                                     ReadSparse read);

}  // namespace obscura::detail
