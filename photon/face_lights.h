// The faces of objects that emit at one interval, to be chosen in proportion to their power.
#pragma once

#include <memory>
#include <vector>

#include "photon/surfaces.h"

namespace obscura {

class World;

/// Immutable. Objects whose faces emit alike share the sums of their mesh's areas.
class FaceLights {
 public:
  FaceLights(const World& world, int interval);

  bool empty() const noexcept { return objects_.empty(); }
  /// Of all emitting sides, W.
  double power() const noexcept { return power_; }

  struct Place {
    FaceId id;
    Vec3d position;
    Vec3d normal;     ///< unit, of the side that emits there
    double u, v;      ///< barycentric
  };
  /// A point: the side of a face in proportion to its power, then uniform on it.
  /// @param u, v, w uniform numbers
  Place sample(const World& world, double u, double v, double w) const noexcept;

  /// Radiance that leaves the place at an angle to its normal, W/m2/sr; of a net, over its whole area.
  double emission(const World& world, const Place& place, double cosine) const noexcept;

  /// Probability per m2 of one side of a face with which sample() chooses it. 0 for what does not emit.
  double density(const World& world, const FaceId& face) const noexcept;

 private:
  struct Emitter {
    std::uint32_t object;
    std::shared_ptr<const std::vector<double>> sums;  // over faces, of area or power; none: a sphere
  };

  int interval_;
  double power_ = 0;
  std::vector<Emitter> objects_;
  std::vector<double> cumulative_;  // W
};

}  // namespace obscura
