// The sensor pass: radiance that arrives along rays at one spectral interval. Emission and direct
// light are integrated here; what has scattered more often comes from the photon map.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "photon/map/density.h"
#include "photon/map/photon_map.h"
#include "photon/optics/work.h"
#include "photon/world/footprint.h"
#include "photon/world/spectral_world.h"

namespace obscura {

/// The parts that radiance is the sum of; each can be switched off.
struct RadianceParts {
  bool background = true;  ///< sky, discs and what surfaces emit, seen through the clouds and in mirrors
  bool sun_disc = true;    ///< the discs of sun and moon in the background
  bool emission = true;    ///< of the clouds, unscattered
  bool sun = true;         ///< of sun and moon, scattered or reflected once
  bool sky = true;         ///< scattered or reflected once
  bool surfaces = true;    ///< emitted by objects, scattered or reflected once
  bool spheres = true;     ///< of hot spheres, scattered or reflected once
  bool map = true;         ///< all other scattered or reflected light
};

/// Bounces after which no map is asked: every path goes on until nothing is left of it.
inline constexpr int kAllBounces = std::numeric_limits<int>::max();

/// Most scattering points of a ray.
inline constexpr int kMostPoints = 4096;

struct RadianceSettings {
  GatherSettings gather;
  /// Scattering points along a ray whose clouds let nothing through; in proportion fewer in thin ones.
  int points = 4;
  /// Final gather: bounces from each scattering point, in one sampled direction each, before the map is asked.
  /// kAllBounces: a path tracer.
  int gather_bounces = 0;
  /// Mirrors that a camera ray follows; one behind them is taken for Lambertian.
  int specular_depth = 4;
  std::optional<int> scattering_depth;  ///< as in tracing; 0: nothing scatters into the ray
  std::uint64_t seed = 1;
  RadianceParts parts;
  /// The spot of each ray of a call; the default is a line. Where a spot is wider than cells of a cloud whose emission
  /// is followed through leaves, cells are taken whole.
  Footprint footprint;
  /// Most that this may change a ray's transmission, and its radiance relative to the largest source; 0: nothing.
  double footprint_tolerance = 1e-3;
};

/// What arrives at the start of a ray, W/m2/sr.
struct Incoming {
  double direct = 0;                   ///< everything that does not come from the map
  std::array<double, kBatches> map{};  ///< from the map, once per batch; their mean adds to `direct`
  double bias = 0;                     ///< estimated bias of the map's part
  double variance = 0;                 ///< of total(), from the scatter of the ray's own points; 0: not known
  double transmission = 1;             ///< of the clouds, to the first surface or infinity
  double transmission_air = 1;         ///< of the atmosphere, likewise
  double distance = kInfinity;         ///< to the first surface, in units of the ray's direction

  double total() const noexcept {
    double sum = 0;
    for (const double batch : map) sum += batch;
    return direct + sum / kBatches;
  }
};

/// What the pass did; anomalies are numbers that should never be: they are left out and counted.
struct RadianceCounts {
  std::uint64_t rays = 0;
  std::uint64_t anomalies = 0;
  WorkCounts work;
  FootprintCounts footprint;  ///< legs that were walked with one

  RadianceCounts& operator+=(const RadianceCounts& other) noexcept {
    rays += other.rays;
    anomalies += other.anomalies;
    work += other.work;
    footprint += other.footprint;
    return *this;
  }
};

/// Radiance along many rays at once. Directions are unit vectors, all spans of one length, the interval one of the
/// World's; else InputError. The result of a ray depends on its
/// history number and not on the others. Scratch memory is allocated once per some thousands: give it many.
/// @param maps null: nothing but direct light, unless the settings ask for all bounces
RadianceCounts incoming_radiance(SpectralWorld world, const PhotonMaps* maps, const RadianceSettings& settings,
                                 std::span<const Ray> rays, std::span<const std::uint64_t> histories,
                                 std::span<Incoming> incoming);

}  // namespace obscura
