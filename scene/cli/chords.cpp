#include "chords.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "octree/base/random.h"
#include "octree/tree/walk.h"

namespace obscura::cli {

double assumed_extinction(const Octree& octree, int channel, std::uint64_t seed) {
  constexpr std::uint32_t purpose = 0x43484F52;  // keeps these streams apart from a render's
  std::vector<double> weights(static_cast<std::size_t>(octree.channel_count()), 0.0);
  weights[static_cast<std::size_t>(channel)] = 1;
  const Box3i& domain = octree.domain();
  double thickest = 0;
  for (std::uint64_t chord = 0; chord < 1000; ++chord) {
    Stream random(seed, chord, purpose);
    Vec3d point;
    for (int axis = 0; axis < 3; ++axis) {
      point[axis] = domain.min[axis] + random.uniform() * (domain.max[axis] - domain.min[axis]);
    }
    const double z = 2 * random.uniform() - 1;
    const double azimuth = 2 * kPi * random.uniform();
    const double sine = std::sqrt(1 - z * z);
    // A unit direction in metres, so that depths are per metre whatever the voxels' shape.
    Ray ray{transform_point(octree.index_to_local(), point),
            {sine * std::cos(azimuth), sine * std::sin(azimuth), z},
            -kInfinity,
            kInfinity};
    thickest = std::max(thickest, optical_depth(octree, transform_ray(octree.local_to_index(), ray), weights));
  }
  return thickest > 0 ? kAssumedDepth / thickest : 0;
}

ErrorMeasure assumed_measure(const Octree& lossless) {
  ErrorMeasure measure;
  for (int channel = 0; channel < lossless.channel_count(); ++channel) {
    measure.optical_weight.push_back(assumed_extinction(lossless, channel));
  }
  return measure;
}

}  // namespace obscura::cli
