// Dense files as streams: read slab by slab, so that no more than eight layers are held at a time.
// Internal to the importers.
#pragma once

#include <functional>
#include <span>

#include "octree/source/grid_request.h"
#include "octree/source/voxels.h"

namespace obscura::detail {

/// Grids of a file that share one lattice of `resolution` voxels from index 0 on, and how to read them.
struct DenseGrids {
  std::string name;  ///< of the file
  std::vector<GridRequest> grids;
  std::vector<std::string> where;  ///< per grid, for messages
  std::vector<std::string> units;  ///< per grid, as the file says; empty: it does not
  Affine index_to_local;
  Vec3i resolution{0, 0, 0};
  int slab_axis = 2;  ///< the axis along which the file is read in order
  /// Values of one grid in a box of voxels, x fastest. Never called from two threads at once.
  std::function<void(std::size_t grid, const Box3i& box, std::span<float> values)> read;
};

/// @throws (while pouring) InputError naming the first value that the grid's request forbids.
VoxelStream stream_slabs(DenseGrids dense);

/// Smallest and largest value of a grid, and how many differ from 0.
struct SlabRange {
  double min = 0, max = 0;
  std::uint64_t nonzero = 0;
};
SlabRange range_of(const DenseGrids& dense, std::size_t grid);

/// The lattice's part of a GridInfo.
GridInfo describe_lattice(const std::string& name, const Affine& index_to_local, const Vec3i& resolution);

/// @throws InputError for resolutions or voxels that can't be.
void check_resolution(const std::string& where, const Vec3i& resolution);

}  // namespace obscura::detail
