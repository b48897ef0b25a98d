// Meshes from files: what is read of OBJ files and of temperatures, and what is said of files that are broken.
#include "scene/meshes/mesh_io.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "octree/base/error.h"
#include "tests/scene/meshes/mesh_files.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shared_data.h"

using namespace obscura;
using obscura::test::check_refused;
using obscura::test::Face;
using obscura::test::kTetrahedron;
using obscura::test::normal_of;
using obscura::test::ScratchFolder;

namespace {

double area_of(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) sum += 0.5 * normal_of(mesh, i).length();
  return sum;
}

}  // namespace

TEST_CASE("an OBJ file gives vertices, faces and the names of its parts", "[scene][mesh]") {
  const ScratchFolder folder;
  const MeshFile file =
      read_mesh(folder.write("a.obj", std::string("# a comment\nmtllib none.mtl\no hull\n") + kTetrahedron +
                                          "vt 0 0\nvn 0 0 1\ns off\n"
                                          "f 1 2 3\n"
                                          "g left front\nusemtl red paint\nf 1/1/1 2/1/1 4//1 # no comma\n"
                                          "g right\nf -4 -2 -1\r\n"
                                          "g left front\nf 2 3 \\\n4\nl 1 2\np 1\n"));
  CHECK(file.mesh.vertices.size() == 4);
  CHECK(file.mesh.faces == std::vector<Face>{{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}});
  CHECK(file.mesh.slots == std::vector<std::uint16_t>{0, 1, 2, 1});
  REQUIRE(file.slot_names.size() == 3);
  CHECK(file.slot_names[0] == std::vector<std::string>{"hull"});
  CHECK(file.slot_names[1] == std::vector<std::string>{"left front", "left", "front", "hull", "red paint"});
  CHECK(file.slot_names[2] == std::vector<std::string>{"right", "hull", "red paint"});
  CHECK(file.face_count == 4);
  CHECK(file.vertex_count == 4);
  CHECK(file.face_numbers.empty());
  CHECK(file.vertex_numbers.empty());
}

TEST_CASE("a mesh without names has one slot and no list of slots", "[scene][mesh]") {
  const ScratchFolder folder;
  const MeshFile file = read_mesh(folder.write("a.obj", std::string(kTetrahedron) + "f 1 2 3\n"));
  CHECK(file.mesh.slots.empty());
  REQUIRE(file.slot_names.size() == 1);
  CHECK(file.slot_names[0].empty());
}

TEST_CASE("polygons are cut into triangles that cover them and face the same way", "[scene][mesh]") {
  const ScratchFolder folder;
  // A square, an L whose first corner bends inward, a star and the L turned and mirrored in space.
  const auto [corners, area] = GENERATE(table<std::string, double>(
      {{"v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4\n", 4},
       {"v 1 1 0\nv 1 2 0\nv 0 2 0\nv 0 0 0\nv 2 0 0\nv 2 1 0\nf 1 2 3 4 5 6\n", 3},
       {"v 0 0 0\nv 1 0 0\nv 0.1 0.1 0\nv 0 1 0\nf 1 2 3 4\n", 0.1},
       {"v 3 0 0\nv 1 1 0\nv 0 3 0\nv -1 1 0\nv -3 0 0\nv -1 -1 0\nv 0 -3 0\nv 1 -1 0\nf 1 2 3 4 5 6 7 8\n", 12},
       {"v 0 1 1\nv 0 2 1\nv 0 2 0\nv 0 0 0\nv 0 0 2\nv 0 1 2\nf 6 5 4 3 2 1\n", 3}}));
  const MeshFile file = read_mesh(folder.write("a.obj", corners));
  CHECK(file.mesh.faces.size() == file.mesh.vertices.size() - 2);
  CHECK(area_of(file.mesh) == Approx(area));
  for (std::size_t i = 0; i < file.mesh.faces.size(); ++i)
    CHECK(normal_of(file.mesh, i).dot(normal_of(file.mesh, 0)) > 0);
  CHECK(file.face_count == 1);
  CHECK(file.face_numbers == std::vector<std::uint32_t>(file.mesh.faces.size(), 0));
}

TEST_CASE("triangles and polygons keep the file's numbers", "[scene][mesh]") {
  const ScratchFolder folder;
  const MeshFile file = read_mesh(
      folder.write("a.obj", "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf 1 2 3\nf 1 2 3 4\nf 2 3 4\ng a\nf 1 2 3 4\n"));
  CHECK(file.face_numbers == std::vector<std::uint32_t>{0, 1, 1, 2, 3, 3});
  CHECK(file.mesh.slots == std::vector<std::uint16_t>{0, 0, 0, 0, 1, 1});
  CHECK(file.face_count == 4);
}

TEST_CASE("duplicate and degenerate faces are kept", "[scene][mesh]") {
  const ScratchFolder folder;
  const MeshFile file =
      read_mesh(folder.write("a.obj", std::string(kTetrahedron) + "f 1 2 3\nf 1 2 3\nf 1 1 2\nf 1 1 1 1\n"));
  CHECK(file.mesh.faces.size() == 5);
}

