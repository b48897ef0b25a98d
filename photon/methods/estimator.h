// What a method makes: answers about the light of a World. All errors and biases mean the same, whoever answers.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "octree/base/statistics.h"
#include "photon/paths/radiance.h"
#include "photon/trace/light.h"

namespace obscura {

/// What each ray of a call stands for.
struct RayShare {
  Footprint footprint;  ///< its spot; the default is a line
  int paths = 0;  ///< points or paths along a ray that nothing passes, 1 to kMostPoints; 0: the method's own number
};

/// Radiance along rays at one spectral interval, as incoming_radiance(). Called by many threads at once; the result
/// of a ray belongs to its history number. Incoming::variance and the scatter of Incoming::map are random errors;
/// |Incoming::bias| is about one standard deviation of what is wrong and not random.
using RadianceEstimator =
    std::function<RadianceCounts(int interval, const RayShare& share, std::span<const Ray> rays,
                                 std::span<const std::uint64_t> histories, std::span<Incoming> incoming)>;

/// Power through a rectangle, W: along its normal and against it.
struct Crossing {
  Measured forward, backward;
  double net_error = 0;  ///< standard error of the difference: both sides share photons
};

/// From what photons tallied, whose batches are shares of the whole.
Crossing crossing_of(const FluxTally& tally);

/// Valid as long as the World that it was made for. Copies share what was made once.
struct Estimator {
  RadianceEstimator radiance;
  /// Fluence at a point in one band, W/m2. @param directions over the sphere, about; @param history names the random
  /// numbers
  std::function<Measured(int band, const Vec3d& point, int directions, std::uint64_t history)> fluence;
  /// Power through one of EstimatorSettings::rectangles in one band; none where the method does not know it.
  /// @param paths a side, about
  std::function<std::optional<Crossing>(int band, std::size_t rectangle, int paths)> crossing;
  /// What photons did; null where none were traced. Held by the functions above.
  const Light* light = nullptr;
  double bytes = 0;  ///< held by what was made once
  std::string what;  ///< what was run, for people: "16 paths a pixel"
};

}  // namespace obscura
