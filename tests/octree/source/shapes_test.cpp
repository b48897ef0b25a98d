// Shapes: exact volumes, symmetry, and the right answers at awkward sizes.
#include "octree/source/shapes.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "octree/base/error.h"
#include "tests/support/dense_stream.h"

using namespace obscura;
using obscura::test::Dense;

TEST_CASE("a sphere's cells add up to its volume", "[octree][shapes]") {
  for (const auto& [radius, voxel] : {std::pair(1.0, 0.1), {1.0, 0.37}, {0.5, 2.0}, {20.0, 0.61}}) {
    const Dense dense(sphere_stream(radius, voxel));
    const double volume = 4.0 / 3 * kPi * std::pow(radius, 3);
    INFO("radius " << radius << " voxel " << voxel);
    CHECK(dense.sum(0) * std::pow(voxel, 3) == Approx(volume).epsilon(3e-8));
    CHECK(dense.max(0) <= 1.0f);
  }
}

TEST_CASE("the part of a unit sphere in a box is exact", "[octree][shapes]") {
  using detail::unit_sphere_in_box;
  // A cap of height h has pi h^2 (3 - h) / 3; an octant an eighth; a box inside its own volume.
  CHECK(unit_sphere_in_box(Vec3d(-2, -2, 0.3), Vec3d(2, 2, 2)) == Approx(kPi * 0.49 * 2.3 / 3).epsilon(1e-12));
  CHECK(unit_sphere_in_box(Vec3d(0.3, -2, -2), Vec3d(2, 2, 2)) == Approx(kPi * 0.49 * 2.3 / 3).epsilon(1e-9));
  CHECK(unit_sphere_in_box(Vec3d(0), Vec3d(1)) == Approx(kPi / 6).epsilon(1e-12));
  CHECK(unit_sphere_in_box(Vec3d(-0.1), Vec3d(0.2)) == Approx(0.027).epsilon(1e-12));
  CHECK(std::abs(unit_sphere_in_box(Vec3d(0.6), Vec3d(1))) < 1e-15);
  // Splitting a box does not change the sum.
  const Vec3d low(0.5, 0.4, 0.6), high(0.7, 0.6, 0.8);
  const double whole = unit_sphere_in_box(low, high);
  double parts = 0;
  for (int child = 0; child < 8; ++child) {
    const Vec3d half(0.1), corner = low + half * Vec3d(child & 1, (child >> 1) & 1, child >> 2);
    parts += unit_sphere_in_box(corner, corner + half);
  }
  CHECK(whole > 0);
  CHECK(parts == Approx(whole).epsilon(1e-9));
}

TEST_CASE("a sphere is symmetric to the last bit", "[octree][shapes]") {
  const Dense dense(sphere_stream(1.0, 0.13));
  const Vec3i n = dense.size();
  for (int i = 0; i < 400; ++i) {
    const Vec3i v((i * 7) % n.x, (i * 11) % n.y, (i * 13) % n.z);
    CHECK(dense.at(0, v) == dense.at(0, n - Vec3i(1) - v));
    CHECK(dense.at(0, v) == dense.at(0, Vec3i(n.x - 1 - v.x, v.y, v.z)));
  }
}

TEST_CASE("a box holds exact fractions in its border cells", "[octree][shapes]") {
  const Dense whole(box_stream(Vec3d(1, 0.5, 2), 0.1));
  CHECK(whole.size() == Vec3i(10, 5, 20));
  CHECK(whole.min(0) == 1.0f);
  CHECK(whole.max(0) == 1.0f);

  const Dense odd(box_stream(Vec3d(1, 1, 1), 0.3));  // 3.33 cells in 4: two cells of 2/3 on each side
  CHECK(odd.size() == Vec3i(4));
  CHECK(odd.at(0, Vec3i(0, 1, 1)) == Approx(2.0 / 3));
  CHECK(odd.sum(0) * 0.027 == Approx(1).epsilon(1e-7));

  const Dense thin(box_stream(Vec3d(0.1, 1, 1), 1));
  CHECK(thin.size() == Vec3i(1));
  CHECK(thin.at(0, Vec3i(0)) == Approx(0.1));
}

TEST_CASE("a gaussian has the exact mass inside its box", "[octree][shapes]") {
  const double sigma = 0.5;
  const Vec3d size(4, 3, 2.05);
  double mass = 1;
  for (int axis = 0; axis < 3; ++axis)
    mass *= sigma * std::sqrt(2 * kPi) * std::erf(size[axis] / 2 / (sigma * std::sqrt(2)));
  for (const double voxel : {0.05, 0.17}) {
    const Dense dense(gaussian_stream(sigma, size, voxel));
    CHECK(dense.sum(0) * std::pow(voxel, 3) == Approx(mass).epsilon(1e-7));
  }
  // Cell means tend to the peak of 1 with the square of the voxel: a factor 1 - h^2 / (6 sigma^2) per axis.
  const Dense fine(gaussian_stream(sigma, Vec3d(4), 0.1));
  CHECK(fine.max(0) == Approx(std::pow(1 - 0.01 / (6 * sigma * sigma), 3)).epsilon(3e-4));
}

TEST_CASE("shapes are centred on the origin", "[octree][shapes]") {
  for (const VoxelStream& stream :
       {sphere_stream(1, 0.3), box_stream(Vec3d(1, 2, 3), 0.4), gaussian_stream(1, Vec3d(3), 0.2)}) {
    const Vec3d centre = Vec3d(stream.bounds.min + stream.bounds.max) * 0.5;
    CHECK(transform_point(stream.index_to_local, centre).length() < 1e-12);
  }
}

TEST_CASE("impossible shapes are refused", "[octree][shapes][not_finite]") {
  CHECK_THROWS_AS(sphere_stream(0, 0.1), InputError);
  CHECK_THROWS_AS(sphere_stream(1, -0.1), InputError);
  CHECK_THROWS_AS(sphere_stream(1, std::nan("")), InputError);
  CHECK_THROWS_AS(box_stream(Vec3d(1, 0, 1), 0.1), InputError);
  CHECK_THROWS_AS(gaussian_stream(1, Vec3d(1e9), 1e-3), InputError);
}
