// An index of all faces for the conservative queries of a ray spot: a hierarchy of their boxes, and which faces share
// an edge. Made once for a World's surfaces, when it is first asked for.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "octree/base/math.h"
#include "photon/world/box_tree.h"
#include "photon/world/object.h"

namespace obscura {

/// A sphere of an object or a hot one, about the local origin.
struct Ball {
  Vec3d center;
  double radius;
  std::uint32_t surface;
  bool seen_from_inside;
};

/// Of one mesh, in its own metres. 32 bytes a face.
struct MeshIndex {
  explicit MeshIndex(const Mesh& mesh);

  Vec3d middle{0, 0, 0};
  BoxTree tree;  ///< of the faces, about the middle
  /// Side 3 * face + corner begins at that corner of the face. For each side, the next one between the same two places
  /// (equal positions, however the vertices are numbered); itself where there is no other.
  std::vector<std::uint32_t> next_side;
};

/// Immutable; thread-safe. Positions are about the Surfaces' local origin.
class FaceIndex {
 public:
  /// @param to_scene  per object, from its own metres to metres about the local origin
  /// @param balls     the spheres, in the order of their surfaces
  FaceIndex(std::span<const Object> objects, std::span<const Affine> to_scene, std::span<const Ball> balls,
            const Vec3d& origin);

  std::span<const Object> objects() const noexcept { return objects_; }
  std::span<const Ball> balls() const noexcept { return balls_; }
  const Vec3d& origin() const noexcept { return origin_; }
  const Affine& to_scene(std::uint32_t object) const noexcept { return to_scene_[object]; }
  const MeshIndex* mesh(std::uint32_t object) const noexcept { return of_object_[object]; }
  const Ball& ball(std::uint32_t surface) const noexcept;

  /// The tree of objects and balls; entries() names what its indices are: a mesh's object, or a ball.
  const BoxTree& tree() const noexcept { return tree_; }
  struct Entry {
    std::uint32_t object = 0;
    const Ball* ball = nullptr;  ///< none: a mesh
  };
  std::span<const Entry> entries() const noexcept { return entries_; }

  std::array<Vec3d, 3> corners(std::uint32_t object, std::uint32_t face) const noexcept {
    const Mesh& mesh = *objects_[object].mesh;
    const std::array<std::uint32_t, 3>& f = mesh.faces[face];
    const Affine& map = to_scene_[object];
    return {transform_point(map, mesh.vertices[f[0]]), transform_point(map, mesh.vertices[f[1]]),
            transform_point(map, mesh.vertices[f[2]])};
  }

  /// The largest coordinate of anything about the local origin, m.
  double reach() const noexcept { return reach_; }
  std::size_t bytes() const noexcept;

 private:
  std::span<const Object> objects_;
  std::span<const Affine> to_scene_;
  std::span<const Ball> balls_;
  Vec3d origin_;
  std::vector<std::unique_ptr<MeshIndex>> meshes_;
  std::vector<const MeshIndex*> of_object_;
  std::vector<Entry> entries_;
  BoxTree tree_;
  double reach_ = 0;
};

}  // namespace obscura
