// Joins two streams on different lattices.
#pragma once

#include "octree/source/voxels.h"

namespace obscura {

/// The channels of `onto` followed by those of `field`, sampled at the voxel centres of `onto`
/// (trilinear between the voxel centres of `field`; its background outside). Only where `onto`
/// pours. Holds `field` in memory while it pours.
VoxelStream resample(VoxelStream onto, VoxelStream field);

}  // namespace obscura
