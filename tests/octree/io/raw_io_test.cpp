// Raw voxels: types, orders, several grids, and every mistake by its pointer.
#include <catch2/catch.hpp>
#include <cmath>

#include "octree/base/error.h"
#include "octree/io/import.h"
#include "tests/support/dense_stream.h"
#include "tests/support/scratch_folder.h"

using namespace obscura;
using namespace obscura::test;

namespace {

const Vec3i kSize(11, 3, 9);

double field(int x, int y, int z) { return 1 + x + 11 * y + 33 * z; }

template <class T>
std::string array(bool x_fastest) {
  std::string bytes;
  const auto put = [&](int x, int y, int z) {
    const T value = static_cast<T>(field(x, y, z));
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  if (x_fastest) {
    for (int z = 0; z < kSize.z; ++z)
      for (int y = 0; y < kSize.y; ++y)
        for (int x = 0; x < kSize.x; ++x) put(x, y, z);
  } else {
    for (int x = 0; x < kSize.x; ++x)
      for (int y = 0; y < kSize.y; ++y)
        for (int z = 0; z < kSize.z; ++z) put(x, y, z);
  }
  return bytes;
}

std::string json(const std::string& type, const std::string& order, const std::string& grid = "density") {
  return R"({"raw": "a.raw", "type": ")" + type + R"(", "resolution": [11, 3, 9], "order": ")" + order +
         R"(", "voxel_m": [1, 2, 0.5], "origin_m": [10, 0, -1], "grid": ")" + grid + "\"}";
}

template <class T>
void check_type(const std::string& type) {
  const ScratchFolder folder;
  for (const bool x_fastest : {true, false}) {
    folder.write("a.raw", array<T>(x_fastest));
    const auto file = folder.write("a.json", json(type, x_fastest ? "x-fastest" : "z-fastest"));
    const VoxelStream stream = open_volume(file, std::vector<std::string>{"density"}).at(0);
    CHECK(stream.bounds == Box3i(Vec3i(0), kSize));
    CHECK(transform_point(stream.index_to_local, Vec3d(0)) == Vec3d(10, 0, -1));
    CHECK(transform_point(stream.index_to_local, Vec3d(1)) == Vec3d(11, 2, -0.5));
    const Dense dense(stream);
    CHECK(dense.outside() == 0);
    for (int z = 0; z < kSize.z; ++z)
      for (int y = 0; y < kSize.y; ++y)
        for (int x = 0; x < kSize.x; ++x)
          REQUIRE(dense.at(0, {x, y, z}) == static_cast<float>(static_cast<T>(field(x, y, z))));
    const GridInfo info = inspect_volume(file).at(0);
    CHECK(info.type == type);
    CHECK(info.resolution == kSize);
    if (sizeof(T) > 1) CHECK(info.min == 1.0);
  }
}

std::vector<Problem> problems_of(const std::filesystem::path& file) {
  try {
    open_volume(file, std::vector<std::string>{"density"});
  } catch (const InputError& error) {
    return error.problems();
  }
  return {};
}

}  // namespace

TEST_CASE("raw voxels of every type and order are read", "[octree][import][raw]") {
  check_type<float>("float32");
  check_type<double>("float64");
  check_type<std::uint16_t>("uint16");
  check_type<std::int16_t>("int16");
  check_type<std::uint32_t>("uint32");
  check_type<std::int32_t>("int32");
  check_type<std::uint64_t>("uint64");
  check_type<std::int64_t>("int64");
  check_type<std::uint8_t>("uint8");
}

TEST_CASE("raw grids of one lattice share a stream, others do not", "[octree][import][raw]") {
  const ScratchFolder folder;
  folder.write("a.raw", array<float>(true));
  std::string other = json("float32", "x-fastest", "fine");
  other.replace(other.find("[1, 2, 0.5]"), 11, "[1, 1, 0.5]");
  const auto file = folder.write(
      "a.json", "[" + json("float32", "x-fastest") + "," + json("float32", "x-fastest", "b") + "," + other + "]");
  CHECK(open_volume(file, std::vector<std::string>{"density", "b"}).size() == 1);
  CHECK(open_volume(file, std::vector<std::string>{"density", "fine"}).size() == 2);
  CHECK_THROWS_WITH(open_volume(file, std::vector<std::string>{"soot"}), Catch::Contains("density, b, fine"));
}

TEST_CASE("a raw array of the wrong size is refused with both sizes", "[octree][import][raw]") {
  const ScratchFolder folder;
  const auto file = folder.write("a.json", json("float32", "x-fastest"));
  CHECK_THAT(problems_of(file).at(0).text(), Catch::Contains("a.raw") && Catch::Contains("can't be read"));
  folder.write("a.raw", array<float>(true).substr(4));
  CHECK_THAT(problems_of(file).at(0).text(), Catch::Contains("1184 bytes") && Catch::Contains("1188"));
  folder.write("a.raw", "");
  CHECK_THAT(problems_of(file).at(0).text(), Catch::Contains("0 bytes"));
}

TEST_CASE("every mistake in a raw description is named at once", "[octree][import][raw]") {
  const ScratchFolder folder;
  const auto problems = problems_of(folder.write(
      "a.json",
      R"({"raw": 3, "type": "float33", "resolution": [1, 2], "order": "y", "voxel_m": [1, 0, 1], "sise": 1})"));
  std::string all;
  for (const Problem& problem : problems) all += problem.text() + "\n";
  for (const char* pointer : {"/raw", "/type", "/resolution", "/order", "/voxel_m", "/sise"})
    CHECK_THAT(all, Catch::Contains(pointer));
  CHECK(problems.size() == 6);
  CHECK_THAT(problems_of(folder.write("b.json", "{")).at(0).text(), Catch::Contains("not JSON"));
  CHECK_THAT(problems_of(folder.write("c.json", "")).at(0).text(), Catch::Contains("not JSON"));
  CHECK_THAT(problems_of(folder.write("d.json", "[]")).at(0).text(), Catch::Contains("no grid"));
}

TEST_CASE("NaN, infinite and negative raw voxels are refused by grid and voxel", "[octree][import][raw][not_finite]") {
  const ScratchFolder folder;
  const auto file = folder.write("a.json", json("float32", "x-fastest"));
  for (const float bad : {std::nanf(""), INFINITY, -1.0f}) {
    std::string bytes = array<float>(true);
    bytes.replace(4 * (5 + 11 * 2 + 33 * 8), 4, reinterpret_cast<const char*>(&bad), 4);
    folder.write("a.raw", bytes);
    const auto stream = open_volume(file, std::vector<std::string>{"density"}).at(0);
    CHECK_THROWS_WITH(Dense(stream), Catch::Contains("'density'") && Catch::Contains("(5, 2, 8)"));
    const auto free = open_volume(file, std::vector<GridRequest>{{"density", false}}).at(0);
    if (bad == -1.0f)
      CHECK_NOTHROW(Dense(free));
    else
      CHECK_THROWS_AS(Dense(free), InputError);
  }
}
