// Lines of sight to an object: which pixels show it, and what arrives along rays through them and their surroundings,
// apart for the object and for what is around it. Mixed pixels are split by their rays, not by their values.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "octree/base/progress.h"
#include "photon/methods/estimator.h"
#include "sensor/capture/camera.h"
#include "sensor/sight/obscuration.h"

namespace obscura {

/// Lines a side of a pixel that look for objects.
inline constexpr int kMaskLines = 4;

/// For each object of the World its share of each pixel of the picture that shows any of it, pixels counted row by row
/// from the top left: by kMaskLines^2 lines of sight in a regular pattern. Clouds hide nothing here.
std::vector<std::vector<std::pair<std::uint32_t, float>>> object_shares(const World& world, const Camera& camera,
                                                                        const Progress& progress = {});

/// Lines of sight of equal solid angle, jittered in strata of each pixel.
struct SightRays {
  std::vector<Ray> rays;
  std::vector<std::uint64_t> histories;
  std::vector<std::int32_t> slots;  ///< of each ray: its pixel among those of the object, -1 for one of the ring
  std::size_t pixels = 0;           ///< of the object
};
SightRays sight_rays(const Camera& camera, const ObjectMask& mask, int lines_per_pixel, std::uint64_t seed);

/// What they have found, per band.
struct Sight {
  std::vector<Look> looks;
  std::vector<std::vector<float>> transmission;  ///< of the clouds, of lines that end on the object
  RadianceCounts counts;
};

/// @param object index into the World's
/// The same bits for any number of threads. Cancelled: nothing of it is of use.
Sight look(const World& world, const RadianceEstimator& estimator, const SightRays& rays, std::uint32_t object,
           const Progress& progress = {});

}  // namespace obscura
