// From the description of a scene to the World at one time: opens volumes and meshes, builds octrees and works out the
// optics of every spectral interval.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "octree/base/progress.h"
#include "octree/build/build.h"
#include "photon/world/world.h"
#include "scene/file/description.h"

namespace obscura {

/// How one octree came out; a cloud whose grids lie on different lattices has several.
struct OctreeRecord {
  std::string name;
  double tolerance = 0;
  OctreeStatistics statistics;
  BuildReport build;
  std::map<std::string, std::string> units;  ///< by grid, as the volume says; without those that it does not tell
};

struct BuiltWorld {
  World world;
  std::vector<OctreeRecord> octrees;
};

Band make_band(const BandDescription& band);

/// @throws InputError where a volume or mesh is broken or lacks what the scene names; ResourceError where memory or
/// disk fail.
BuiltWorld build_world(const Description& scene, double time_s, const Progress& progress = {});

}  // namespace obscura
