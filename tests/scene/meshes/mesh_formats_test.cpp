// Meshes from PLY, STL and glTF files: what is read, and what is said of files that are broken.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "octree/base/error.h"
#include "scene/meshes/mesh_io.h"
#include "tests/scene/meshes/mesh_files.h"
#include "tests/support/scratch_folder.h"

using namespace obscura;
using obscura::test::check_refused;
using obscura::test::Face;
using obscura::test::kTetrahedron;
using obscura::test::normal_of;
using obscura::test::ScratchFolder;

namespace {

template <class T>
void append(std::string& bytes, T value, bool big_endian = false) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big_endian) std::reverse(raw, raw + sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::string binary_stl(std::uint32_t announced, std::size_t facets, float z = 0) {
  std::string bytes(80, ' ');
  bytes.replace(0, 5, "solid");  // some programs write this into binary files
  append(bytes, announced);
  for (std::size_t i = 0; i < facets; ++i) {
    for (const float value : {0.f, 0.f, 1.f, 0.f, 0.f, z, 1.f, 0.f, z, 0.f, 1.f, z}) append(bytes, value);
    append(bytes, std::uint16_t{0});
  }
  return bytes;
}

/// A glTF 2.0 of one triangle, with the buffer in the file or beside it.
std::string gltf(const std::string& uri, const std::string& node = "") {
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"name": "hull", "mesh": 0)" +
         node + R"(}],
    "meshes": [{"name": "plate", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
    "materials": [{"name": "steel"}],
    "buffers": [{"byteLength": 42, "uri": ")" +
         uri + R"("}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 6}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
                  {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}]})";
}

std::string gltf_buffer(std::uint16_t last_index = 2, float first = 0) {
  std::string bytes;
  for (const float value : {first, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) append(bytes, value);
  for (const std::uint16_t index : {std::uint16_t{0}, std::uint16_t{1}, last_index}) append(bytes, index);
  return bytes;
}

}  // namespace

TEST_CASE("a path may hold letters of any script", "[scene][mesh]") {
  const ScratchFolder folder;
  CHECK(read_mesh(folder.write("грузовик 車.OBJ", std::string(kTetrahedron) + "f 1 2 3\n")).mesh.faces.size() == 1);
  folder.write("b.bin", gltf_buffer());
  CHECK(read_mesh(folder.write("грузовик 車.gltf", gltf("b.bin"))).mesh.faces.size() == 1);
}

TEST_CASE("PLY is read as text and as binary of either byte order", "[scene][mesh]") {
  const ScratchFolder folder;
  const std::string format = GENERATE("ascii", "binary_little_endian", "binary_big_endian");
  const bool big = format == "binary_big_endian";
  std::string bytes =
      "ply\nformat " + format +
      " 1.0\ncomment made by a test\nelement camera 1\nproperty int a\n"
      "element vertex 4\nproperty double x\nproperty float y\nproperty short z\nproperty uchar red\nproperty float K\n"
      "element face 2\nproperty uint8 flags\nproperty list uchar int vertex_indices\nend_header\n";
  if (format == "ascii") {
    bytes += "7\n0 0 0 255 300\n1 0 0 255 310\n1 1 0 255 320\n0 1 -5 255 330\n1 4 0 1 2 3\n2 3 0 1 2\n";
  } else {
    append(bytes, 7, big);
    const double x[] = {0, 1, 1, 0};
    const float y[] = {0, 0, 1, 1}, K[] = {300, 310, 320, 330};
    for (int i = 0; i < 4; ++i) {
      append(bytes, x[i], big);
      append(bytes, y[i], big);
      append(bytes, static_cast<std::int16_t>(i == 3 ? -5 : 0), big);
      append(bytes, std::uint8_t{255});
      append(bytes, K[i], big);
    }
    for (const int corners : {4, 3}) {
      append(bytes, static_cast<std::uint8_t>(1));
      append(bytes, static_cast<std::uint8_t>(corners));
      for (int k = 0; k < corners; ++k) append(bytes, k, big);
    }
  }
  const MeshFile file = read_mesh(folder.write("a.ply", bytes));
  REQUIRE(file.mesh.vertices.size() == 4);
  CHECK(file.mesh.vertices[3] == Vec3d(0, 1, -5));
  CHECK(file.mesh.faces.size() == 3);
  CHECK(file.face_numbers == std::vector<std::uint32_t>{0, 0, 1});
  CHECK(file.mesh.vertex_K == std::vector<float>{300, 310, 320, 330});

  // Cut off anywhere in its data it is refused.
  bytes.pop_back();
  if (format == "ascii") bytes.pop_back();
  CHECK_THROWS_AS(read_mesh(folder.write("cut.ply", bytes)), InputError);
}

