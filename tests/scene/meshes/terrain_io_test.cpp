// Terrain: where posts stand, which triangles are made, and what is said of broken grids.
#include "scene/meshes/terrain_io.h"

#include <zlib.h>

#include <catch2/catch.hpp>

#include "octree/base/error.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shared_data.h"

using namespace obscura;
using obscura::test::ScratchFolder;

namespace {

const std::string kHeader = "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value -9999\n";

double up_area(const Mesh& mesh) {
  double sum = 0;
  for (const auto& f : mesh.faces) {
    const Vec3d& a = mesh.vertices[f[0]];
    const double area = 0.5 * (mesh.vertices[f[1]] - a).cross(mesh.vertices[f[2]] - a).z;
    CHECK(area > 0);
    sum += area;
  }
  return sum;
}

}  // namespace

TEST_CASE("posts stand at the centres of the cells, the first row in the north", "[scene][terrain]") {
  const ScratchFolder folder;
  const MeshFile file = read_terrain(folder.write("a.asc", kHeader + "1 2 3\n4 5 6\n"));
  REQUIRE(file.mesh.vertices.size() == 6);
  CHECK(file.mesh.vertices[0] == Vec3d(105, 215, 1));
  CHECK(file.mesh.vertices[2] == Vec3d(125, 215, 3));
  CHECK(file.mesh.vertices[3] == Vec3d(105, 205, 4));
  CHECK(file.mesh.faces.size() == 4);
  CHECK(up_area(file.mesh) == Approx(200));
  CHECK(file.face_numbers == std::vector<std::uint32_t>{0, 0, 1, 1});
  CHECK(file.face_count == 2);
  CHECK(file.vertex_count == 6);
  CHECK(file.slot_names.size() == 1);
}

TEST_CASE("xllcenter is the centre of the first cell, keys may come in any order and case", "[scene][terrain]") {
  const ScratchFolder folder;
  const MeshFile file =
      read_terrain(folder.write("a.asc", "NROWS 2\nNCOLS 2\nCELLSIZE 10\nXLLCENTER 100\nYLLCENTER 200\n1 2 3\n4\n"));
  CHECK(file.mesh.vertices[0] == Vec3d(100, 210, 1));
  CHECK(file.mesh.vertices[3] == Vec3d(110, 200, 4));
}

TEST_CASE("where a height is missing there is no triangle", "[scene][terrain]") {
  const ScratchFolder folder;
  // Each corner in turn: the triangle of the other three remains.
  for (const char* heights : {"-9999 2 3\n4 5 6\n", "1 -9999 3\n4 5 6\n", "1 2 3\n-9999 5 6\n", "1 2 3\n4 -9999 6\n"}) {
    const MeshFile file = read_terrain(folder.write("a.asc", kHeader + heights));
    INFO(heights);
    const bool middle = file.mesh.faces.size() == 2;
    CHECK(up_area(file.mesh) == Approx(middle ? 100 : 150));
    CHECK(file.mesh.vertices.size() == 5);
  }
  const MeshFile file = read_terrain(folder.write("a.asc", kHeader + "-9999 2 3\n4 5 6\n"));
  CHECK(file.vertex_numbers == std::vector<std::uint32_t>{1, 2, 3, 4, 5});
  CHECK(file.vertex_count == 6);

  // Vertices of a table are the cells of the grid, missing ones too.
  MeshFile warm = file;
  read_temperatures(folder.write("K.csv", "vertex,K\n0,250\n4,300\n"), warm);
  CHECK(warm.mesh.vertex_K[3] == 300);
}

TEST_CASE("a grid packed with gzip is the same", "[scene][terrain]") {
  const ScratchFolder folder;
  const std::string text = kHeader + "1 2 3\n4 5 6\n";
  const auto path = folder / "a.asc.gz";
  gzFile packed = gzopen(path.c_str(), "wb");
  gzwrite(packed, text.data(), static_cast<unsigned>(text.size()));
  gzclose(packed);
  CHECK(read_terrain(path).mesh.vertices == read_terrain(folder.write("a.asc", text)).mesh.vertices);

  const std::string bytes = test::read_bytes(path);
  CHECK_THROWS_WITH(read_terrain(folder.write("cut.asc.gz", bytes.substr(0, bytes.size() - 9))),
                    Catch::Contains("cut off"));
}

TEST_CASE("what is wrong with a grid is said with its line", "[scene][terrain][errors]") {
  const ScratchFolder folder;
  const auto refused = [&](const std::string& text, int line, const std::string& says) {
    const auto path = folder.write("a.asc", text);
    try {
      read_terrain(path);
      FAIL_CHECK(text << " was read");
    } catch (const InputError& error) {
      INFO(error.what());
      REQUIRE(error.problems().size() == 1);
      CHECK(error.problems()[0].where == path.string() + (line > 0 ? ", line " + std::to_string(line) : ""));
      CHECK(error.problems()[0].problem.find(says) != std::string::npos);
      CHECK_FALSE(error.problems()[0].hint.empty());
    }
  };
  refused(kHeader + "1 2 3\n4 5\n", 8, "ends in row 2 of 2");
  refused(kHeader + "1 2 3\n4 5 6\n7\n", 9, "more heights");
  refused(kHeader + "1 2 3\n4 5 6 7\n", 8, "more heights");
  refused(kHeader + "1 2 3\n4 five 6\n", 8, "\"five\" is no height");
  refused(kHeader + "1 2 3\n4 nan 6\n", 8, "not finite");
  refused(kHeader, 6, "the file ends here");
  refused("ncols 3\nrows 2\n", 2, "no key of an ESRI ASCII grid");
  refused("ncols three\n", 1, "not followed by one number");
  refused("ncols 3 4\n", 1, "not followed by one number");
  refused("ncols 3\n1 2 3\n", 2, "no nrows");
  refused("ncols 1\nnrows 2\n1 2 3\n", 3, "no ncols of at least 2");
  refused("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 0\n1 2 3 4\n", 6, "no cellsize above 0");
  refused("ncols 2\nnrows 2\nyllcorner 0\ncellsize 1\n1 2 3 4\n", 5, "no xllcorner");
  refused("ncols 100000\nnrows 100000\nxllcorner 0\nyllcorner 0\ncellsize 1\n1\n", 6, "4,294,967,295");
  refused(kHeader + "-9999 -9999 3\n4 -9999 6\n", 0, "no three heights");
  refused("", 0, "header");
}

TEST_CASE("Mount St. Helens stands where its map says", "[scene][terrain][shared]") {
  const auto path = test::shared_file("data/terrain_st_helens_dem/SainteHelens.asc.gz");
  if (path.empty()) return;
  const MeshFile file = read_terrain(path);
  double low = 1e9, high = 0;
  for (const Vec3d& vertex : file.mesh.vertices) {
    low = std::min(low, vertex.z);
    high = std::max(high, vertex.z);
  }
  // What its publisher states: 327 x 468 posts, 682 .. 2543 m, 2.7 % without data.
  CHECK(file.vertex_count == 327 * 468);
  CHECK(low == 682);
  CHECK(high == 2543);
  CHECK(static_cast<double>(file.mesh.vertices.size()) == Approx(0.973 * 327 * 468).epsilon(5e-4));
}
