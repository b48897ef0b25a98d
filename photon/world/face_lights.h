// The faces of objects that emit at one interval, to be chosen in proportion to their power.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "photon/world/surfaces.h"

namespace obscura {

class SpectralWorld;

/// Faces that have their three corners in the places of an earlier face of their mesh: rays meet that one, so
/// these neither shine nor are seen. Found when first asked for.
class TwinFaces {
 public:
  /// Whether each face is such a twin; empty: none is.
  const std::vector<bool>& of(const Mesh& mesh);

 private:
  std::map<const Mesh*, std::vector<bool>> found_;
};

/// Immutable; its functions take the World and interval that it was made of. An object that is an exact copy of an
/// earlier one in its very place emits nothing, as twin faces. Objects whose faces emit alike share the sums of their
/// mesh's areas.
class FaceLights {
 public:
  FaceLights(SpectralWorld world, TwinFaces& twins);

  bool empty() const noexcept { return objects_.empty(); }
  /// Of all emitting sides, W.
  double power() const noexcept { return power_; }

  struct Place {
    FaceId id;
    Vec3d position;
    Vec3d normal;  ///< unit, of the side that emits there
    double u, v;   ///< barycentric
  };
  /// A point: the side of a face in proportion to its power, then uniform on it.
  /// @param u, v, w uniform numbers
  Place sample(SpectralWorld world, double u, double v, double w) const noexcept;

  /// Radiance that leaves the place at an angle to its normal, W/m2/sr; of a net, over its whole area.
  double emission(SpectralWorld world, const Place& place, double cosine) const noexcept;

  /// Probability per m2 of one side of a face with which sample() chooses it. 0 for what does not emit.
  double density(SpectralWorld world, const FaceId& face) const noexcept;

 private:
  struct Emitter {
    std::uint32_t object;
    std::shared_ptr<const std::vector<double>> sums;  // over faces, of area or power; none: a sphere
  };

  double power_ = 0;
  std::vector<Emitter> objects_;
  std::vector<int> emitter_of_;     // of each object of the World; -1: none
  std::vector<double> cumulative_;  // W
};

}  // namespace obscura
