// Volumes from files: which grids a file holds, and a stream of voxels for those that are wanted.
// What a value means (smoke, water, temperature) is the caller's business.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "octree/source/grid_request.h"
#include "octree/source/voxels.h"

namespace obscura {

/// Every grid of a volume file of one of the formats in volume_formats.h, those that can't be opened included.
/// @throws InputError where the file is missing, broken or of no known kind.
std::vector<GridInfo> inspect_volume(const std::filesystem::path& file);

/// Streams of the named grids. Grids on one lattice share a stream as its channels, in the order of
/// the request; each further lattice gives a stream of its own (join them by resample()).
///
/// Metres: the world units of .vdb and .nvdb count as metres as they stand (scale a cloud that was
/// written in km by its place); coordinates of .nc follow their units attribute; LES text is in km.
/// The voxel centres of OpenVDB (integer index coordinates), of a CF variable (its coordinates) and
/// of LES text (its grid points) become the centres of cells.
/// @throws InputError naming the grid, and the voxel where a value is NaN, infinite or negative. Dense
/// files are checked while they pour.
std::vector<VoxelStream> open_volume(const std::filesystem::path& file, const std::vector<GridRequest>& grids);

/// The same for grids that must not be negative; a background other than 0 fills the blocks that
/// hold a value of any of the grids.
std::vector<VoxelStream> open_volume(const std::filesystem::path& file, const std::vector<std::string>& grids);

}  // namespace obscura
