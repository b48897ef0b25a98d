// Photon tracing: emitted photons fly, collide, are stored and are absorbed, scattered or lost.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "octree/base/progress.h"
#include "photon/map/photon.h"
#include "photon/optics/work.h"
#include "photon/trace/emission.h"
#include "photon/trace/flux.h"
#include "photon/world/spectral_world.h"

namespace obscura {

struct TraceSettings {
  std::uint64_t photons = 1000000;  ///< emitted, per interval
  double photon_power_min = 0;      ///< W; photons below are not stored
  bool store = true;                ///< false: no photon is kept, only the power is accounted for
  Directions directions = Directions::stratified;
  std::optional<int> scattering_depth;  ///< most scatterings of a history; none: no limit
  std::uint64_t seed = 1;
  SourceSelection sources;
};

/// Watts per batch; a batch's sum is its share of the whole, so the sixteen add up to the total.
using BatchTally = std::array<double, kBatches>;

/// What became of the emitted power: emitted = absorbed + surface + escaped + truncated.
struct EnergyTally {
  BatchTally emitted{}, absorbed{}, surface{}, escaped{}, truncated{};
  EnergyTally& operator+=(const EnergyTally& other) noexcept;
};

struct FluxTally {
  BatchTally forward{}, backward{};
  FluxTally& operator+=(const FluxTally& other) noexcept;
};

/// What photons did, but for those that are stored.
struct PhotonTally {
  EnergyTally energy;
  std::vector<FluxTally> flux;  ///< one per rectangle
  std::uint64_t emitted = 0;    ///< number of photons
  WorkCounts work;
  double dropped_W = 0;         ///< power of what was not stored, below photon_power_min
  std::uint64_t anomalies = 0;  ///< non-finite or impossible values met (and left out)

  /// A tally without rectangles counts as zeros. Of a TraceResult it adds the tally alone.
  PhotonTally& operator+=(const PhotonTally& other);
};

struct TraceResult : PhotonTally {
  std::vector<Photon> photons;          ///< at collisions, in the order of batch, then emission
  std::vector<Photon> surface_photons;  ///< at surfaces that reflect, likewise
  bool partial = false;                 ///< cancelled before the end
};

/// Traces the emitter's spectral interval (`settings.sources` have been chosen with it). The same bits for any number
/// of threads.
TraceResult trace_photons(const PhotonEmitter& emitter, const TraceSettings& settings,
                          std::span<const FluxRectangle> rectangles = {}, const Progress& progress = {});

inline TraceResult trace_photons(SpectralWorld world, const TraceSettings& settings,
                                 std::span<const FluxRectangle> rectangles = {}, const Progress& progress = {}) {
  return trace_photons(PhotonEmitter(world, settings.sources), settings, rectangles, progress);
}

}  // namespace obscura
