// What the hard cases share: the light of so many photons, and tallies as powers.
#pragma once

#include <cstdint>

#include "octree/base/statistics.h"
#include "photon/trace/light.h"
#include "photon/world/world.h"

namespace obscura::test {

inline constexpr double kB = 2;

inline Light photons_of(const World& world, std::uint64_t count, std::uint64_t seed = 1) {
  TraceSettings trace;
  trace.photons = count;
  trace.seed = seed;
  return trace_light(world, trace);
}

inline double total(const BatchTally& tally) { return pairwise_sum(tally); }

inline BatchMean per_area(BatchTally tally, double area) {
  for (double& value : tally) value *= kBatches / area;
  return batch_mean(tally);
}

}  // namespace obscura::test
