// The ray spot: a conservative query of all geometry that rays between four neighbouring ones may see. It
// decides whether a sensor refines there. Formulas: photon/METHODS.md, "The spot".
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "octree/base/math.h"

namespace obscura {

class World;

/// What rays between four neighbouring ones may see.
struct Spot {
  /// In order around the spot, with unit directions. Either all have one origin, or all have one direction
  /// and begin in one plane. Seen in a mirror: rays from the mirrored eye, t_min where the mirror's plane is.
  std::array<Ray, 4> corners;
  /// Radians by which rays of the spot may lie outside the planes through neighbouring corners (fisheye).
  /// From 1 on the spot is taken to hold all directions.
  double bulge = 0;
};

/// Why a spot is refined.
enum class Criterion : std::uint8_t {
  none,
  polygons,
  materials,
  normal,
  reflection,
  depth,
  temperature,
  emissivity,
  shadow,
  transmission,
  radiance,
  error  // found by rays, not here
};
inline constexpr int kCriteria = 12;
const char* name(Criterion criterion) noexcept;

/// Where a spot counts as complex. std::nullopt: not asked. For `polygons` and `materials`: 0 refines
/// everywhere, 1 wherever anything but sky may be seen.
struct SpotThresholds {
  /// At least so many polygons that differ: in object, material or side, in temperature by more than
  /// temperature_K, or in direction by more than `normal`. Sky is one, and a disc of sun or moon.
  std::optional<int> polygons = 2;
  /// The same, every face for itself.
  std::optional<int> polygons_strict;
  /// At least so many materials. Sky is one; so is the absorbing back of one-sided faces, and so are hot spheres.
  std::optional<int> materials = 2;
  /// Radians between any two normals, each on the side that is seen.
  std::optional<double> normal = 5 * kPi / 180;
  /// (farthest - nearest) / nearest, of all that is seen in the spot but sky.
  std::optional<double> depth = 0.05;
  /// Between the coldest and the warmest place, K. A radiance that is given in place of a temperature
  /// differs from everything else.
  std::optional<double> temperature_K = 1;
  /// Between the smallest and the largest at any one interval, with the angles of view.
  std::optional<double> emissivity = 0.02;
};

/// Answers for many spots. Holds scratch: one per thread.
class SpotQuery {
 public:
  /// The first one for a World makes the index of its faces (Surfaces::index).
  /// @param specular_depth  mirrors that a ray follows; more than 4 count as 4. 0: reflections are not asked
  SpotQuery(const World& world, const SpotThresholds& thresholds, int specular_depth);
  ~SpotQuery();
  SpotQuery(SpotQuery&&) noexcept;
  SpotQuery& operator=(SpotQuery&&) noexcept;

  /// A criterion that the spot meets: the first that is found or, of those found at the same face, the first
  /// in their order. none: no ray of the spot sees anything that differs by a threshold from what another one
  /// sees, whatever the size of the polygons; hidden ones are not counted. Deterministic.
  Criterion operator()(const Spot& spot);

 private:
  class Search;
  std::unique_ptr<Search> search_;
};

}  // namespace obscura
