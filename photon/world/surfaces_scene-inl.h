// The scene behind Surfaces and a ray on its way through it. The only header that knows Embree: for surfaces.cpp and
// surfaces_build.cpp alone.
#pragma once

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "photon/world/face_index.h"
#include "photon/world/surfaces.h"

namespace obscura {

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

namespace detail {

/// A ray on its way through Embree, whose float candidates are judged here in double.
struct SurfaceQuery {
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

}  // namespace detail

}  // namespace obscura
