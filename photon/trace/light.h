// All photon maps of a World: one per spectral interval, with what became of the power of each band.
#pragma once

#include <optional>
#include <vector>

#include "octree/base/error.h"
#include "photon/map/photon_map.h"
#include "photon/trace/trace.h"

namespace obscura {

/// What the photons of one band did, over all its intervals.
struct BandLight {
  EnergyTally energy;
  std::vector<FluxTally> flux;  ///< one per rectangle
};

struct Light {
  std::vector<PhotonMaps> maps;  ///< one per interval; photons in the World's map frame
  std::vector<BandLight> bands;
  std::uint64_t emitted = 0;  ///< number of photons
  std::uint64_t stored = 0;
  WorkCounts work;          ///< trial runs included, which are not in `emitted`
  std::uint64_t bytes = 0;  ///< of the maps
  double dropped_W = 0;     ///< collisions below photon_power_min, not stored
  std::uint64_t anomalies = 0;
  bool partial = false;

  /// Adds the tallies of another, independent tracing of the same World: powers become means over the photons of both,
  /// counts are added. Its maps are not taken over.
  void add_tallies(const Light& other);
};

/// Why photons cannot serve the World; none: they can. Finite sources or objects in a periodic one, clouds of different
/// periods, rectangles that stand upright in a periodic one; histories that would not end.
/// @param traced false: none is going to be followed
std::optional<NumericalError> unfit_for_photons(const World& world, bool traced,
                                                std::span<const FluxRectangle> rectangles = {});

/// Traces every interval. `settings.photons` is the number per band: each interval gets its share by
/// the power of its sources.
/// @throws NumericalError as unfit_for_photons() answers
Light trace_light(const World& world, const TraceSettings& settings, std::span<const FluxRectangle> rectangles = {},
                  const Progress& progress = {});

}  // namespace obscura
