// LES text: both layouts, agreement with the same fields as OpenVDB, and broken files.
#include <catch2/catch.hpp>

#include "octree/base/error.h"
#include "octree/io/import.h"
#include "tests/support/dense_stream.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shared_data.h"

using namespace obscura;
using namespace obscura::test;

namespace {

const std::vector<std::string> kLwc{"lwc"};

}  // namespace

TEST_CASE("LES text gives the field of its OpenVDB version, in metres", "[octree][import][les]") {
  const auto text = shared_file("data/les_rico_jpl/rico32x37x26.txt");
  const auto vdb = shared_file("data/les_rico_jpl/rico32x37x26.vdb");
  if (text.empty() || vdb.empty()) return;
  const std::vector<std::string> grids{"lwc", "reff"};
  const VoxelStream a = open_volume(text, grids).at(0);
  const VoxelStream b = open_volume(vdb, grids).at(0);
  CHECK(a.bounds == Box3i(Vec3i(0), Vec3i(32, 37, 26)));
  CHECK(a.units == std::vector<std::string>{"g m-3", "um"});

  // The VDB's world unit is the km.
  Affine metres;
  metres.setScale(1000);
  const Affine b_metres = b.index_to_local * metres;
  for (const Vec3d& p : {Vec3d(0), Vec3d(32, 37, 26), Vec3d(3.5, 7, 1)})
    CHECK((transform_point(a.index_to_local, p) - transform_point(b_metres, p)).length() < 1e-3);
  // Point (0,0,0) of the text lies at x = 0, y = 0, z = 440 m: the centre of its cell.
  CHECK((transform_point(a.index_to_local, Vec3d(0.5)) - Vec3d(0, 0, 440)).length() < 1e-9);

  const Dense x(a), y(b);
  const Vec3i offset = b.bounds.min;
  for (int c = 0; c < 2; ++c) {
    CHECK(x.nonzero(c) == 3943);
    CHECK(x.sum(c) == Approx(y.sum(c)).epsilon(1e-12));
  }
  const Vec3i n = y.size();
  for (int k = 0; k < n.z; ++k)
    for (int j = 0; j < n.y; ++j)
      for (int i = 0; i < n.x; ++i) REQUIRE(y.at(0, {i, j, k}) == x.at(0, Vec3i(i, j, k) + offset));
}

TEST_CASE("the older layout of LES text is read", "[octree][import][les]") {
  const auto text = shared_file("data/les_stcu_i3rc/les_stcu.txt");
  const auto vdb = shared_file("data/les_stcu_i3rc/les_stcu.vdb");
  if (text.empty() || vdb.empty()) return;
  const VoxelStream stream = open_volume(text, kLwc).at(0);
  CHECK(stream.bounds == Box3i(Vec3i(0), Vec3i(64, 64, 16)));
  const Dense dense(stream);
  CHECK(dense.max(0) == Approx(4.26).margin(0.005));
  CHECK(dense.nonzero(0) == 24789);
  CHECK(dense.sum(0) == Approx(Dense(open_volume(vdb, kLwc).at(0)).sum(0)).epsilon(1e-9));
  const auto info = inspect_volume(text);
  REQUIRE(info.size() == 2);
  CHECK(info[0].voxel_m.x == Approx(55));
  CHECK(info[0].voxel_m.z == Approx(24.933).epsilon(1e-4));
}

TEST_CASE("broken LES text is refused by line", "[octree][import][les]") {
  const ScratchFolder folder;
  const std::string head = "# c\n4,4,3\n0.02,0.02\n0.4,0.44,0.48\nx,y,z,lwc,reff\n";
  const auto message = [&](const std::string& text) {
    try {
      open_volume(folder.write("a.txt", text), kLwc);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  CHECK(message(head + "1,1,1,0.5,10\n") == "accepted");
  CHECK_THAT(message(""), Catch::Contains("empty"));
  CHECK_THAT(message("4 4"), Catch::Contains("ends before"));
  CHECK_THAT(message(head), Catch::Contains("no point"));
  CHECK_THAT(message(head + "1,1,1,0.5"), Catch::Contains("line 6") && Catch::Contains("cut off"));
  CHECK_THAT(message(head + "1,1,3,0.5,10\n"), Catch::Contains("line 6") && Catch::Contains("outside"));
  CHECK_THAT(message(head + "1,1,1,abc,10\n"), Catch::Contains("abc"));
  CHECK_THAT(message(head + "1,1,1,nan,10\n"), Catch::Contains("lwc") && Catch::Contains("(1, 1, 1)"));
  CHECK_THAT(message(head + "1,2,1,-0.5,10\n"), Catch::Contains("lwc") && Catch::Contains("(1, 2, 1)"));
  CHECK_THAT(message("4,4,3\n0.02,0.02\n0.4,0.44,0.60\n1,1,1,1,1\n"), Catch::Contains("level 1"));
  CHECK_THAT(message("4,4,0\n"), Catch::Contains("not a size"));
}
