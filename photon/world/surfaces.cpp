#include "photon/world/surfaces.h"

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <string>

#include "octree/base/error.h"
#include "photon/world/face_index.h"

namespace obscura {
namespace {

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

}  // namespace

struct Surfaces::Scene {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<RTCScene> mesh_scenes;
  std::span<const Object> objects;
  std::vector<Affine> to_scene;  // per object: from its own metres to metres about the local origin
  std::vector<Ball> balls;
  Vec3d origin{0, 0, 0};
  Box3d bounds;    // about the local origin
  double pad = 0;  // m: what float rounds away
  double tie = 0;  // m: hits nearer to one another than this are at the same distance
  mutable std::once_flag index_once;
  mutable std::unique_ptr<FaceIndex> index;

  ~Scene() {
    if (scene) rtcReleaseScene(scene);
    for (const RTCScene mesh : mesh_scenes) rtcReleaseScene(mesh);
    if (device) rtcReleaseDevice(device);
  }

  std::array<Vec3d, 3> corners(std::uint32_t object, std::uint32_t face) const noexcept {
    const Mesh& mesh = *objects[object].mesh;
    const std::array<std::uint32_t, 3>& f = mesh.faces[face];
    const Affine& map = to_scene[object];
    return {transform_point(map, mesh.vertices[f[0]]), transform_point(map, mesh.vertices[f[1]]),
            transform_point(map, mesh.vertices[f[2]])};
  }
  const Ball& ball(std::uint32_t surface) const noexcept {
    return *std::lower_bound(balls.begin(), balls.end(), surface,
                             [](const Ball& ball, std::uint32_t s) { return ball.surface < s; });
  }
};

namespace {

/// A ray on its way through Embree, whose float candidates are judged here in double.
struct Query {
  RTCIntersectContext context;  // first: Embree hands back a pointer to it
  const void* scene;
  Ray ray;  // about the local origin
  FaceId from;
  double shift;  // m along the ray, to where Embree's starts
  double pad, tie;
  SurfaceHit best;

  /// Takes the hit if it is nearer than the best, or as near and of a lower name.
  bool offer(double t, const FaceId& id, double u, double v) noexcept {
    const bool same = best.exists() && std::abs(t - best.t) <= tie;
    if (!(same ? id < best.id : t < best.t)) return false;
    best = {t, id, u, v};
    return true;
  }
  /// How far Embree has to go on looking.
  float reach() const noexcept { return static_cast<float>(best.t - shift + pad); }
};

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

}  // namespace

/// Embree's callbacks, which may look into the scene.
struct SurfaceCallbacks {
  template <class Scene>
  static void filter(const RTCFilterFunctionNArguments* args) {
    if (!args->valid[0]) return;
    auto* query = reinterpret_cast<Query*>(args->context);
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
  static bool meet_ball(Query* query, unsigned index) {
    const auto& scene = *static_cast<const Scene*>(query->scene);
    const Ball& ball = scene.balls[index];
    const FaceId id{ball.surface, 0};
    const double t = ball_distance(query->ray, ball, id == query->from);
    return t < kInfinity && query->offer(t, id, 0, 0);
  }
  template <class Scene>
  static void intersect(const RTCIntersectFunctionNArguments* args) {
    if (!args->valid[0]) return;
    auto* query = reinterpret_cast<Query*>(args->context);
    if (!meet_ball<Scene>(query, args->primID)) return;
    auto* hit = reinterpret_cast<RTCRayHit*>(args->rayhit);
    hit->ray.tfar = query->reach();
    hit->hit.geomID = args->geomID;
    hit->hit.primID = args->primID;
  }
  template <class Scene>
  static void occlude(const RTCOccludedFunctionNArguments* args) {
    if (!args->valid[0]) return;
    auto* query = reinterpret_cast<Query*>(args->context);
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

Surfaces::Surfaces() = default;
Surfaces::~Surfaces() = default;
Surfaces::Surfaces(Surfaces&&) noexcept = default;
Surfaces& Surfaces::operator=(Surfaces&&) noexcept = default;

namespace {

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

namespace {

/// Embree's ray starts beside the surfaces, not at the ray's origin: in float a ray from afar would pass
/// them by. False where it misses their bounds.
template <class Scene>
bool start(Query& query, RTCRay& out, const Scene& scene, const Ray& ray, FaceId from) noexcept {
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
  Query query;
  RTCRayHit hit;
  if (!start(query, hit.ray, *scene_, ray, from)) return {};
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene_->scene, &query.context, &hit);
  return query.best;
}

bool Surfaces::occluded(const Ray& ray, FaceId from) const noexcept {
  if (!scene_) return false;
  Query query;
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
