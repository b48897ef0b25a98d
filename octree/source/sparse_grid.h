// One scalar grid of a sparse file as 8^3 bricks and uniform tiles, whatever wrote it, and the
// streams that several of them make together. Internal to the importers.
#pragma once

#include <functional>
#include <span>

#include "octree/source/grid_request.h"
#include "octree/source/voxels.h"

namespace obscura::detail {

struct SparseTile {
  Vec3i corner;  ///< aligned to 2^level
  int level;     ///< 3, 7 or 12 in OpenVDB's usual tree
  float value;
};

/// A scalar grid. Bricks and tiles don't overlap; everywhere else the value is the background.
struct SparseGrid {
  GridRequest request;
  std::string where;  ///< file and grid, for messages
  std::string units;  ///< as the file says; empty: it does not
  Affine index_to_local;
  float background = 0;
  std::vector<Vec3i> bricks;  ///< corners, aligned to 8
  std::vector<SparseTile> tiles;
  Box3i extent;  ///< of the file's lattice where it has one; empty: the values' own bounds
  /// The 512 values of a brick, x fastest. Called from several threads.
  std::function<void(std::size_t brick, std::span<float, 512> values)> read;
  /// Gives back the memory of a brick that will not be read again; may be empty.
  std::function<void(std::size_t brick)> release;
};

/// What a scan of all values says.
struct SparseRange {
  Box3i bounds;  ///< of the values that differ from 0, [min, max); empty if there are none
  float min, max;
};

/// Reads every value once, in parallel. Stored values that break the request (NaN, infinite,
/// negative) are refused by grid and voxel, as is a background that may not fill space.
/// @throws InputError
SparseRange check(const SparseGrid& grid);

/// True where two lattices are one: all voxels coincide to 1e-6 of a voxel within `bounds`.
bool same_lattice(const Affine& a, const Affine& b, const Box3i& bounds);

/// Reads the grids of a file again.
using Reload = std::function<std::vector<SparseGrid>(const std::vector<GridRequest>&)>;

/// Checks the grids and makes one stream per lattice. With `reload` the first pour consumes the grids,
/// brick by brick, and a further pour reads the file again; without it they stay in the stream.
std::vector<VoxelStream> make_streams(const std::string& name, std::vector<SparseGrid> grids, Reload reload = {});

}  // namespace obscura::detail
