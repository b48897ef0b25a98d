// What traced photons say of a World by themselves, without a density estimate: fluxes through rectangles,
// absorbed power, collisions, and what leaves after the next flight.
#pragma once

#include <cmath>
#include <vector>

#include "octree/base/random.h"
#include "octree/base/statistics.h"
#include "photon/trace/emission.h"
#include "photon/trace/trace.h"
#include "photon/world/scatter.h"

namespace obscura::test {

/// A horizontal rectangle about a point, counted upward as forward.
inline FluxRectangle horizontal(const Vec3d& center, double side_x, double side_y) {
  return {center, {side_x, 0, 0}, {0, side_y, 0}};
}

struct SlabLight {
  BatchMean up;          ///< above the stack, over `incident`
  BatchMean down;        ///< below it, direct light included
  BatchMean absorbed;    ///< by roulette
  BatchMean collisions;  ///< stored ones: without the first of sun and sky
};

/// Traces with several seeds: this many independent batches. Sixteen would leave Student's law with tails so
/// long that nothing small is seen.
inline constexpr int kRuns = 4;
inline constexpr int kManyBatches = kRuns * kBatches;

/// Photons of a periodic World between z = 0 and `top`; `incident` in W/m2.
inline SlabLight slab_light(const World& world, double top, double side_m, double incident, std::uint64_t photons,
                            std::uint64_t seed) {
  const FluxRectangle rectangles[] = {horizontal({0.5 * side_m, 0.5 * side_m, top + 0.5}, side_m, side_m),
                                      horizontal({0.5 * side_m, 0.5 * side_m, -0.5}, side_m, side_m)};
  const PhotonEmitter emitter({world, 0});
  const double unit = incident * side_m * side_m / kBatches;
  std::vector<double> up, down, absorbed, collisions;
  const auto append = [&](std::vector<double>& all, const BatchTally& tally) {
    for (const double value : tally) all.push_back(value / unit);
  };
  for (int run = 0; run < kRuns; ++run) {
    TraceSettings settings;
    settings.photons = photons / kRuns;
    settings.seed = kRuns * seed + static_cast<std::uint64_t>(run);
    const TraceResult traced = trace_photons(emitter, settings, rectangles);
    BatchTally stored{};
    for (const Photon& photon : traced.photons) stored[photon.batch] += static_cast<double>(photon.power);
    append(up, traced.flux[0].forward);
    append(down, traced.flux[1].backward);
    append(absorbed, traced.energy.absorbed);
    append(collisions, stored);
  }
  return {batch_mean(up), batch_mean(down), batch_mean(absorbed), batch_mean(collisions)};
}

/// Every stored collision's light after it: visit(photon, position, direction, power) with the power that is
/// scattered and one direction of it, in world metres. Expected values of flights add up from these without
/// the noise of where they end.
template <class Visit>
void scattered_light(const World& world, const std::vector<Photon>& photons, Visit&& visit) {
  for (std::size_t i = 0; i < photons.size(); ++i) {
    const Vec3d position = transform_point(world.map_to_world(), Vec3d(photons[i].position));
    const LocalScattering scattering({world, 0}, position);
    const LocalOptics optics = SpectralWorld(world, 0).at(position);
    if (!(scattering.total() > 0)) continue;
    Stream stream(11, i, 0);
    const double u = stream.uniform(), v = stream.uniform(), w = stream.uniform();
    const Vec3d travels = transform_direction(world.map_to_world(), decode_direction(photons[i].direction));
    visit(photons[i], position, scattering.sample(travels, u, v, w),
          static_cast<double>(photons[i].power) * scattering.total() / optics.extinction);
  }
}

}  // namespace obscura::test
