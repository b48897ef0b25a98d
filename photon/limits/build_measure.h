// What a deviation of a voxel's values costs: the error measure that the octree's builder takes,
// from a cloud's extinction and Planck's law.
#pragma once

#include <span>

#include "octree/build/build.h"
#include "photon/world/cloud.h"

namespace obscura {

/// Extinction in the interval where it is largest; emission in that of each band where it is largest.
/// @param cloud everything but its octree; channels are those of the stream, which is poured once where
/// a temperature channel has to be scanned for its maximum.
ErrorMeasure build_measure(const Cloud& cloud, std::span<const Band> bands, const VoxelStream& stream);

}  // namespace obscura
