// OpenVDB files made here: value types, transforms, backgrounds, tiles, and every kind of broken file.
#include <openvdb/openvdb.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "octree/base/error.h"
#include "octree/io/import.h"
#include "tests/support/dense_stream.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shared_data.h"

using namespace obscura;
using namespace obscura::test;

namespace {

const std::vector<std::string> kDensity{"density"};

void write_grids(const std::filesystem::path& path, const openvdb::GridCPtrVec& grids) {
  openvdb::initialize();
  openvdb::io::File file(path.string());
  file.write(grids);
}

template <class Grid>
typename Grid::Ptr one_voxel(const openvdb::Coord& at, typename Grid::ValueType value,
                             typename Grid::ValueType background = typename Grid::ValueType(0)) {
  openvdb::initialize();
  auto grid = Grid::create(background);
  grid->setName("density");
  grid->tree().setValueOn(at, value);
  return grid;
}

std::string message(const std::filesystem::path& path, const std::vector<GridRequest>& grids = {{"density"}}) {
  try {
    for (const VoxelStream& stream : open_volume(path, grids)) Dense{stream};
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("one voxel is one voxel, where its centre says", "[octree][import][vdb]") {
  const ScratchFolder folder;
  auto grid = one_voxel<openvdb::FloatGrid>({-9, 5, 1000}, 2.5f);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(0.1));
  write_grids(folder / "a.vdb", {grid});
  const VoxelStream stream = open_volume(folder / "a.vdb", kDensity).at(0);
  CHECK(stream.bounds == Box3i(Vec3i(-9, 5, 1000), Vec3i(-8, 6, 1001)));
  const Vec3d centre = transform_point(stream.index_to_local, Vec3d(stream.bounds.min) + Vec3d(0.5));
  CHECK((centre - Vec3d(-0.9, 0.5, 100)).length() < 1e-9);
  CHECK(Dense(stream).at(0, Vec3i(0)) == 2.5f);
}

TEST_CASE("scalars of every type are read", "[octree][import][vdb]") {
  const ScratchFolder folder;
  const auto value = [&](const openvdb::GridBase::Ptr& grid) {
    write_grids(folder / "a.vdb", {grid});
    return Dense(open_volume(folder / "a.vdb", kDensity).at(0)).max(0);
  };
  CHECK(value(one_voxel<openvdb::FloatGrid>({1, 2, 3}, 0.25f)) == 0.25f);
  CHECK(value(one_voxel<openvdb::DoubleGrid>({1, 2, 3}, 0.1)) == 0.1f);
  CHECK(value(one_voxel<openvdb::Int32Grid>({1, 2, 3}, 7)) == 7.0f);
  CHECK(value(one_voxel<openvdb::Int64Grid>({1, 2, 3}, 9)) == 9.0f);
  CHECK(value(one_voxel<openvdb::BoolGrid>({1, 2, 3}, true)) == 1.0f);
  auto narrow = one_voxel<openvdb::FloatGrid>({1, 2, 3}, 0.1f);
  narrow->setSaveFloatAsHalf(true);
  CHECK(value(narrow) == Approx(0.1).epsilon(1e-3));
  write_grids(folder / "v.vdb", {one_voxel<openvdb::Vec3SGrid>({1, 2, 3}, openvdb::Vec3f(1, 2, 3))});
  CHECK_THAT(message(folder / "v.vdb"), Catch::Contains("vec3s"));
}

TEST_CASE("tiles of every level are poured, and split where another grid is finer", "[octree][import][vdb]") {
  const ScratchFolder folder;
  openvdb::initialize();
  auto density = openvdb::FloatGrid::create(0);
  density->setName("density");
  density->tree().addTile(2, openvdb::Coord(128, 0, 0), 0.5f, true);    // 128^3
  density->tree().addTile(1, openvdb::Coord(-8, -8, -8), 0.25f, true);  // 8^3
  auto soot = openvdb::FloatGrid::create(0);
  soot->setName("soot");
  soot->tree().setValueOn(openvdb::Coord(130, 2, 2), 3);
  soot->tree().addTile(1, openvdb::Coord(136, 8, 8), 4, true);
  write_grids(folder / "a.vdb", {density, soot});

  const Dense alone(open_volume(folder / "a.vdb", kDensity).at(0));
  CHECK(alone.tiles() == 2);
  CHECK(alone.bricks() == 0);
  CHECK(alone.sum(0) == 0.5 * 128 * 128 * 128 + 0.25 * 512);

  const auto streams = open_volume(folder / "a.vdb", std::vector<std::string>{"density", "soot"});
  REQUIRE(streams.size() == 1);
  const Dense both(streams[0]);
  CHECK(both.twice() == 0);
  CHECK(both.bricks() == 1);
  CHECK(both.sum(0) == alone.sum(0));
  CHECK(both.sum(1) == 3 + 4.0 * 512);
  const Vec3i low = streams[0].bounds.min;
  CHECK(both.at(0, Vec3i(130, 2, 2) - low) == 0.5f);
  CHECK(both.at(1, Vec3i(130, 2, 2) - low) == 3.0f);
  CHECK(both.at(1, Vec3i(140, 12, 12) - low) == 4.0f);
}

TEST_CASE("grids of one file may differ in transform", "[octree][import][vdb]") {
  const ScratchFolder folder;
  auto density = one_voxel<openvdb::FloatGrid>({0, 0, 0}, 1);
  auto other = one_voxel<openvdb::FloatGrid>({0, 0, 0}, 300);
  other->setName("temperature");
  other->transform().postScale(openvdb::Vec3d(1, 1, 2));
  other->transform().postRotate(0.3, openvdb::math::Z_AXIS);
  other->transform().postTranslate(openvdb::Vec3d(5, 6, 7));
  write_grids(folder / "a.vdb", {density, other});
  const auto streams = open_volume(folder / "a.vdb", std::vector<std::string>{"density", "temperature"});
  REQUIRE(streams.size() == 2);
  // The rotated and scaled axes, from OpenVDB itself.
  const openvdb::Vec3d there = other->indexToWorld(openvdb::Vec3d(3, 4, 5));
  const Vec3d here = transform_point(streams[1].index_to_local, Vec3d(3.5, 4.5, 5.5));
  CHECK((here - Vec3d(there.x(), there.y(), there.z())).length() < 1e-12);
}

TEST_CASE("grids of one name are told apart by number", "[octree][import][vdb]") {
  const ScratchFolder folder;
  write_grids(folder / "a.vdb",
              {one_voxel<openvdb::FloatGrid>({0, 0, 0}, 1), one_voxel<openvdb::FloatGrid>({0, 0, 0}, 2)});
  const auto grids = inspect_volume(folder / "a.vdb");
  REQUIRE(grids.size() == 2);
  float sum = 0;
  for (const GridInfo& grid : grids)
    sum += Dense(open_volume(folder / "a.vdb", std::vector<std::string>{grid.name}).at(0)).max(0);
  CHECK(sum == 3.0f);
}

TEST_CASE("a frustum is refused, not flattened", "[octree][import][vdb]") {
  const ScratchFolder folder;
  auto grid = one_voxel<openvdb::FloatGrid>({0, 0, 0}, 1);
  grid->setTransform(openvdb::math::Transform::createFrustumTransform(
      openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(100)), 0.5, 10, 0.1));
  write_grids(folder / "a.vdb", {grid});
  CHECK_THAT(message(folder / "a.vdb"), Catch::Contains("density") && Catch::Contains("not affine"));
  const GridInfo info = inspect_volume(folder / "a.vdb").at(0);
  CHECK_FALSE(info.affine);
}

TEST_CASE("NaN, infinite and negative voxels are refused by grid and voxel", "[octree][import][vdb][not_finite]") {
  const ScratchFolder folder;
  for (const float bad : {std::nanf(""), std::numeric_limits<float>::infinity(), -0.5f}) {
    auto grid = one_voxel<openvdb::FloatGrid>({0, 0, 0}, 1);
    grid->tree().setValueOn(openvdb::Coord(17, -4, 9), bad);
    write_grids(folder / "a.vdb", {grid});
    CHECK_THAT(message(folder / "a.vdb"), Catch::Contains("'density'") && Catch::Contains("(17, -4, 9)"));
    auto tile = openvdb::FloatGrid::create(0);
    tile->setName("density");
    tile->tree().addTile(1, openvdb::Coord(8, 16, 24), bad, true);
    write_grids(folder / "a.vdb", {tile});
    CHECK_THAT(message(folder / "a.vdb"), Catch::Contains("(8, 16, 24)"));
    write_grids(folder / "a.vdb", {one_voxel<openvdb::FloatGrid>({0, 0, 0}, 1, bad)});
    CHECK_THAT(message(folder / "a.vdb"), Catch::Contains("background"));
  }
  // A double that no float holds.
  write_grids(folder / "a.vdb", {one_voxel<openvdb::DoubleGrid>({1, 1, 1}, 1e300)});
  CHECK_THAT(message(folder / "a.vdb"), Catch::Contains("(1, 1, 1)"));
}

TEST_CASE("what is stored counts, active or not", "[octree][import][vdb]") {
  const ScratchFolder folder;
  auto grid = one_voxel<openvdb::FloatGrid>({0, 0, 0}, 1);
  grid->tree().setValueOff(openvdb::Coord(1, 0, 0), 0.5f);
  grid->tree().addTile(1, openvdb::Coord(16, 0, 0), 0.25f, false);
  write_grids(folder / "a.vdb", {grid});
  CHECK(Dense(open_volume(folder / "a.vdb", kDensity).at(0)).sum(0) == 1 + 0.5 + 0.25 * 512);
}

TEST_CASE("empty grids and empty files have their answers", "[octree][import][vdb]") {
  const ScratchFolder folder;
  openvdb::initialize();
  auto grid = openvdb::FloatGrid::create(0);
  grid->setName("density");
  write_grids(folder / "a.vdb", {grid});
  CHECK(Dense(open_volume(folder / "a.vdb", kDensity).at(0)).poured() == 0);
  CHECK(inspect_volume(folder / "a.vdb").at(0).active == 0);

  CHECK_THAT(message(folder.write("b.vdb", "")), Catch::Contains("empty"));
  CHECK_THAT(message(folder.write("c.vdb", "hello, this is text")), Catch::Contains("not an OpenVDB file"));
  CHECK_THAT(message(folder / "absent.vdb"), Catch::Contains("doesn't exist"));
  CHECK_THAT(message(folder.write("d.xyz", "1")), Catch::Contains(".xyz") && Catch::Contains(".nvdb"));
  CHECK_THAT(message(folder / ""), Catch::Contains("folder"));
}

TEST_CASE("truncated files and wrong versions are refused", "[octree][import][vdb]") {
  const ScratchFolder folder;
  auto grid = one_voxel<openvdb::FloatGrid>({0, 0, 0}, 1);
  for (int i = 0; i < 4000; ++i)
    grid->tree().setValueOn(openvdb::Coord((i * 37) % 100, (i * 61) % 90, (i * 17) % 80),
                            1 + 0.001f * static_cast<float>(i));
  write_grids(folder / "a.vdb", {grid});
  const std::string whole = read_bytes(folder / "a.vdb");
  CHECK(message(folder / "a.vdb") == "accepted");
  for (const double share : {0.0005, 0.01, 0.1, 0.5, 0.9, 0.999}) {
    INFO("share " << share);
    const auto bytes = static_cast<std::size_t>(share * double(whole.size()));
    CHECK(message(folder.write("b.vdb", whole.substr(0, bytes))) != "accepted");
  }
  // Cut anywhere, nothing of it may pass for a grid, not even an empty one.
  for (std::size_t bytes = 12; bytes < whole.size(); bytes += bytes < 2000 ? 7 : 997) {
    INFO("bytes " << bytes);
    folder.write("b.vdb", whole.substr(0, bytes));
    CHECK_THROWS_AS(inspect_volume(folder / "b.vdb"), InputError);
    CHECK_THAT(message(folder / "b.vdb"), Catch::Contains("ends"));
  }
  for (const char version : {char(219), char(226)}) {
    std::string wrong = whole;
    wrong[8] = version;
    CHECK_THAT(message(folder.write("c.vdb", wrong)), Catch::Contains("version") && Catch::Contains("220 to 225"));
  }
}
