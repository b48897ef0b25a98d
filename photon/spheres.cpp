#include "photon/spheres.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <utility>

namespace obscura {

struct Spheres::Scene {
  RTCDevice device = rtcNewDevice("threads=1");
  RTCScene scene = rtcNewScene(device);

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
  SphereHit best;
};

void bounds_of_sphere(const RTCBoundsFunctionArguments* args) {
  const auto* self = static_cast<const std::pair<const std::vector<HotSphere>*, Vec3d>*>(
      args->geometryUserPtr);
  const HotSphere& sphere = (*self->first)[args->primID];
  const Vec3d center = sphere.center - self->second;
  // Outward by more than a float rounding of the centre, so that no sphere slips through.
  const double pad = sphere.radius * (1 + 1e-6) +
                     1e-6 * std::max({std::abs(center.x), std::abs(center.y), std::abs(center.z)});
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
    hit->ray.tfar = std::nextafter(static_cast<float>(t * (1 + 1e-6)), std::numeric_limits<float>::infinity());
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
  RTCGeometry geometry = rtcNewGeometry(scene_->device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(spheres_.size()));
  std::pair<const std::vector<HotSphere>*, Vec3d> user{&spheres_, origin_};
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
  Query query;
  rtcInitIntersectContext(&query.context);
  query.spheres = &spheres_;
  query.ray = &ray;
  RTCRayHit hit{};
  const Vec3d o = ray.origin - origin_;
  hit.ray.org_x = static_cast<float>(o.x);
  hit.ray.org_y = static_cast<float>(o.y);
  hit.ray.org_z = static_cast<float>(o.z);
  hit.ray.dir_x = static_cast<float>(ray.direction.x);
  hit.ray.dir_y = static_cast<float>(ray.direction.y);
  hit.ray.dir_z = static_cast<float>(ray.direction.z);
  hit.ray.tnear = static_cast<float>(std::max(0.0, ray.t_min * (1 - 1e-6)));
  hit.ray.tfar = static_cast<float>(ray.t_max * (1 + 1e-6));
  hit.ray.mask = ~0u;
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene_->scene, &query.context, &hit);
  return query.best;
}

}  // namespace obscura
