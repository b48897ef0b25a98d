// Many independent photons of an emitter, for tests of where they start, where they go and what they weigh.
#pragma once

#include <array>
#include <cstdint>

#include "octree/base/random.h"
#include "octree/base/statistics.h"
#include "photon/trace/emission.h"

namespace obscura::test {

inline constexpr int kPhotons = 200000;

/// Independent photons; `each` sees them.
template <class F>
Moments emit_many(const PhotonEmitter& emitter, int count, F&& each, std::uint64_t seed = 1) {
  Stream random(seed, 0, 0);
  Moments power;
  PhotonEmitter::Cache cache;
  for (int i = 0; i < count; ++i) {
    std::array<double, 8> u;
    for (double& x : u) x = random.uniform();
    const EmittedPhoton photon = emitter.emit(u, cache);
    power.add(photon.power);
    each(photon);
  }
  return power;
}

}  // namespace obscura::test
