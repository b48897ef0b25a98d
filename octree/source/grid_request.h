// What a volume file holds and what is wanted of it, as plain values. Reading is io/'s.
#pragma once

#include <cstdint>
#include <string>

#include "octree/base/math.h"

namespace obscura {

/// One grid of a file. `resolution` is the size in voxels of the box of stored values, `min` and `max`
/// the range of those values (active voxels in OpenVDB's terms, every cell of a dense file).
struct GridInfo {
  std::string name;
  std::string type;           ///< as the file says: "float", "half", "vec3s", "int16" ...
  std::string units;          ///< of the values, as the file says; empty if it doesn't
  bool scalar = true;         ///< open_volume() takes only scalar grids
  Vec3i resolution{0, 0, 0};  ///< voxels
  Box3i bounds;               ///< voxels, [min, max)
  Vec3d voxel_m{0, 0, 0};     ///< edge lengths
  Affine index_to_local;      ///< voxel (i,j,k) spans [i,i+1) x [j,j+1) x [k,k+1); metres
  bool affine = true;         ///< false: a frustum or another map that open_volume() refuses
  double min = 0, max = 0;
  double background = 0;           ///< value between the stored voxels
  std::uint64_t active = 0;        ///< voxels that hold a value, those of tiles included
  std::uint64_t tiles = 0;         ///< uniform cubes that the file stores as one value
  std::uint64_t leaves = 0;        ///< 8^3 nodes that the file stores voxel by voxel
  std::uint64_t bytes_source = 0;  ///< of the grid in the file's own form: of trees in memory, of others in the file
  std::uint64_t bytes_dense = 0;   ///< float32 over `resolution`
  std::size_t times = 1;           ///< steps of a time-dependent variable; the range is that of the first
};

/// A grid that is wanted and what its values may be. NaN and infinities are always refused.
struct GridRequest {
  std::string name;
  bool require_non_negative = true;
  /// A background other than 0 is the value between the stored voxels, as in many temperature grids.
  /// Without it such a grid is refused: a density would fill all of space.
  bool fills_space = false;
  std::size_t time = 0;  ///< step of a time-dependent variable (.nc)
};

}  // namespace obscura
