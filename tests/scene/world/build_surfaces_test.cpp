// From a description to the World's materials and objects.
#include "scene/world/build_surfaces.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "octree/base/error.h"
#include "scene/file/scene_io.h"
#include "scene/world/build_world.h"
#include "tests/support/places.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shared_data.h"

using namespace obscura;
using obscura::test::ScratchFolder;

namespace {

const char* const kLwir = R"({"name": "lwir", "um": [8, 12]})";

Description describe(const std::string& rest, const std::filesystem::path& folder = ".",
                     const std::string& bands = kLwir) {
  std::string text = R"({"obscura": 1, "bands": [)";
  text += bands;
  text += R"(], "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0]}, )";
  text += rest;
  text += "}";
  return parse_scene(text, folder);
}

WorldContents contents_of(const Description& scene) {
  WorldContents contents;
  for (const BandDescription& band : scene.bands) {
    contents.bands.push_back(band.grey() ? Band(band.name)
                                         : Band(band.name, (*band.um)[0], (*band.um)[1], band.samples, band.response));
  }
  build_surfaces(scene, contents);
  return contents;
}

WorldContents contents_of(const std::string& objects, const std::filesystem::path& folder = ".",
                          const std::string& bands = kLwir) {
  return contents_of(describe("\"objects\": [" + objects + "]", folder, bands));
}

const char* const kTwoGroups =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\ng wheel left\nusemtl rubber\nf 1 2 3\ng hull\nusemtl steel\nf 1 3 4\n";

std::filesystem::path folder_of(const ScratchFolder& folder) { return folder / ""; }

}  // namespace

TEST_CASE("a scene without objects has no materials either", "[scene][surfaces]") {
  const WorldContents contents = contents_of(describe(R"("materials": {"paint": {}})"));
  CHECK(contents.objects.empty());
  CHECK(contents.materials.empty());
}

TEST_CASE("an object's keys arrive: name, place, kelvin, both sides", "[scene][surfaces]") {
  const WorldContents contents = contents_of(
      R"({"shape": "sphere", "radius_m": 2, "K": 300},
         {"name": "lid", "shape": "plane", "size_m": [4, 2], "double_sided": true,
          "place": {"translate_m": [10, 20, 30], "rotate_deg": [0, 0, 90], "scale": 3}})");
  REQUIRE(contents.objects.size() == 2);
  CHECK(contents.objects[0].name == "object1");
  CHECK_FALSE(contents.objects[0].mesh);
  CHECK(contents.objects[0].radius == 2);
  CHECK(contents.objects[0].K == std::vector<double>{300});
  CHECK(contents.objects[0].materials == std::vector<int>{0});
  CHECK(contents.objects[0].radiance.empty());
  CHECK_FALSE(contents.objects[0].double_sided);
  const Object& lid = contents.objects[1];
  CHECK(lid.name == "lid");
  CHECK(lid.double_sided);
  CHECK(lid.mesh->faces.size() == 2);
  CHECK((transform_point(lid.local_to_world, Vec3d(2, 0, 0)) - Vec3d(10, 26, 30)).length() < 1e-12);
  // Without K it emits nothing.
  CHECK(lid.K == std::vector<double>{0});
  REQUIRE(lid.radiance.size() == 1);
  CHECK(lid.radiance[0] == 0.0);
  REQUIRE(contents.materials.size() == 1);
  CHECK(contents.materials[0].emissivity == std::vector<double>{1});
  CHECK(contents.materials[0].permeable == 0);
}

TEST_CASE("a material's keys arrive, its emissivity at every interval", "[scene][surfaces]") {
  const WorldContents contents = contents_of(describe(
      R"("objects": [{"shape": "sphere", "radius_m": 1, "material": "paint"}],
         "materials": {"chrome": {"emissivity": 0.1},
                       "paint": {"emissivity": {"um": [8, 12], "value": [0.2, 0.6]}, "specular": 0.25, "roughness": 0.1, "permeable": 0.5,
                                 "emissivity_by_angle": {"angle_deg": [0, 90], "factor": [1, 0.5]}}})",
      ".", R"({"name": "lwir", "um": [8, 12], "samples": 2})"));
  const Material& paint = contents.materials[static_cast<std::size_t>(contents.objects[0].materials[0])];
  REQUIRE(paint.emissivity.size() == 2);
  CHECK(paint.emissivity[0] == Approx(0.3));
  CHECK(paint.emissivity[1] == Approx(0.5));
  CHECK(paint.specular == 0.25);
  CHECK(paint.roughness == 0.1);
  CHECK(paint.permeable == 0.5);
  CHECK(paint.angle_deg == std::vector<double>{0, 90});
  CHECK(paint.angle_factor == std::vector<double>{1, 0.5});
}

