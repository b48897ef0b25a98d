// Export: round trips without loss, tiles, and files that appear whole or not at all.
#include "octree/io/export.h"

#include <catch2/catch.hpp>

#include "octree/base/error.h"
#include "octree/build/build.h"
#include "octree/io/import.h"
#include "octree/source/octree_stream.h"
#include "octree/source/puffs.h"
#include "octree/source/shapes.h"
#include "tests/support/dense_stream.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shared_data.h"

using namespace obscura;
using namespace obscura::test;

namespace {

Octree lossless(const VoxelStream& stream) { return build_octree(stream, {.tolerance = 0, .measure = {}}).first; }

/// Both streams hold the same values at the same places.
void require_equal(const VoxelStream& a, const VoxelStream& b) {
  REQUIRE(a.channels == b.channels);
  const Dense x(a), y(b);
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 3; ++column)
      CHECK(a.index_to_local[row][column] == Approx(b.index_to_local[row][column]).margin(1e-9));
  for (std::size_t c = 0; c < a.channels.size(); ++c) {
    CHECK(x.nonzero(c) == y.nonzero(c));
    CHECK(x.sum(c) == y.sum(c));
    const Vec3i shift = a.bounds.min - b.bounds.min, n = x.size(), m = y.size();
    for (int k = 0; k < n.z; ++k)
      for (int j = 0; j < n.y; ++j)
        for (int i = 0; i < n.x; ++i) {
          const Vec3i in = Vec3i(i, j, k) + shift;
          const bool inside = in.x >= 0 && in.y >= 0 && in.z >= 0 && in.x < m.x && in.y < m.y && in.z < m.z;
          REQUIRE(x.at(c, {i, j, k}) == (inside ? y.at(c, in) : 0.0f));
        }
  }
}

}  // namespace

TEST_CASE("import, octree, export and import again lose nothing", "[octree][export]") {
  const ScratchFolder folder;
  for (const char* name : {"data/les_rico_jpl/rico32x37x26.vdb", "data/wdas_cloud_sixteenth/wdas_cloud_sixteenth.vdb",
                           "data/blender_plume_sequence/fluid_data_0030.vdb"}) {
    const auto file = shared_file(name);
    if (file.empty()) continue;
    std::vector<std::string> grids;
    for (const GridInfo& grid : inspect_volume(file))
      if (grid.scalar && grid.min >= 0) grids.push_back(grid.name);
    const VoxelStream original = open_volume(file, grids).at(0);
    const Octree octree = lossless(original);
    write_vdb(folder / "out.vdb", octree);
    INFO(name);
    require_equal(original, open_volume(folder / "out.vdb", grids).at(0));
    CHECK_FALSE(std::filesystem::exists(folder / "out.vdb.partial"));
  }
}

TEST_CASE("coarse leaves become tiles", "[octree][export]") {
  const ScratchFolder folder;
  write_vdb(folder / "box.vdb", lossless(box_stream(Vec3d(25.6), 0.2)));
  const GridInfo info = inspect_volume(folder / "box.vdb").at(0);
  CHECK(info.resolution == Vec3i(128));
  CHECK(info.active == 128ull * 128 * 128);
  CHECK(info.leaves == 0);
  CHECK(info.tiles > 0);
  CHECK((transform_point(info.index_to_local, Vec3d(info.bounds.min)) + Vec3d(12.8)).length() < 1e-9);
  CHECK(info.voxel_m.x == Approx(0.2));
}

TEST_CASE("an octree's stream builds the same octree", "[octree][export]") {
  PuffSettings settings;
  settings.sources = {{{0, 0, 0}, 50, 10, 600}};
  settings.wind_m_s = {1, 0, 0};
  settings.age_s = 4;
  const VoxelStream stream = puffs_stream(settings);
  const auto octree = std::make_shared<const Octree>(lossless(stream));
  require_equal(stream, octree_stream(octree));
  const ScratchFolder folder;
  write_vdb(folder / "puffs.vdb", *octree, {.half = true, .metadata = {{"made_by", "a test"}}});
  CHECK(inspect_volume(folder / "puffs.vdb").at(0).type == "half");
}

TEST_CASE("a failed export leaves what was there", "[octree][export]") {
  const ScratchFolder folder;
  CHECK_THROWS_AS(write_vdb(folder / "no/such/folder/a.vdb", box_stream(Vec3d(1), 0.1)), ResourceError);
}

TEST_CASE("other forms are measured by making them", "[octree][export]") {
  const OtherForms forms = measure_other_forms(gaussian_stream(1, Vec3d(6.4), 0.1));
  // 64^3 floats in 8^3 leaves: their values, their masks, and the nodes above.
  CHECK(forms.bytes_nanovdb > 64 * 64 * 64 * 4);
  CHECK(forms.bytes_nanovdb < 64 * 64 * 64 * 4 * 1.5);
  CHECK(forms.bytes_nanovdb_fp8 < forms.bytes_nanovdb);
  CHECK(forms.bytes_openvdb > 64 * 64 * 64 * 4);
}
