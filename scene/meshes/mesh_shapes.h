// The scene's shapes that are made of triangles; a sphere is an Object of its own.
#pragma once

#include <array>

#include "photon/world/object.h"

namespace obscura {

/// Two triangles in z = 0 about the origin that face up. @param size_m along x and y
Mesh plane_mesh(const std::array<double, 2>& size_m);

/// Twelve triangles about the origin that face outward.
Mesh box_mesh(const Vec3d& size_m);

}  // namespace obscura
