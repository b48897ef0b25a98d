// How thick to take a cloud whose optics nobody has given yet, so that a tolerance means something.
#pragma once

#include <cstdint>

#include "octree/build/build.h"

namespace obscura::cli {

/// The optical depth that the thickest chord is taken to have where no extinction is known.
inline constexpr double kAssumedDepth = 5;

/// What a deviation costs where every channel is taken as an extinction, as thick as that. `lossless` is the
/// octree of all values; a channel whose chords are all empty has weight 0, and its values are kept.
ErrorMeasure assumed_measure(const Octree& lossless);

/// Extinction per unit of the channel's value (1/m) that gives the thickest of 1000 chords the depth
/// kAssumedDepth. The chords are seeded: a uniform point of the domain, a uniform direction. 0 where all
/// chords are empty.
double assumed_extinction(const Octree& octree, int channel, std::uint64_t seed = 1);

}  // namespace obscura::cli