TEST_CASE("groups and materials of a mesh file get what the scene says of them", "[scene][surfaces]") {
  const ScratchFolder folder;
  folder.write("truck.obj", kTwoGroups);
  const auto object_of = [&](const std::string& groups) {
    return contents_of(describe(R"("objects": [{"mesh": "truck.obj", "material": "paint", "K": 290, "groups": )" +
                                    groups + R"(}], "materials": {"paint": {}, "tyre": {}})",
                                folder_of(folder)));
  };
  // Materials: 0 black, 1 paint, 2 tyre.
  const WorldContents plain = object_of("{}");
  CHECK(plain.objects[0].materials == std::vector<int>{1, 1});
  CHECK(plain.objects[0].K == std::vector<double>{290, 290});
  CHECK(plain.objects[0].mesh->slots == std::vector<std::uint16_t>{0, 1});
  const WorldContents by_group = object_of(R"({"wheel": {"material": "tyre", "K": 310}})");
  CHECK(by_group.objects[0].materials == std::vector<int>{2, 1});
  CHECK(by_group.objects[0].K == std::vector<double>{310, 290});
  const WorldContents by_material = object_of(R"({"steel": {"K": 320}})");
  CHECK(by_material.objects[0].materials == std::vector<int>{1, 1});
  CHECK(by_material.objects[0].K == std::vector<double>{290, 320});
  // The group is more telling than the material.
  CHECK(object_of(R"({"rubber": {"K": 1}, "wheel": {"K": 2}})").objects[0].K == std::vector<double>{2, 290});

  try {
    object_of(R"({"whel": {"K": 1}, "chrome": {"K": 2}, "hull": {"K": 3}})");
    FAIL("accepted");
  } catch (const InputError& error) {
    INFO(error.what());
    REQUIRE(error.problems().size() == 2);
    CHECK(error.problems()[0].where == "/objects/0/groups/chrome");
    CHECK(error.problems()[0].problem.find("no group or material \"chrome\"") != std::string::npos);
    CHECK(error.problems()[1].hint == "did you mean \"wheel\"?");
  }
}

TEST_CASE("objects of one mesh file share it, those with a table of temperatures theirs", "[scene][surfaces]") {
  const ScratchFolder folder;
  folder.write("truck.obj", kTwoGroups);
  folder.write("K.csv", "face,K\n1,350\n");
  folder.write("hill.asc", "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4\n");
  const WorldContents contents = contents_of(
      R"({"mesh": "truck.obj", "K": 300}, {"mesh": "truck.obj"}, {"mesh": "truck.obj", "temperature": {"file": "K.csv"}},
         {"mesh": "truck.obj", "temperature": {"file": "K.csv"}, "K": 280}, {"mesh": "hill.asc"})",
      folder_of(folder));
  const auto& objects = contents.objects;
  CHECK(objects[0].mesh == objects[1].mesh);
  CHECK(objects[2].mesh == objects[3].mesh);
  CHECK(objects[0].mesh != objects[2].mesh);
  CHECK(objects[0].mesh->face_K.empty());
  REQUIRE(objects[2].mesh->face_K.size() == 2);
  CHECK(objects[2].mesh->face_K[1] == 350);
  // Its table makes it emit where it has no K of its own.
  CHECK(objects[2].radiance.empty());
  CHECK(objects[4].mesh->faces.size() == 2);
  CHECK(objects[4].radiance[0] == 0.0);
}

TEST_CASE("an object's radiance stands in for Planck, in grey bands beside it", "[scene][surfaces]") {
  const auto radiance_of = [](const std::string& keys, const std::string& bands) {
    return contents_of(R"({"shape": "sphere", "radius_m": 1)" + keys + "}", ".", bands).objects[0].radiance;
  };
  const std::string both = std::string(kLwir) + R"(, {"name": "grey"})";
  using List = std::vector<std::optional<double>>;
  CHECK(radiance_of(R"(, "radiance": 2)", kLwir) == List{8.0});  // per um over 4 um
  CHECK(radiance_of(R"(, "radiance": 2)", both) == List{8.0, 2.0});
  CHECK(radiance_of(R"(, "radiance": 2, "K": 300)", both) == List{std::nullopt, 2.0});
  CHECK(radiance_of("", both) == List{0.0, 0.0});
  CHECK(radiance_of(R"(, "K": 300)", kLwir).empty());
}

TEST_CASE("every broken mesh is told in one run", "[scene][surfaces][errors]") {
  const ScratchFolder folder;
  folder.write("a.obj", "f 1 2 3\n");
  folder.write("b.stl", "nothing");
  folder.write("c.asc", "ncols 2\n");
  folder.write("d.obj", kTwoGroups);
  folder.write("K.csv", "face,K\n9,300\n");
  try {
    contents_of(
        R"({"mesh": "a.obj"}, {"mesh": "b.stl"}, {"mesh": "c.asc"}, {"mesh": "d.obj", "temperature": {"file": "K.csv"}})",
        folder_of(folder));
    FAIL("accepted");
  } catch (const InputError& error) {
    INFO(error.what());
    REQUIRE(error.problems().size() == 4);
    CHECK(error.problems()[0].where == (folder / "a.obj").string() + ", line 1");
    CHECK(error.problems()[3].where == (folder / "K.csv").string() + ", line 2");
  }
}

TEST_CASE("jeep, truck and mountain stand in one scene", "[scene][surfaces][shared]") {
  for (const char* name : {"data/meshes/jeep1/jeep1.obj", "data/meshes/cesium_milk_truck/CesiumMilkTruck.gltf",
                           "data/terrain_st_helens_dem/SainteHelens.asc.gz"}) {
    if (test::shared_file(name).empty()) return;
  }
  const WorldContents contents = contents_of(describe(
      R"("objects": [{"mesh": "meshes/jeep1/jeep1.obj", "K": 290, "groups": {"Material01": {"K": 300}, "3": {"K": 350}}},
                     {"mesh": "meshes/cesium_milk_truck/CesiumMilkTruck.gltf", "groups": {"Effect-wheels": {"material": "rubber"}}},
                     {"mesh": "terrain_st_helens_dem/SainteHelens.asc.gz"}], "materials": {"rubber": {"emissivity": 0.95}})",
      std::filesystem::path(test::shared_path("data"))));
  CHECK(contents.objects[0].K == std::vector<double>{300, 300, 300, 350, 300, 300, 300});
  CHECK(contents.objects[1].materials == std::vector<int>{0, 0, 0, 1, 1});
  CHECK(contents.objects[2].mesh->faces.size() > 290000);
}
