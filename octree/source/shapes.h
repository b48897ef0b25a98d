// Clouds of simple shape as voxels, each with one channel "density" and centred on the origin.
#pragma once

#include "octree/source/voxels.h"

namespace obscura {

/// Density 1 inside a sphere; a border cell holds its exact volume fraction (to 1e-9 of a cell), so
/// that the mass is 4/3 pi r^3. The lattice has an even or odd number of cells, ceil(2 r / voxel).
/// @throws InputError where a length is not positive and finite or the lattice would be too large.
VoxelStream sphere_stream(double radius_m, double voxel_m);

/// Density 1 inside a box; border cells hold exact fractions where voxel_m doesn't divide the size.
VoxelStream box_stream(const Vec3d& size_m, double voxel_m);

/// exp(-r^2 / (2 sigma^2)) inside a box, 0 outside; a cell holds the exact mean over itself, so that
/// the mass is exact and a ray's optical depth converges with the square of the voxel.
VoxelStream gaussian_stream(double sigma_m, const Vec3d& size_m, double voxel_m);

namespace detail {

/// Volume of the unit sphere inside the box [low, high].
double unit_sphere_in_box(const Vec3d& low, const Vec3d& high) noexcept;

}  // namespace detail
}  // namespace obscura
