// What rays and points find among surfaces. How the scene is made: surfaces_build.cpp.
#include "photon/world/surfaces.h"

#include <tbb/task_arena.h>

#include <algorithm>

#include "photon/world/surfaces_scene-inl.h"

namespace obscura {

Surfaces::Surfaces() = default;
Surfaces::~Surfaces() = default;
Surfaces::Surfaces(Surfaces&&) noexcept = default;
Surfaces& Surfaces::operator=(Surfaces&&) noexcept = default;

namespace {

using detail::SurfaceQuery;

/// Embree's ray starts beside the surfaces, not at the ray's origin: in float a ray from afar would pass
/// them by. False where it misses their bounds.
template <class Scene>
bool start(SurfaceQuery& query, RTCRay& out, const Scene& scene, const Ray& ray, FaceId from) noexcept {
  query.scene = &scene;
  query.ray = ray;
  query.ray.origin -= scene.origin;
  query.from = from;
  query.pad = scene.pad;
  query.tie = scene.tie;
  const Box3d& bounds = scene.bounds;
  const auto [enter, leave] = clip(query.ray, {bounds.min - Vec3d(query.pad), bounds.max + Vec3d(query.pad)});
  if (!(enter < leave)) return false;
  rtcInitIntersectContext(&query.context);
  query.shift = enter - query.pad;
  const Vec3d o = query.ray.at(query.shift);
  const Vec3d& d = query.ray.direction;
  out = {};
  out.org_x = static_cast<float>(o.x);
  out.org_y = static_cast<float>(o.y);
  out.org_z = static_cast<float>(o.z);
  out.dir_x = static_cast<float>(d.x);
  out.dir_y = static_cast<float>(d.y);
  out.dir_z = static_cast<float>(d.z);
  out.tfar = static_cast<float>(leave - enter + 2 * query.pad);
  out.mask = ~0u;
  return true;
}

}  // namespace

SurfaceHit Surfaces::intersect(const Ray& ray, FaceId from) const noexcept {
  if (!scene_) return {};
  SurfaceQuery query;
  RTCRayHit hit;
  if (!start(query, hit.ray, *scene_, ray, from)) return {};
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene_->scene, &query.context, &hit);
  return query.best;
}

bool Surfaces::occluded(const Ray& ray, FaceId from) const noexcept {
  if (!scene_) return false;
  SurfaceQuery query;
  RTCRay out;
  if (!start(query, out, *scene_, ray, from)) return false;
  rtcOccluded1(scene_->scene, &query.context, &out);
  return query.best.exists();
}

namespace {

/// Asks about the faces near a point until one answers yes.
template <class Found>
bool any_face(RTCScene scene, const Vec3d& p, double radius, const Found& found) noexcept {
  RTCPointQuery query;
  query.x = static_cast<float>(p.x);
  query.y = static_cast<float>(p.y);
  query.z = static_cast<float>(p.z);
  query.time = 0;
  query.radius = static_cast<float>(radius);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  struct Search {
    const Found* found;
    bool yes = false;
  } search{&found};
  rtcPointQuery(
      scene, &query, &context,
      [](RTCPointQueryFunctionArguments* args) {
        auto& asked = *static_cast<Search*>(args->userPtr);
        const bool instance = args->context->instStackSize > 0;
        if (!asked.yes && !(*asked.found)(instance ? args->context->instID[0] : FaceId::kNone, args->primID)) {
          return false;
        }
        asked.yes = true;
        args->query->radius = 0;  // no need to look on
        return true;
      },
      &search);
  return search.yes;
}

}  // namespace

bool Surfaces::near(const Vec3d& point, double radius) const noexcept {
  if (!scene_) return false;
  const Vec3d p = point - scene_->origin;
  const double reach = radius + scene_->pad;
  for (int axis = 0; axis < 3; ++axis) {
    if (p[axis] < scene_->bounds.min[axis] - reach || p[axis] > scene_->bounds.max[axis] + reach) return false;
  }
  return any_face(scene_->scene, p, reach, [](std::uint32_t, std::uint32_t) { return true; });
}

bool Surfaces::flat(const Vec3d& point, const Vec3d& normal, double radius) const noexcept {
  constexpr double kParallel = 0.985;  // 10 degrees
  constexpr double kThin = 0.1;        // of the radius
  const Vec3d p = point - scene_->origin;
  return !any_face(scene_->scene, p, radius + scene_->pad, [&](std::uint32_t object, std::uint32_t face) {
    if (object == FaceId::kNone) return true;  // spheres are round
    const std::array<Vec3d, 3> corners = scene_->corners(object, face);
    const Vec3d n = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    const double length = n.length();
    return std::abs(n.dot(normal)) < kParallel * length || std::abs((corners[0] - p).dot(n)) > kThin * radius * length;
  });
}

const FaceIndex& Surfaces::index() const {
  std::call_once(scene_->index_once, [&] {
    // Isolated: a thread that helps out must not take up work that asks for the index again.
    tbb::this_task_arena::isolate([&] {
      scene_->index = std::make_unique<FaceIndex>(scene_->objects, scene_->to_scene, scene_->balls, scene_->origin);
    });
  });
  return *scene_->index;
}

Vec3d Surfaces::normal(const FaceId& face, const Vec3d& point) const noexcept {
  if (face.surface >= scene_->objects.size() || !scene_->objects[face.surface].mesh) {
    return (point - scene_->origin - scene_->ball(face.surface).center).normalized();
  }
  const std::array<Vec3d, 3> p = scene_->corners(face.surface, face.face);
  return (p[1] - p[0]).cross(p[2] - p[0]).normalized();
}

std::array<Vec3d, 3> Surfaces::corners(const FaceId& face) const noexcept {
  std::array<Vec3d, 3> p = scene_->corners(face.surface, face.face);
  for (Vec3d& corner : p) corner += scene_->origin;
  return p;
}

double Surfaces::area(const FaceId& face) const noexcept {
  if (face.surface >= scene_->objects.size() || !scene_->objects[face.surface].mesh) {
    const double radius = scene_->ball(face.surface).radius;
    return 4 * kPi * radius * radius;
  }
  const std::array<Vec3d, 3> p = scene_->corners(face.surface, face.face);
  return 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).length();
}

}  // namespace obscura
