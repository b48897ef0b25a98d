// How thick a World is to light, by seeded chords, and whether a history of light can end in it.
#pragma once

#include <optional>
#include <string_view>

#include "octree/base/error.h"
#include "photon/world/spectral_world.h"

namespace obscura {

/// Largest optical depth of the World at one interval over seeded chords through its bounds: an
/// estimate from below that the thickest direction exceeds by little where clouds are not needles.
double largest_optical_depth(SpectralWorld world, int chords = 256);

/// The same for scattering alone, taken from the largest albedo: an estimate from above where it varies.
double largest_scattering_depth(SpectralWorld world, int chords = 256);

/// Mean cosine of the most forward phase function of what scatters; 0 where nothing does.
double largest_mean_cosine(SpectralWorld world);

/// Whether a history of light would practically never end: depth times (1 - g) above 1e4 while less than one collision
/// in `depth` absorbs. Names the method and points to another one; none: it ends.
std::optional<NumericalError> endless_histories(SpectralWorld world, std::string_view method);

}  // namespace obscura
