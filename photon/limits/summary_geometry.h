// Where things lie to one another, conservatively: what no camera ray meets, what no sunlight reaches.
#pragma once

#include <vector>

#include "photon/limits/media_summary.h"

namespace obscura::detail {

/// The eight corners of a cloud's box in the world; empty where it holds nothing.
std::vector<Vec3d> corners_of(const World& world, int cloud);

/// The convex hull of the points lies outside what the view sees. False also where that is not certain.
bool outside(const CameraView& view, const std::vector<Vec3d>& points);

/// The box of all clouds, objects and spheres, m; nothing where the view may see any of them, or where there is none.
std::optional<Box3d> box_out_of_view(const World& world, const CameraView& view);

/// Farthest that two of the view's origins, clouds, objects and spheres can be from one another, m.
double reach(const World& world, const CameraView& view);

/// A camera ray may end on the disc of a sun.
bool sees_disc(const CameraView& view, const Sun& sun);

/// An opaque rectangle (a mesh of two triangles) lies between the sun and everything else: clouds, objects, spheres and
/// the view's origins, whose boxes fall inside it along every direction to the disc.
bool shaded(const World& world, const CameraView& view, const Sun& sun);

/// No ray can end on the black back of a one-sided surface: every object is a sphere or a closed mesh that the view
/// is outside of, or has two sides.
bool no_dark_backs(const World& world, const CameraView& view);

}  // namespace obscura::detail
