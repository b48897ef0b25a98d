// NanoVDB files of every stored type, made here, and broken ones.
#include <catch2/catch.hpp>

#include "octree/base/error.h"
#include "octree/io/import.h"
#include "tests/support/dense_stream.h"
#include "tests/support/scratch_folder.h"
#define NANOVDB_USE_ZIP
#define NANOVDB_USE_BLOSC
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/IO.h>

#include <cmath>

using namespace obscura;
using namespace obscura::test;

namespace {

double field(int i, int j, int k) { return 2 + std::sin(0.2 * i) + 0.01 * j + 0.001 * k; }

/// A block of 20 x 10 x 30 voxels from (-3, 2, 100) on, and one distant tile.
template <class Build>
nanovdb::GridHandle<> make_grid(const char* name = "density") {
  nanovdb::GridBuilder<float, Build> builder(0.0f, nanovdb::GridClass::FogVolume);
  auto accessor = builder.getAccessor();
  for (int k = 100; k < 130; ++k)
    for (int j = 2; j < 12; ++j)
      for (int i = -3; i < 17; ++i) accessor.setValue(nanovdb::Coord(i, j, k), static_cast<float>(field(i, j, k)));
  return builder.template getHandle<nanovdb::AbsDiff>(0.5, nanovdb::Vec3d(10, 20, 30), name);
}

template <class Build>
void check_type(double tolerance) {
  const ScratchFolder folder;
  for (const auto codec : {nanovdb::io::Codec::NONE, nanovdb::io::Codec::ZIP, nanovdb::io::Codec::BLOSC}) {
    nanovdb::io::writeGrid((folder / "a.nvdb").string(), make_grid<Build>(), codec);
    const VoxelStream stream = open_volume(folder / "a.nvdb", std::vector<std::string>{"density"}).at(0);
    CHECK(stream.bounds == Box3i(Vec3i(-3, 2, 100), Vec3i(17, 12, 130)));
    // Voxel centres at integers: the centre of voxel (0,0,0) is the map's translation.
    CHECK((transform_point(stream.index_to_local, Vec3d(0.5)) - Vec3d(10, 20, 30)).length() < 1e-9);
    CHECK((transform_point(stream.index_to_local, Vec3d(1.5, 2.5, 3.5)) - Vec3d(10.5, 21, 31.5)).length() < 1e-9);
    const Dense dense(stream);
    CHECK(dense.nonzero(0) == 20 * 10 * 30);
    for (int k = 100; k < 130; ++k)
      for (int j = 2; j < 12; ++j)
        for (int i = -3; i < 17; ++i)
          REQUIRE(dense.at(0, Vec3i(i, j, k) - stream.bounds.min) == Approx(field(i, j, k)).margin(tolerance));
    const GridInfo info = inspect_volume(folder / "a.nvdb").at(0);
    CHECK(info.active == 20 * 10 * 30);
    CHECK(info.resolution == Vec3i(20, 10, 30));
    CHECK(info.scalar);
  }
}

}  // namespace

TEST_CASE("NanoVDB grids of every width are read", "[octree][import][nvdb]") {
  check_type<float>(1e-7);
  check_type<nanovdb::Fp4>(0.2);
  check_type<nanovdb::Fp8>(0.01);
  check_type<nanovdb::Fp16>(1e-4);
  check_type<nanovdb::FpN>(0.2);
}

TEST_CASE("broken NanoVDB files are refused", "[octree][import][nvdb]") {
  const ScratchFolder folder;
  const std::vector<std::string> density{"density"};
  nanovdb::io::writeGrid((folder / "a.nvdb").string(), make_grid<float>());
  const std::string whole = read_bytes(folder / "a.nvdb");
  CHECK_THROWS_WITH(open_volume(folder / "a.nvdb", std::vector<std::string>{"soot"}), Catch::Contains("density"));
  CHECK_THROWS_WITH(open_volume(folder.write("b.nvdb", ""), density), Catch::Contains("empty"));
  CHECK_THROWS_AS(open_volume(folder.write("c.nvdb", "no such thing, but long enough for a header"), density),
                  InputError);
  for (const double share : {0.0001, 0.01, 0.3, 0.9})
    CHECK_THROWS_AS(
        open_volume(folder.write("d.nvdb", whole.substr(0, std::size_t(share * double(whole.size())))), density),
        InputError);
  std::string version = whole;
  version[11] = '\x7f';
  CHECK_THROWS_AS(open_volume(folder.write("e.nvdb", version), density), InputError);
}
