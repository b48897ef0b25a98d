// Making the scene that rays meet: meshes as instances, balls as Embree's user geometry, and the callbacks in which its
// float candidates are judged in double.
#include <algorithm>
#include <limits>
#include <map>
#include <string>

#include "octree/base/error.h"
#include "photon/world/surfaces_scene-inl.h"

namespace obscura {
namespace {

using detail::SurfaceQuery;

/// Where the ray passes through a sphere in double, or +inf: the numerically stable roots of the quadratic
/// (Haines et al., "Precision improvements for ray/sphere intersection", Ray Tracing Gems, 2019).
/// @param on_it the ray starts on this sphere
double ball_distance(const Ray& ray, const Ball& ball, bool on_it) noexcept {
  const Vec3d to_origin = ray.origin - ball.center;
  const double b = -to_origin.dot(ray.direction);
  const Vec3d closest = to_origin + b * ray.direction;
  const double discriminant = ball.radius * ball.radius - closest.dot(closest);
  if (discriminant <= 0) return kInfinity;
  const double root = std::sqrt(discriminant);
  const double c = to_origin.dot(to_origin) - ball.radius * ball.radius;
  double t = kInfinity;
  // What starts on the sphere but for rounding and goes outward leaves it.
  const double rounding =
      16 * std::numeric_limits<double>::epsilon() * ball.radius * (ray.origin.length() + ball.center.length());
  if (b <= 0 && c >= -rounding) return kInfinity;
  if (on_it) {
    t = b + root;  // across the inside, if it goes there at all
    if (!ball.seen_from_inside || !(b > 0)) return kInfinity;
  } else if (c <= 0) {  // starts inside
    if (!ball.seen_from_inside) return kInfinity;
    t = b + root;
  } else {
    t = b > 0 ? c / (b + root) : kInfinity;
    if (t <= ray.t_min && ball.seen_from_inside && b > 0) t = b + root;
  }
  return t > ray.t_min && t < ray.t_max ? t : kInfinity;
}

/// The triangle's plane in double; Embree has said that the ray passes through it.
bool judge_triangle(const std::array<Vec3d, 3>& p, const Ray& ray, double& t, double& u, double& v) noexcept {
  const Vec3d e1 = p[1] - p[0];
  const Vec3d e2 = p[2] - p[0];
  const Vec3d n = e1.cross(e2);
  const double n2 = n.dot(n);
  const double along = n.dot(ray.direction);
  if (along == 0 || !(n2 > 0)) return false;
  const Vec3d to_corner = p[0] - ray.origin;
  t = n.dot(to_corner) / along;
  if (!(t > ray.t_min && t < ray.t_max)) return false;
  const Vec3d q = t * ray.direction - to_corner;
  u = std::clamp(q.cross(e2).dot(n) / n2, 0.0, 1.0);
  v = std::clamp(e1.cross(q).dot(n) / n2, 0.0, 1.0 - u);
  return true;
}

/// Embree's callbacks, which may look into the scene.
struct SurfaceCallbacks {
  template <class Scene>
  static void filter(const RTCFilterFunctionNArguments* args) {
    if (!args->valid[0]) return;
    auto* query = reinterpret_cast<SurfaceQuery*>(args->context);
    const auto& scene = *static_cast<const Scene*>(query->scene);
    const FaceId id{RTCHitN_instID(args->hit, 1, 0, 0), RTCHitN_primID(args->hit, 1, 0)};
    double t, u, v;
    if (id == query->from || !judge_triangle(scene.corners(id.surface, id.face), query->ray, t, u, v)) {
      args->valid[0] = 0;
      return;
    }
    query->offer(t, id, u, v);
    RTCRayN_tfar(args->ray, 1, 0) = query->reach();
  }

