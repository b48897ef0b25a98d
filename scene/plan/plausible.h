// What of a scene can hardly be meant, most often for a wrong unit, in words: the place, the number and the remedy.
#pragma once

#include <string>
#include <vector>

#include "photon/limits/media_summary.h"
#include "scene/file/description.h"
#include "scene/world/build_world.h"

namespace obscura {

/// One sentence for each: wavelengths, temperatures and optical depths of clouds, units of their grids that do not go
/// with the scene's keys, a view that holds nothing. None of them is an error.
/// @param octrees  of the scene's clouds, with the units that their volumes tell
std::vector<std::string> implausible_values(const Description& scene, const MediaSummary& summary,
                                            const std::vector<OctreeRecord>& octrees);

namespace detail {

/// Of wavelengths alone: bands and spectral tables that reach beyond a millimetre.
std::vector<std::string> implausible_wavelengths(const Description& scene);

}  // namespace detail
}  // namespace obscura