TEST_CASE("what is wrong with an OBJ file is said with its line", "[scene][mesh][errors]") {
  const ScratchFolder folder;
  const auto refused = [&](const std::string& text, int line, const std::string& says) {
    check_refused(folder.write("a.obj", text), line > 0 ? ", line " + std::to_string(line) : "", says);
  };
  refused("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", 4, "names vertex 4, but there are 3");
  refused("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", 4, "names vertex 0");
  refused("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 1 2\n", 4, "names vertex -4");
  refused("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", 4, "2 of at least three corners");
  refused("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x\n", 4, "\"x\" is no corner");
  refused("v 0 0\n", 1, "three coordinates");
  refused("v 0 0 0\nv 0 zero 0\n", 2, "\"zero\" is no coordinate");
  refused("v 0 0 nan\n", 1, "z is not finite");
  refused("v inf 0 0\n", 1, "x is not finite");
  refused("hello world\n", 1, "\"hello\" does not begin a line");
  refused("surf 0 1 0 1 1 2 3\n", 1, "free-form");
  refused(std::string(kTetrahedron) + "l 1 2\n", 0, "holds no face");
  refused("", 0, "the file is empty");
  refused(std::string(300, '\0'), 1, "does not begin a line");
}

TEST_CASE("a file that is absent, a folder or of no known kind is refused", "[scene][mesh][errors]") {
  const ScratchFolder folder;
  check_refused(folder / "absent.obj", "", "no such file");
  std::filesystem::create_directory(folder / "folder.obj");
  check_refused(folder / "folder.obj", "", "a folder");
  check_refused(folder.write("a.xyz", "1"), "", "not known by its extension");
}

TEST_CASE("a table gives faces or vertices of the file their temperatures", "[scene][mesh][temperature]") {
  const ScratchFolder folder;
  const auto square = folder.write("a.obj", "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf 1 2 3\nf 1 2 3 4\nf 2 3 4\n");
  MeshFile faces = read_mesh(square);
  read_temperatures(folder.write("K.csv", "# warm\nface,K\n1, 310\n2,320.5\n"), faces);
  REQUIRE(faces.mesh.face_K.size() == 4);
  CHECK(std::isnan(faces.mesh.face_K[0]));
  CHECK(faces.mesh.face_K[1] == 310);
  CHECK(faces.mesh.face_K[2] == 310);
  CHECK(faces.mesh.face_K[3] == 320.5f);
  CHECK(faces.mesh.vertex_K.empty());

  MeshFile vertices = read_mesh(square);
  read_temperatures(folder.write("K.csv", "vertex,K\n3,300\n0,290\n"), vertices);
  REQUIRE(vertices.mesh.vertex_K.size() == 4);
  CHECK(vertices.mesh.vertex_K[0] == 290);
  CHECK(std::isnan(vertices.mesh.vertex_K[1]));
  CHECK(vertices.mesh.vertex_K[3] == 300);
  CHECK(vertices.mesh.face_K.empty());

  const auto refused = [&](const std::string& text, int line, const std::string& says) {
    const auto table = folder.write("K.csv", text);
    MeshFile file = read_mesh(square);
    try {
      read_temperatures(table, file);
      FAIL_CHECK(text << " was read");
    } catch (const InputError& error) {
      INFO(error.what());
      const std::string where = line > 0 ? ", line " + std::to_string(line) : "";
      CHECK(error.problems()[0].where == table.string() + where);
      CHECK(error.problems()[0].problem.find(says) != std::string::npos);
      CHECK_FALSE(error.problems()[0].hint.empty());
    }
  };
  refused("", 0, "no numbers");
  refused("node,K\n", 1, "the header is \"node,K\"");
  refused("face,C\n", 1, "the header is");
  refused("face,K,x\n", 1, "the header is");
  refused("face,K\n0;300\n", 2, "not a number of a face");
  refused("face,K\n0.5,300\n", 2, "not a number of a face");
  refused("face,K\n3,300\n", 2, "there is no face 3: the mesh has 3");
  refused("vertex,K\n-1,300\n", 2, "there is no vertex -1");
  refused("face,K\n0,-3\n", 2, "is no temperature");
  refused("face,K\n0,nan\n", 2, "is no temperature");
  refused("face,K\n0,300\n\n0,310\n", 4, "given twice");
}

TEST_CASE("the jeep and the milk truck of the shared data are whole", "[scene][mesh][shared]") {
  if (const auto jeep = test::shared_file("data/meshes/jeep1/jeep1.obj"); !jeep.empty()) {
    const MeshFile file = read_mesh(jeep);
    CHECK(file.mesh.faces.size() == 2032);
    CHECK(file.slot_names.size() == 7);
  }
  // glTF 1.0; the size is what its publisher states.
  if (const auto truck = test::shared_file("data/meshes/cesium_milk_truck/CesiumMilkTruck.gltf"); !truck.empty()) {
    const MeshFile file = read_mesh(truck);
    Box3d box;
    for (const Vec3d& vertex : file.mesh.vertices) box.extendBy(vertex);
    CHECK(box.size().x == Approx(4.87).margin(0.005));
    CHECK(box.size().y == Approx(2.84).margin(0.005));
    CHECK(box.size().z == Approx(2.79).margin(0.005));
    // The two axles are one mesh at two nodes.
    CHECK(file.slot_names.size() == 5);
  }
}