  template <class Scene>
  static bool meet_ball(SurfaceQuery* query, unsigned index) {
    const auto& scene = *static_cast<const Scene*>(query->scene);
    const Ball& ball = scene.balls[index];
    const FaceId id{ball.surface, 0};
    const double t = ball_distance(query->ray, ball, id == query->from);
    return t < kInfinity && query->offer(t, id, 0, 0);
  }
  template <class Scene>
  static void intersect(const RTCIntersectFunctionNArguments* args) {
    if (!args->valid[0]) return;
    auto* query = reinterpret_cast<SurfaceQuery*>(args->context);
    if (!meet_ball<Scene>(query, args->primID)) return;
    auto* hit = reinterpret_cast<RTCRayHit*>(args->rayhit);
    hit->ray.tfar = query->reach();
    hit->hit.geomID = args->geomID;
    hit->hit.primID = args->primID;
  }
  template <class Scene>
  static void occlude(const RTCOccludedFunctionNArguments* args) {
    if (!args->valid[0]) return;
    auto* query = reinterpret_cast<SurfaceQuery*>(args->context);
    if (meet_ball<Scene>(query, args->primID)) {
      reinterpret_cast<RTCRay*>(args->ray)->tfar = -std::numeric_limits<float>::infinity();
    }
  }

  template <class Scene>
  static void bounds(const RTCBoundsFunctionArguments* args) {
    const auto& scene = *static_cast<const Scene*>(args->geometryUserPtr);
    const Ball& ball = scene.balls[args->primID];
    const double pad = ball.radius + scene.pad;
    const Vec3f low(ball.center - Vec3d(pad)), high(ball.center + Vec3d(pad));
    *args->bounds_o = {low.x, low.y, low.z, 0, high.x, high.y, high.z, 0};
  }
};

/// A mesh's own Embree scene, about the middle of its bounds; the objects that share it are instances.
RTCScene make_mesh_scene(RTCDevice device, const Mesh& mesh, const Vec3d& middle, RTCFilterFunctionN filter) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                               3 * sizeof(float), mesh.vertices.size()));
  if (!vertices) throw ResourceError("surfaces", "no memory for a mesh's vertices", "use a mesh of fewer triangles");
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      vertices[3 * i + static_cast<std::size_t>(axis)] = static_cast<float>(mesh.vertices[i][axis] - middle[axis]);
    }
  }
  // The faces are read where they are.
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.faces.data(), 0,
                             sizeof(mesh.faces[0]), mesh.faces.size());
  rtcSetGeometryIntersectFilterFunction(geometry, filter);
  rtcSetGeometryOccludedFilterFunction(geometry, filter);
  rtcCommitGeometry(geometry);
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  return scene;
}

}  // namespace

Box3d bounds_of(const Object& object) noexcept {
  Box3d box;
  if (!object.mesh) {
    const Vec3d center = transform_point(object.local_to_world, Vec3d(0));
    const double radius = object.radius * std::cbrt(std::abs(linear_determinant(object.local_to_world)));
    return {center - Vec3d(radius), center + Vec3d(radius)};
  }
  for (const auto& face : object.mesh->faces) {
    for (const std::uint32_t vertex : face) box.extendBy(object.mesh->vertices[vertex]);
  }
  return box.isEmpty() ? box : transform_box(object.local_to_world, box);
}

