// What surfaces are made from: triangle meshes or spheres, placed in the World, with material and
// temperature. Plain arrays; whoever reads files fills them in.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "octree/base/math.h"
#include "photon/optics/material.h"

namespace obscura {

/// Triangles in their own metres. Objects that are copies of one another share it.
struct Mesh {
  std::vector<Vec3d> vertices;                      ///< m
  std::vector<std::array<std::uint32_t, 3>> faces;  ///< vertices, counter-clockwise seen from the front
  std::vector<std::uint16_t> slots;                 ///< per face, which of the object's materials; empty: the first
  std::vector<float> vertex_K;                      ///< kelvin per vertex, linear over a face; or
  std::vector<float> face_K;                        ///< per face; NaN in either: the object's. Both empty: the object's
};

/// A mesh or a sphere in the World.
struct Object {
  std::string name;
  std::shared_ptr<const Mesh> mesh;  ///< none: a sphere about the origin
  double radius = 0;                 ///< of the sphere, m
  Affine local_to_world;             ///< rotation, translation and uniform scale
  std::vector<int> materials{0};     ///< index into the World's, for each slot of the mesh
  std::vector<double> K{0};          ///< for each slot; 0: emits nothing
  /// Per interval, the black body's radiance in place of Planck's, W/m2/sr; nothing, or an empty list:
  /// Planck.
  std::vector<std::optional<double>> radiance;
  /// false: the back emits nothing and absorbs everything; true: both sides emit and reflect.
  bool double_sided = false;
};

}  // namespace obscura
