// Reading OpenVDB files: real ones against the figures their sources state, and broken ones.
#include <catch2/catch.hpp>

#include "octree/base/error.h"
#include "octree/io/import.h"
#include "tests/support/dense_stream.h"
#include "tests/support/shared_data.h"

using namespace obscura;
using obscura::test::Dense;
using obscura::test::shared_file;

namespace {

const GridInfo& find(const std::vector<GridInfo>& grids, const std::string& name) {
  for (const GridInfo& grid : grids)
    if (grid.name == name) return grid;
  FAIL("no grid " << name);
  return grids.front();
}

}  // namespace

TEST_CASE("the WDAS cloud is read with its tiles", "[octree][import][vdb]") {
  const auto file = shared_file("data/wdas_cloud_sixteenth/wdas_cloud_sixteenth.vdb");
  if (file.empty()) return;
  const GridInfo grid = inspect_volume(file).at(0);
  CHECK(grid.name == "density");
  CHECK(grid.type == "float");
  CHECK(grid.resolution == Vec3i(126, 86, 154));
  CHECK(grid.active == 415642);
  CHECK(grid.tiles == 130);
  CHECK(grid.leaves == 1241);
  CHECK(grid.max == 1.0);
  CHECK(grid.voxel_m.x == Approx(3.33333));

  const VoxelStream stream = open_volume(file, std::vector<std::string>{"density"}).at(0);
  CHECK(stream.channels == std::vector<std::string>{"density"});
  const Dense dense(stream);
  CHECK(dense.tiles() == 130);
  CHECK(dense.nonzero(0) == 363037);
  CHECK(dense.sum(0) / 415642 == Approx(0.4536).margin(5e-5));
  CHECK(dense.twice() == 0);
  CHECK(dense.outside() == 0);
  // Voxel (-66,-21,-90) has its centre at that index, so the corner lies half a voxel lower.
  const Vec3d centre = transform_point(stream.index_to_local, Vec3d(-65.5, -20.5, -89.5));
  CHECK((centre - Vec3d(-66, -21, -90) * 3.3333332538604736).length() < 1e-4);
}

TEST_CASE("half floats are read", "[octree][import][vdb]") {
  const auto file = shared_file("data/openvdb_smoke1/smoke.vdb");
  if (file.empty()) return;
  const GridInfo grid = inspect_volume(file).at(0);
  CHECK(grid.type == "half");
  CHECK(grid.resolution == Vec3i(111, 222, 112));
  CHECK(grid.active == 1049275);
  CHECK(grid.max == Approx(5.715).epsilon(1e-3));
  const Dense dense(open_volume(file, std::vector<std::string>{"density"}).at(0));
  CHECK(dense.sum(0) / 1049275 == Approx(0.163).margin(5e-4));
}

TEST_CASE("grids on one lattice become the channels of one stream", "[octree][import][vdb]") {
  const auto file = shared_file("data/les_rico_jpl/rico32x37x26.vdb");
  if (file.empty()) return;
  const auto streams = open_volume(file, std::vector<std::string>{"reff", "lwc"});
  REQUIRE(streams.size() == 1);
  CHECK(streams[0].channels == std::vector<std::string>{"reff", "lwc"});
  const Dense dense(streams[0]);
  CHECK(dense.nonzero(0) == 3943);
  CHECK(dense.nonzero(1) == 3943);
  CHECK(dense.max(0) == Approx(18.698));
  CHECK(dense.max(1) == Approx(1.5178));
}

TEST_CASE("a background that fills space counts", "[octree][import][vdb]") {
  const auto file = shared_file("data/fds_smoke_plot3d_float/vdb/corridor_float.t010.vdb");
  if (file.empty()) return;
  const GridInfo info = find(inspect_volume(file), "temperature");
  CHECK(info.background == Approx(293.15));
  CHECK(info.units == "K");

  const auto streams =
      open_volume(file, std::vector<GridRequest>{{"soot_density", true, false}, {"temperature", true, true}});
  REQUIRE(streams.size() == 1);
  CHECK(streams[0].background[1] == 293.15f);
  CHECK(streams[0].units[1] == "K");
  const Dense dense(streams[0]);
  CHECK(dense.outside() == 0);
  // Wherever there is soot there is a temperature, stored or not.
  for (std::size_t i = 0; i < dense.values(0).size(); ++i)
    if (dense.values(0)[i] > 0) REQUIRE(dense.values(1)[i] >= 293.0f);

  CHECK_THROWS_WITH(open_volume(file, std::vector<GridRequest>{{"temperature", true, false}}),
                    Catch::Contains("temperature") && Catch::Contains("fill all of space"));
  CHECK_THROWS_WITH(open_volume(file, std::vector<std::string>{"u"}),
                    Catch::Contains("'u'") && Catch::Contains("negative") && Catch::Contains("voxel ("));
}

TEST_CASE("files of another writer are read", "[octree][import][vdb]") {
  const auto file = shared_file("data/blender_plume_sequence/fluid_data_0050.vdb");
  if (file.empty()) return;
  const auto grids = inspect_volume(file);
  CHECK(grids.size() == 5);
  CHECK(find(grids, "density").active == 14882);
  CHECK(find(grids, "density").max == Approx(1.11947));
  const GridInfo& shadow = find(grids, "shadow");
  CHECK(shadow.active == 256000);
  CHECK(shadow.leaves == 0);
  CHECK(shadow.tiles == 500);
  CHECK(shadow.min == -1);
  const GridInfo& velocity = find(grids, "velocity");
  CHECK(velocity.type == "vec3s");
  CHECK_FALSE(velocity.scalar);

  CHECK_THROWS_WITH(open_volume(file, std::vector<std::string>{"velocity"}),
                    Catch::Contains("velocity") && Catch::Contains("vec3s"));
  CHECK_THROWS_WITH(open_volume(file, std::vector<std::string>{"shadow"}), Catch::Contains("negative"));
  const auto streams =
      open_volume(file, std::vector<GridRequest>{{"density"}, {"temperature"}, {"shadow", false, false}});
  REQUIRE(streams.size() == 1);
  const Dense dense(streams[0]);
  CHECK(dense.size() == Vec3i(80, 40, 80));
  CHECK(dense.nonzero(2) == 256000);
  CHECK(dense.nonzero(0) <= 14882);
  CHECK(dense.twice() == 0);
}

TEST_CASE("a wrong name is answered with the names that are there", "[octree][import][vdb]") {
  const auto file = shared_file("data/les_rico_jpl/rico32x37x26.vdb");
  if (file.empty()) return;
  CHECK_THROWS_WITH(open_volume(file, std::vector<std::string>{"density"}),
                    Catch::Contains("density") && Catch::Contains("lwc") && Catch::Contains("reff"));
}
