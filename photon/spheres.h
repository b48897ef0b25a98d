// Opaque hot spheres and particles: what a ray meets beside clouds. Embree finds them, hits are
// recomputed in double about a local origin.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "octree/base/math.h"

namespace obscura {

/// A black sphere that emits its own radiance, W/m2/sr per spectral interval, from its outside.
struct HotSphere {
  Vec3d center;
  double radius = 0;
  std::vector<double> radiance;
};

struct SphereHit {
  double t = kInfinity;
  std::uint32_t sphere = 0;  ///< index, in the order given
};

/// Immutable; thread-safe.
class Spheres {
 public:
  Spheres();
  /// @param origin the local origin that keeps far scenes exact.
  Spheres(std::vector<HotSphere> spheres, const Vec3d& origin);
  ~Spheres();
  Spheres(Spheres&&) noexcept;
  Spheres& operator=(Spheres&&) noexcept;

  bool empty() const noexcept { return spheres_.empty(); }
  const std::vector<HotSphere>& spheres() const noexcept { return spheres_; }

  /// The first sphere that the ray enters within (t_min, t_max); t is +inf where there is none.
  /// A ray that starts inside a sphere does not see that sphere. The direction must be a unit vector.
  SphereHit intersect(const Ray& ray) const noexcept;

 private:
  struct Scene;
  std::vector<HotSphere> spheres_;
  Vec3d origin_{0, 0, 0};
  std::unique_ptr<Scene> scene_;
};

}  // namespace obscura
