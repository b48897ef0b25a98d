#include "photon/spheres.h"

#include <embree3/rtcore.h>

#include <algorithm>

namespace obscura {

struct Spheres::Scene {
  RTCDevice device = rtcNewDevice("threads=1");
  RTCScene scene = rtcNewScene(device);
  Box3d bounds;  // of all spheres, in world metres
  double pad = 0;  // m, by which Embree's boxes are larger than the spheres: what float rounds away

  ~Scene() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
};

namespace {

/// Entry into a sphere in double, or +inf: the numerically stable root of the quadratic
/// (Haines et al., "Precision improvements for ray/sphere intersection", Ray Tracing Gems, 2019).
double entry(const Ray& ray, const HotSphere& sphere) noexcept {
  const Vec3d to_origin = ray.origin - sphere.center;
  const double b = -to_origin.dot(ray.direction);
  const Vec3d closest = to_origin + b * ray.direction;
  const double discriminant = sphere.radius * sphere.radius - closest.dot(closest);
  if (discriminant <= 0) return kInfinity;
  const double c = to_origin.dot(to_origin) - sphere.radius * sphere.radius;
  if (c <= 0) return kInfinity;  // starts inside
  const double q = b + std::copysign(std::sqrt(discriminant), b);
  const double t = b > 0 ? c / q : kInfinity;
  return t > ray.t_min && t < ray.t_max ? t : kInfinity;
}

/// Embree asks for the entry into one sphere; the answer is computed in double and kept there too.
struct Query {
  RTCIntersectContext context;  // first: Embree hands back a pointer to it
  const std::vector<HotSphere>* spheres;
  const Ray* ray;
  double shift;  // m along the ray, to where Embree's starts
  double pad;
  SphereHit best;
};

struct BoundsData {
  const std::vector<HotSphere>* spheres;
  Vec3d origin;
  double pad;
};

void bounds_of_sphere(const RTCBoundsFunctionArguments* args) {
  const auto* user = static_cast<const BoundsData*>(args->geometryUserPtr);
  const HotSphere& sphere = (*user->spheres)[args->primID];
  const Vec3d center = sphere.center - user->origin;
  const double pad = sphere.radius + user->pad;
  *args->bounds_o = {static_cast<float>(center.x - pad), static_cast<float>(center.y - pad),
                     static_cast<float>(center.z - pad), 0,
                     static_cast<float>(center.x + pad), static_cast<float>(center.y + pad),
                     static_cast<float>(center.z + pad), 0};
}

void intersect_sphere(const RTCIntersectFunctionNArguments* args) {
  if (!args->valid[0]) return;
  auto* query = reinterpret_cast<Query*>(args->context);
  const double t = entry(*query->ray, (*query->spheres)[args->primID]);
  // Ties go to the lower index.
  if (t < query->best.t || (t == query->best.t && t < kInfinity && args->primID < query->best.sphere)) {
    query->best = {t, args->primID};
    auto* hit = reinterpret_cast<RTCRayHit*>(args->rayhit);
    hit->ray.tfar = static_cast<float>(t - query->shift + query->pad);
    hit->hit.geomID = args->geomID;
    hit->hit.primID = args->primID;
  }
}

}  // namespace

Spheres::Spheres() = default;
Spheres::~Spheres() = default;
Spheres::Spheres(Spheres&&) noexcept = default;
Spheres& Spheres::operator=(Spheres&&) noexcept = default;

Spheres::Spheres(std::vector<HotSphere> spheres, const Vec3d& origin)
    : spheres_(std::move(spheres)), origin_(origin) {
  if (spheres_.empty()) return;
  scene_ = std::make_unique<Scene>();
  rtcSetSceneFlags(scene_->scene, RTC_SCENE_FLAG_ROBUST);
  double farthest = 0;
  for (const HotSphere& sphere : spheres_) {
    scene_->bounds.extendBy(sphere.center - Vec3d(sphere.radius));
    scene_->bounds.extendBy(sphere.center + Vec3d(sphere.radius));
  }
  for (int axis = 0; axis < 3; ++axis) {
    farthest = std::max({farthest, std::abs(scene_->bounds.min[axis] - origin_[axis]),
                         std::abs(scene_->bounds.max[axis] - origin_[axis])});
  }
  scene_->pad = 1e-6 * farthest;
  RTCGeometry geometry = rtcNewGeometry(scene_->device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(spheres_.size()));
  BoundsData user{&spheres_, origin_, scene_->pad};
  rtcSetGeometryUserData(geometry, &user);
  rtcSetGeometryBoundsFunction(
      geometry, [](const RTCBoundsFunctionArguments* args) { bounds_of_sphere(args); }, nullptr);
  rtcSetGeometryIntersectFunction(
      geometry, [](const RTCIntersectFunctionNArguments* args) { intersect_sphere(args); });
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene_->scene);
}

SphereHit Spheres::intersect(const Ray& ray) const noexcept {
  if (spheres_.empty()) return {};
  // Embree's ray starts beside the spheres, not at the ray's origin: in float a ray from afar would pass
  // them by.
  Box3d around = scene_->bounds;
  around.min -= Vec3d(scene_->pad);
  around.max += Vec3d(scene_->pad);
  const auto [enter, leave] = clip(ray, around);
  if (!(enter < leave)) return {};
  Query query;
  rtcInitIntersectContext(&query.context);
  query.spheres = &spheres_;
  query.ray = &ray;
  query.shift = enter;
  query.pad = scene_->pad;
  RTCRayHit hit{};
  const Vec3d o = ray.at(enter) - origin_;
  hit.ray.org_x = static_cast<float>(o.x);
  hit.ray.org_y = static_cast<float>(o.y);
  hit.ray.org_z = static_cast<float>(o.z);
  hit.ray.dir_x = static_cast<float>(ray.direction.x);
  hit.ray.dir_y = static_cast<float>(ray.direction.y);
  hit.ray.dir_z = static_cast<float>(ray.direction.z);
  hit.ray.tnear = 0;
  hit.ray.tfar = static_cast<float>(leave - enter + scene_->pad);
  hit.ray.mask = ~0u;
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene_->scene, &query.context, &hit);
  return query.best;
}

}  // namespace obscura
