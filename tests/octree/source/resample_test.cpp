// Joining streams of different lattices.
#include "octree/source/resample.h"

#include <array>
#include <catch2/catch.hpp>

#include "octree/source/shapes.h"
#include "tests/support/dense_stream.h"

using namespace obscura;
using obscura::test::Dense;

namespace {

/// A field that is linear in space, on a lattice of its own, in one block of bricks.
VoxelStream linear_field(double voxel_m, int bricks) {
  VoxelStream stream;
  stream.channels = {"temperature"};
  stream.background = {290.0f};
  stream.index_to_local.setScale(voxel_m);
  for (int axis = 0; axis < 3; ++axis) stream.index_to_local[3][axis] = -4 * voxel_m * bricks;
  stream.bounds = Box3i(Vec3i(0), Vec3i(8 * bricks));
  stream.pour = [=, map = stream.index_to_local](VoxelSink& sink) {
    for (int b = 0; b < bricks * bricks * bricks; ++b) {
      const Vec3i corner = Vec3i(b % bricks, b / bricks % bricks, b / (bricks * bricks)) * 8;
      std::array<float, 512> values;
      for (int v = 0; v < 512; ++v) {
        const Vec3d p = transform_point(map, Vec3d(corner + Vec3i(v & 7, (v >> 3) & 7, v >> 6)) + Vec3d(0.5));
        values[v] = static_cast<float>(300 + 3 * p.x - 2 * p.y + p.z);
      }
      const float* pointer = values.data();
      sink.brick(corner, &pointer);
    }
  };
  return stream;
}

}  // namespace

TEST_CASE("resampling a linear field is exact", "[octree][resample]") {
  VoxelStream field = linear_field(0.13, 3);
  field.units = {"K"};
  const VoxelStream joined = resample(box_stream(Vec3d(1.6, 1.6, 1.6), 0.05), field);
  CHECK(joined.channels == std::vector<std::string>{"density", "temperature"});
  CHECK(joined.units == std::vector<std::string>{"", "K"});
  const Dense dense(joined);
  CHECK(dense.outside() == 0);
  CHECK(dense.twice() == 0);
  const Vec3i n = dense.size();
  int inside = 0;
  for (int z = 0; z < n.z; z += 3)
    for (int y = 0; y < n.y; y += 3)
      for (int x = 0; x < n.x; x += 3) {
        if (dense.at(0, {x, y, z}) == 0) continue;
        const Vec3d p = transform_point(joined.index_to_local, Vec3d(joined.bounds.min + Vec3i(x, y, z)) + Vec3d(0.5));
        REQUIRE(dense.at(1, {x, y, z}) == Approx(300 + 3 * p.x - 2 * p.y + p.z).margin(1e-3));
        ++inside;
      }
  CHECK(inside > 1000);
}

TEST_CASE("outside its voxels a field has its background", "[octree][resample]") {
  // A box far larger than the field: its tiles are split only near the field.
  const Dense dense(resample(box_stream(Vec3d(12.8, 12.8, 12.8), 0.1), linear_field(0.1, 1)));
  CHECK(dense.at(0, {0, 0, 0}) == 1.0f);
  CHECK(dense.at(1, {0, 0, 0}) == 290.0f);
  CHECK(dense.at(1, {64, 64, 64}) == Approx(300.1).margin(0.01));
  CHECK(dense.tiles() > 0);
  CHECK(dense.twice() == 0);
}

TEST_CASE("on the same lattice resampling returns the same bits", "[octree][resample]") {
  const VoxelStream gaussian = gaussian_stream(0.5, Vec3d(2), 0.1);
  const Dense dense(resample(gaussian, gaussian));
  CHECK(dense.sum(0) > 0);
  CHECK(dense.values(0) == dense.values(1));
}