Surfaces::Surfaces(std::span<const Object> objects, std::span<const HotSphere> spheres, const Vec3d& origin) {
  auto scene = std::make_unique<Scene>();
  scene->objects = objects;
  scene->origin = origin;
  scene->to_scene.resize(objects.size());
  double farthest = 0;
  const auto extend = [&](const Box3d& world) {
    if (world.isEmpty()) return;
    scene->bounds.extendBy(world.min - origin);
    scene->bounds.extendBy(world.max - origin);
  };
  std::size_t faces = 0;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const Object& object = objects[i];
    extend(bounds_of(object));
    scene->to_scene[i] = object.local_to_world;
    for (int axis = 0; axis < 3; ++axis) scene->to_scene[i][3][axis] -= origin[axis];
    if (object.mesh) {
      faces += object.mesh->faces.size();
    } else {
      const double scale = std::cbrt(std::abs(linear_determinant(object.local_to_world)));
      scene->balls.push_back(
          {transform_point(scene->to_scene[i], Vec3d(0)), object.radius * scale, static_cast<std::uint32_t>(i), true});
    }
  }
  for (std::size_t s = 0; s < spheres.size(); ++s) {
    const HotSphere& sphere = spheres[s];
    extend({sphere.center - Vec3d(sphere.radius), sphere.center + Vec3d(sphere.radius)});
    scene->balls.push_back(
        {sphere.center - origin, sphere.radius, static_cast<std::uint32_t>(objects.size() + s), false});
  }
  if (scene->bounds.isEmpty()) return;
  for (int axis = 0; axis < 3; ++axis) {
    farthest = std::max({farthest, std::abs(scene->bounds.min[axis]), std::abs(scene->bounds.max[axis])});
  }
  scene->pad = 1e-6 * farthest;
  scene->tie = 1e-12 * farthest;
  // Positions on surfaces are rounded in the scene's size and, far from the world's origin, in the distance.
  clearance_ = 1e-11 * farthest + 16 * std::numeric_limits<double>::epsilon() * origin.length();

  // Without a number of threads, which Embree would take for the limit of the whole program.
  scene->device = rtcNewDevice(nullptr);
  scene->scene = rtcNewScene(scene->device);
  rtcSetSceneFlags(scene->scene, RTC_SCENE_FLAG_ROBUST);

  std::map<const Mesh*, std::pair<RTCScene, Vec3d>> meshes;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const Mesh* mesh = objects[i].mesh.get();
    if (!mesh || mesh->faces.empty()) continue;
    auto found = meshes.find(mesh);
    if (found == meshes.end()) {
      Box3d box;
      for (const auto& face : mesh->faces) {
        for (const std::uint32_t vertex : face) box.extendBy(mesh->vertices[vertex]);
      }
      const Vec3d middle = box.center();
      const RTCScene own = make_mesh_scene(scene->device, *mesh, middle, SurfaceCallbacks::filter<Scene>);
      scene->mesh_scenes.push_back(own);
      found = meshes.emplace(mesh, std::pair(own, middle)).first;
    }
    const Affine& map = scene->to_scene[i];
    const Vec3d shift = transform_point(map, found->second.second);
    float columns[12];  // of Embree's column-major 3 x 4 matrix
    for (int row = 0; row < 3; ++row) {
      for (int axis = 0; axis < 3; ++axis) columns[3 * row + axis] = static_cast<float>(map[row][axis]);
      columns[9 + row] = static_cast<float>(shift[row]);
    }
    RTCGeometry instance = rtcNewGeometry(scene->device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, found->second.first);
    rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
    rtcCommitGeometry(instance);
    rtcAttachGeometryByID(scene->scene, instance, static_cast<unsigned>(i));
    rtcReleaseGeometry(instance);
  }
  if (!scene->balls.empty()) {
    RTCGeometry geometry = rtcNewGeometry(scene->device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(scene->balls.size()));
    rtcSetGeometryUserData(geometry, scene.get());
    rtcSetGeometryBoundsFunction(geometry, SurfaceCallbacks::bounds<Scene>, nullptr);
    rtcSetGeometryIntersectFunction(geometry, SurfaceCallbacks::intersect<Scene>);
    rtcSetGeometryOccludedFunction(geometry, SurfaceCallbacks::occlude<Scene>);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene->scene, geometry, static_cast<unsigned>(objects.size()));
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(scene->scene);
  if (rtcGetDeviceError(scene->device) != RTC_ERROR_NONE) {
    throw ResourceError("surfaces", "Embree could not build " + std::to_string(faces) + " triangles",
                        "use meshes of fewer triangles, or free memory");
  }
  scene_ = std::move(scene);
}

}  // namespace obscura
