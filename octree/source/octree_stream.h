// An octree turned back into a stream of voxels, for export.
#pragma once

#include <memory>

#include "octree/source/voxels.h"
#include "octree/tree/octree.h"

namespace obscura {

/// The voxels of an octree as a stream, leaves of level 3 and up as tiles.
VoxelStream octree_stream(std::shared_ptr<const Octree> octree);

}  // namespace obscura
