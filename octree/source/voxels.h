// The neutral form in which any source hands over its voxels: a stream of bricks and uniform tiles.
// Importers and shapes make a VoxelStream; the builder drinks it. Nothing here is dense.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "octree/base/math.h"

namespace obscura {

/// Takes voxels in from any number of threads at once, each 8^3 block at most once; what it is not given is 0.
/// Values are finite; a density is not negative (importers check: NaN, Inf and negative densities are InputErrors).
class VoxelSink {
 public:
  using BrickFunction = std::function<void(const Vec3i& corner, const float* const* values)>;
  using TileFunction = std::function<void(const Vec3i& corner, int level, std::span<const float> values)>;

  VoxelSink(BrickFunction on_brick, TileFunction on_tile)
      : on_brick_(std::move(on_brick)), on_tile_(std::move(on_tile)) {}

  /// The 8^3 voxels [corner, corner + 8).
  /// @param corner in voxels, a multiple of 8 on each axis.
  /// @param values one pointer per channel, to 512 floats each, x fastest, then y, then z. Read, not kept.
  void brick(const Vec3i& corner, const float* const* values) const { on_brick_(corner, values); }

  /// A cube of 2^level voxels a side, level >= 3, that holds the same value everywhere.
  /// @param corner in voxels, a multiple of 2^level on each axis.
  /// @param values one per channel.
  void tile(const Vec3i& corner, int level, std::span<const float> values) const { on_tile_(corner, level, values); }

 private:
  BrickFunction on_brick_;
  TileFunction on_tile_;
};

/// A source of voxels on one lattice.
struct VoxelStream {
  std::vector<std::string> channels;     ///< names, at least one
  Affine index_to_local;                 ///< voxel (i,j,k) spans [i,i+1)x[j,j+1)x[k,k+1) of index space; to metres
  Box3i bounds;                          ///< voxels [min, max) that may hold a value; poured values outside must be 0
  std::function<void(VoxelSink&)> pour;  ///< pours everything once per call, on any number of threads
  std::string name;                      ///< for messages
  /// Per channel, the value where nothing is poured, for resampling onto another lattice; empty: 0.
  std::vector<float> background;
  std::vector<std::string> units;  ///< per channel, of the values, as the file says; empty: it does not
};

}  // namespace obscura