TEST_CASE("a PLY file's faces may have temperatures", "[scene][mesh]") {
  const ScratchFolder folder;
  const MeshFile file = read_mesh(
      folder.write("a.ply",
                   "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                   "element face 2\nproperty list uchar int vertex_index\nproperty float K\nend_header\n"
                   "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 300\n3 0 1 2 400\n"));
  CHECK(file.mesh.face_K == std::vector<float>{300, 300, 400});
}

TEST_CASE("what is wrong with a PLY file is said with its line or element", "[scene][mesh][errors]") {
  const ScratchFolder folder;
  const std::string vertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const std::string header = "ply\nformat ascii 1.0\n" + vertices + faces;  // 9 lines
  const auto refused = [&](const std::string& text, const std::string& where, const std::string& says) {
    check_refused(folder.write("a.ply", text), where, says);
  };
  refused("plx\n", ", line 1", "begins with \"ply\"");
  refused("ply\nformat ascii 1.0\n", ", line 2", "no end");
  refused("ply\nformat binary 1.0\n", ", line 2", "\"binary\" is not known");
  refused("ply\nend_header\n", ", line 2", "no format");
  refused("ply\nformat ascii 1.0\nelement vertex many\n", ", line 3", "does not belong");
  refused("ply\nformat ascii 1.0\n" + vertices + vertices, ", line 7", "announced twice");
  refused("ply\nformat ascii 1.0\nelement vertex 1\nproperty real x\n", ", line 4", "does not belong");
  refused("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n", "", "no x, y and z");
  refused("ply\nformat ascii 1.0\n" + vertices + "element face 1\nproperty int a\nend_header\n0 0 0\n0 0 0\n0 0 0\n1\n",
          "", "no list vertex_indices");
  refused(header + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", ", line 13", "names vertex 3, but there are 3");
  refused(header + "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", ", line 13", "names vertex -1");
  refused(header + "0 0 0\n1 0 0\n0 1 0\n2 0 1\n", ", line 13", "2 of at least three");
  refused(header + "0 0 0\n1 0 0\n0 1 0\n3 0 1\n", ", line 13", "too few numbers");
  refused(header + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 3\n", ", line 13", "too many numbers");
  refused(header + "0 0 0\n1 0 nan\n", ", line 11", "z is not finite");
  refused(header + "0 0 0\n1 0 x\n", ", line 11", "\"x\" is no number");
  refused(header + "0 0 0\n1 0 0\n0 1 0\n", ", line 12", "ends at face 0 of 1");
  refused(header + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2\n", ", line 14", "more than the header announces");
  refused("ply\nformat ascii 1.0\n" + vertices + "property float K\n" + faces + "0 0 0 -1\n", ", line 11",
          "no temperature");
  refused("ply\nformat binary_little_endian 1.0\n" + vertices + faces + "12345678", "", "vertex 0: the file ends here");
  refused("ply\nformat ascii 1.0\n" + vertices + "end_header\n0 0 0\n1 0 0\n0 1 0\n", "", "holds no face");
}

TEST_CASE("STL is read as text and as binary", "[scene][mesh]") {
  const ScratchFolder folder;
  const std::string facet =
      "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nVERTEX 1e0 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
  const MeshFile text = read_mesh(folder.write(
      "a.stl", "solid left door\n" + facet + facet + "endsolid left door\n\nsolid right\n  " + facet + "endsolid\n"));
  CHECK(text.mesh.faces.size() == 3);
  CHECK(text.mesh.vertices.size() == 9);
  CHECK(text.mesh.slots == std::vector<std::uint16_t>{0, 0, 1});
  REQUIRE(text.slot_names.size() == 2);
  CHECK(text.slot_names[0] == std::vector<std::string>{"left door"});
  CHECK(normal_of(text.mesh, 0).z > 0);

  const MeshFile binary = read_mesh(folder.write("b.stl", binary_stl(2, 2, 5)));
  CHECK(binary.mesh.faces == std::vector<Face>{{0, 1, 2}, {3, 4, 5}});
  CHECK(binary.mesh.vertices[5] == Vec3d(0, 1, 5));
}

TEST_CASE("what is wrong with an STL file is said with its line or facet", "[scene][mesh][errors]") {
  const ScratchFolder folder;
  const auto refused = [&](const std::string& text, const std::string& where, const std::string& says) {
    check_refused(folder.write("a.stl", text), where, says);
  };
  refused("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n", ", line 5",
          "ends inside of a solid");
  refused("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n", ", line 6",
          "\"vertex\" is expected, found \"endloop\"");
  refused("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 nan\n", ", line 4", "z is not finite");
  refused("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n", ", line 4", "three coordinates");
  refused("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 b 0\n", ", line 4", "\"b\" is no coordinate");
  refused("solid a\nendsolid a\nnonsense\n", ", line 3", "\"solid\" is expected");
  refused("solid a\nendsolid a\n", "", "holds no face");
  refused("binary?", "", "neither a text");
  refused(std::string(80, ' ') + binary_stl(3, 2).substr(80), "", "announces 3 facets, but has room for 2");
  refused(binary_stl(1, 1, NAN), "", "facet 0: z is not finite");
  refused(binary_stl(0, 0), "", "holds no face");
}

TEST_CASE("glTF nodes are put where they stand, and mirrored ones keep their front", "[scene][mesh]") {
  const ScratchFolder folder;
  folder.write("b.bin", gltf_buffer());
  const MeshFile plain = read_mesh(folder.write("a.gltf", gltf("b.bin")));
  REQUIRE(plain.mesh.faces.size() == 1);
  CHECK(plain.slot_names[0] == std::vector<std::string>{"plate", "hull", "steel"});
  CHECK(normal_of(plain.mesh, 0).z == Approx(1));

  const MeshFile moved =
      read_mesh(folder.write("c.gltf", gltf("b.bin", R"(, "translation": [10, 20, 30], "scale": [2, 2, 2])")));
  CHECK(moved.mesh.vertices[1] == Vec3d(12, 20, 30));
  CHECK(normal_of(moved.mesh, 0).z == Approx(4));

  // Mirrored at x = 0 the triangle's front would turn to -z.
  const MeshFile mirrored = read_mesh(folder.write("d.gltf", gltf("b.bin", R"(, "scale": [-1, 1, 1])")));
  CHECK(mirrored.mesh.vertices[mirrored.mesh.faces[0][1]].x <= 0);
  CHECK(normal_of(mirrored.mesh, 0).z == Approx(1));
}

TEST_CASE("what is wrong with a glTF file is said", "[scene][mesh][errors]") {
  const ScratchFolder folder;
  check_refused(folder.write("a.gltf", "{"), "", "cannot be read as glTF");
  check_refused(folder.write("a.gltf", "no json at all"), "", "cannot be read as glTF");
  check_refused(folder.write("a.gltf", R"({"asset": {"version": "2.0"}})"), "", "");
  check_refused(folder.write("a.glb", "glTF"), "", "cannot be read as glTF");
  check_refused(folder.write("a.gltf", gltf("absent.bin")), "", "cannot be read as glTF");
  folder.write("short.bin", gltf_buffer().substr(0, 20));
  check_refused(folder.write("a.gltf", gltf("short.bin")), "", "");
  folder.write("nan.bin", gltf_buffer(2, NAN));
  check_refused(folder.write("a.gltf", gltf("nan.bin")), "", "is not finite");
  folder.write("far.bin", gltf_buffer(7));
  check_refused(folder.write("a.gltf", gltf("far.bin")), "", "");
}
