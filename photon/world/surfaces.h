// Everything opaque that a ray can meet: the World's objects and its hot spheres. Embree finds them, hits
// are recomputed in double about a local origin.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "octree/base/math.h"
#include "photon/world/object.h"

namespace obscura {

/// A black sphere that emits its own radiance, W/m2/sr per spectral interval, from its outside.
struct HotSphere {
  Vec3d center;
  double radius = 0;
  std::vector<double> radiance;
};

class FaceIndex;

/// Names a face. The surfaces are the objects in their order, then the hot spheres.
struct FaceId {
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::uint32_t surface = kNone;
  std::uint32_t face = 0;  ///< of the mesh; 0 on a sphere

  bool exists() const noexcept { return surface != kNone; }
  auto operator<=>(const FaceId&) const = default;
};

struct SurfaceHit {
  double t = kInfinity;
  FaceId id;
  double u = 0, v = 0;  ///< barycentric weights of a triangle's second and third corner

  bool exists() const noexcept { return id.exists(); }
};

/// Immutable; thread-safe. Of faces at the same distance the one with the lowest name is met.
class Surfaces {
 public:
  Surfaces();
  /// @param objects must outlive this; meshes are shared, not copied
  /// @param origin  the local origin that keeps far scenes exact
  /// @throws ResourceError where Embree has no memory
  Surfaces(std::span<const Object> objects, std::span<const HotSphere> spheres, const Vec3d& origin);
  ~Surfaces();
  Surfaces(Surfaces&&) noexcept;
  Surfaces& operator=(Surfaces&&) noexcept;

  bool empty() const noexcept { return !scene_; }

  /// The first face that the ray meets within (t_min, t_max); t is +inf where there is none. The
  /// direction must be a unit vector. Hot spheres are not seen from inside.
  /// @param from the face that the ray starts on, which it does not meet again
  SurfaceHit intersect(const Ray& ray, FaceId from = {}) const noexcept;
  /// Whether intersect() would find anything; faster.
  bool occluded(const Ray& ray, FaceId from = {}) const noexcept;
  /// False only if no face is within the radius (m): conservative.
  bool near(const Vec3d& point, double radius) const noexcept;

  /// True only if all faces within the radius (m) lie along the plane through the point: none stands up
  /// from it, so that its places see one another.
  bool flat(const Vec3d& point, const Vec3d& normal, double radius) const noexcept;

  /// Unit normal of the front at a point of the face.
  Vec3d normal(const FaceId& face, const Vec3d& point) const noexcept;
  /// Corners of a triangle in the world.
  std::array<Vec3d, 3> corners(const FaceId& face) const noexcept;
  /// Area of one side, m2.
  double area(const FaceId& face) const noexcept;

  /// What conservative queries need; made when it is first asked for, which may take as long as the
  /// constructor. Not for empty() surfaces.
  const FaceIndex& index() const;

  /// How far a ray has to start from a surface so that rounding does not let it meet the same place
  /// again, m.
  double clearance() const noexcept { return clearance_; }

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
  double clearance_ = 0;
};

/// Bounds of an object in the world; empty for a mesh without faces.
Box3d bounds_of(const Object& object) noexcept;

}  // namespace obscura
