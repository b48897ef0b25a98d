#include "tests/scene/file/scene_mistakes.h"

#include <catch2/catch.hpp>

#include "scene/file/scene_io.h"
#include "tests/scene/full_scene.h"

using namespace obscura;
using obscura::test::check_mistakes;
using obscura::test::full_scene;
using obscura::test::has;
using obscura::test::Json;
using obscura::test::kSmallest;
using obscura::test::Mistake;
using obscura::test::other_scene;
using obscura::test::problems_of;
using obscura::test::SceneFolder;
using obscura::test::text_of;

TEST_CASE("six mistakes give six messages, each with pointer, problem and remedy", "[scene][reader]") {
  const auto problems = problems_of(R"({
    "obscura": 1,
    "bands": [{"name": "lwir", "um": [12, 8]}],
    "clouds": [{"grid": {"file": "absent.vdb"}, "media": [{"density": "density", "extinction": -1}]}],
    "sensor": {"position_m": [0, -10, 1], "look_at_m": [0, 0], "fov": 20},
    "render": {"photons": "many"}
  })");
  INFO(text_of(problems));
  CHECK(problems.size() == 6);
  for (const Problem& p : problems) {
    CHECK(p.where[0] == '/');
    CHECK_FALSE(p.problem.empty());
    CHECK_FALSE(p.hint.empty());
  }
}

TEST_CASE("an unknown key is told with the nearest valid one", "[scene][reader]") {
  const SceneFolder folder("io_unknown");
  check_mistakes(full_scene(), folder.path(),
                 {{"/sensor/fov", 20, "/sensor/fov", "did you mean \"fov_deg\"?"},
                  {"/sensor/fov_rad", 1, "/sensor/fov_rad", "did you mean \"fov_deg\"?"},
                  {"/cloud", Json::array(), "/cloud", "did you mean \"clouds\"?"},
                  {"/render/Photons", 1, "/render/Photons", "did you mean \"photons\"?"},
                  {"/clouds/0/media/0/extinctoin", 1, "/clouds/0/media/0/extinctoin", "\"extinction\""},
                  {"/clouds/0/place/translate", 1, "/clouds/0/place/translate", "\"translate_m\""},
                  {"/clouds/0/media/1/extinction/values", 1, "/clouds/0/media/1/extinction/values", "\"value\""},
                  {"/environment/sun/diameter", 1, "/environment/sun/diameter", "\"diameter_deg\""},
                  {"/sensor/detector/bit", 1, "/sensor/detector/bit", "\"bits\""},
                  {"/a~1b", 1, "/a~1b", "the nearest is"}});
  // A misspelt key that is required is one mistake.
  Json scene = other_scene();
  scene["sensor"]["position"] = scene["sensor"]["position_m"];
  scene["sensor"].erase("position_m");
  const auto problems = problems_of(scene.dump());
  INFO(text_of(problems));
  REQUIRE(problems.size() == 1);
  CHECK(problems[0].where == "/sensor/position");
}

TEST_CASE("what is missing is told where it belongs", "[scene][reader]") {
  for (const char* pointer : {"/obscura", "/bands", "/sensor", "/sensor/position_m", "/sensor/look_at_m"}) {
    Json scene = other_scene();
    const Json::json_pointer at(pointer);
    scene[at.parent_pointer()].erase(at.back());
    const auto problems = problems_of(scene.dump());
    INFO(pointer << "\n" << text_of(problems));
    REQUIRE(problems.size() == 1);
    CHECK(problems[0].where == pointer);
    CHECK(has(problems[0].problem, "is missing"));
  }
  const SceneFolder folder("io_missing");
  check_mistakes(full_scene(), folder.path(),
                 {{"/clouds/0/grid", nullptr, "/clouds/0/grid", "grid | frames | puffs"},
                  {"/clouds/0/media", nullptr, "/clouds/0/media", "is missing"},
                  {"/clouds/0/media", Json::array(), "/clouds/0/media", "at least one"},
                  {"/clouds/0/media/0/extinction", nullptr, "/clouds/0/media/0/extinction", "is missing"},
                  {"/clouds/0/period_m", nullptr, "/clouds/0/period_m", "is missing"},
                  {"/bands", Json::array(), "/bands", "at least one"},
                  {"/environment/sun/toward", nullptr, "/environment/sun/toward", "is missing"}});
}

TEST_CASE("values out of range are refused", "[scene][reader]") {
  const SceneFolder folder("io_range");
  check_mistakes(full_scene(), folder.path(),
                 {{"/obscura", 2, "/obscura", "out of range"},
                  {"/clouds/0/media/0/extinction", -1, "/clouds/0/media/0/extinction", "out of range"},
                  {"/clouds/0/media/0/albedo", 1.1, "/clouds/0/media/0/albedo", "from 0 to 1"},
                  {"/clouds/0/media/1/extinction/value/0", -1, "/clouds/0/media/1/extinction/value/0", "out of range"},
                  {"/clouds/0/media/0/phase/g", -1.1, "/clouds/0/media/0/phase/g", "from -1 to 1"},
                  {"/clouds/0/place/scale", 0, "/clouds/0/place/scale", "above 0"},
                  {"/bands/0/um", {12, 8}, "/bands/0/um/1", "increase"},
                  {"/bands/0/um", {0, 8}, "/bands/0/um/0", "above 0"},
                  {"/bands/0/samples", 0, "/bands/0/samples", "out of range"},
                  {"/bands/0/response/um", {8, 8, 12}, "/bands/0/response/um/1", "increase"},
                  {"/bands/0/response/value", {0, 0, 0}, "/bands/0/response", "is 0"},
                  {"/bands/0/response/value", {0, 1}, "/bands/0/response", "3 wavelengths but 2 values"},
                  {"/sensor/fov_deg", 0, "/sensor/fov_deg", "above 0"},
                  {"/sensor/fov_deg", 180, "/sensor/fov_deg", "180"},
                  {"/sensor/resolution", {0, 5}, "/sensor/resolution/0", "out of range"},
                  {"/sensor/resolution", {2.5, 5}, "/sensor/resolution/0", "whole number"},
                  {"/sensor/max_oversampling", 0, "/sensor/max_oversampling", "out of range"},
                  {"/sensor/scattering_depth", -1, "/sensor/scattering_depth", "out of range"},
                  {"/render/photons", -1, "/render/photons", "out of range"},
                  {"/render/nearest", 0, "/render/nearest", "out of range"},
                  {"/render/octree_tolerance", 1, "/render/octree_tolerance", "below 1"},
                  {"/render/photon_power_min", -1, "/render/photon_power_min", "out of range"},
                  {"/render/seed", -1, "/render/seed", "out of range"},
                  {"/render/kernel", "cube", "/render/kernel", "epanechnikov"},
                  {"/render/method", "photons", "/render/method", "did you mean \"photon\"?"},
                  {"/sources/0/radius_m", 0, "/sources/0/radius_m", "above 0"},
                  {"/clouds/1/temperature/K", -5, "/clouds/1/temperature/K", "out of range"},
                  {"/beams/0/power", -1, "/beams/0/power", "out of range"},
                  {"/flux/0/size_m", {0, 1}, "/flux/0/size_m/0", "above 0"}});
  CHECK(parse_scene(kSmallest, ".", {{"/render/seed", "18446744073709551615", ""}}).render.seed ==
        18446744073709551615u);
}

TEST_CASE("values that do not go together are refused", "[scene][reader]") {
  const SceneFolder folder("io_together");
  check_mistakes(full_scene(), folder.path(),
                 {{"/sensor/up", {0, 1, 0}, "/sensor/up", "parallel"},
                  {"/sensor/up", {0, 0, 0}, "/sensor/up", "no length"},
                  {"/sensor/look_at_m", {0, -10, 1}, "/sensor/look_at_m", "own position"},
                  {"/sensor/projection", "orthographic", "/sensor/width_m", "is missing"},
                  {"/environment/sun/toward", {0, 0, 0}, "/environment/sun/toward", "no length"},
                  {"/environment/sun/zenith_deg", 30, "/environment/sun/zenith_deg", "does not go with \"toward\""},
                  {"/environment/sun/azimuth_deg", 30, "/environment/sun/azimuth_deg", "does not go with \"toward\""},
                  {"/environment/sky/K", 250, "/environment/sky/radiance", "both given"},
                  {"/beams/0/toward", {0, 0, 0}, "/beams/0/toward", "no length"},
                  {"/flux/0/normal", {0, 0, 0}, "/flux/0/normal", "no length"},
                  {"/bands/1/name", "lwir", "/bands/1/name", "given twice"},
                  {"/clouds/1/name", "smoke", "/clouds/1/name", "given twice"},
                  {"/bands/1/name", "name", "/bands/1/name", "cannot name a band"},
                  {"/clouds/0/puffs",
                   {{"sources", {{{"position_m", {0, 0, 0}}, {"mass_g", 1}}}}},
                   "/clouds/0/puffs",
                   "both given"},
                  {"/clouds/0/grid/shape", "sphere", "/clouds/0/grid/shape", "does not go with \"file\""},
                  {"/clouds/2/grid/size_m", {1, 1, 1}, "/clouds/2/grid/size_m", "does not go with \"sphere\""},
                  {"/clouds/2/grid/shape", "cone", "/clouds/2/grid/shape", "sphere, box, gaussian"},
                  {"/clouds/2/media/0/density", "smoke", "/clouds/2/media/0/density", "a shape has no grid \"smoke\""},
                  {"/clouds/1/media/0/density", "smoke", "/clouds/1/media/0/density", "density and temperature"},
                  {"/clouds/1/temperature", {{"grid", "T"}}, "/clouds/1/temperature/grid", "puffs have no grid \"T\""},
                  {"/clouds/2/grid/voxel_m", 1e-9, "/clouds/2/grid/voxel_m", "voxels"},
                  {"/clouds/0/temperature/K", 300, "/clouds/0/temperature/K", "does not go with \"grid\""},
                  {"/clouds/0/periodic", {"x", "x"}, "/clouds/0/periodic", "same axis"},
                  {"/clouds/0/periodic", {"x"}, "/clouds/0/period_m", "2 periods for 1"},
                  {"/clouds/0/periodic", nullptr, "/clouds/0/period_m", "no axis is periodic"},
                  {"/sources/0/K", nullptr, "/sources/0/K", "neither"},
                  {"/sources/0/radiance", 5, "/sources/0/radiance", "both given"},
                  {"/clouds/0/media/4/phase/angle_deg", {0, 90}, "/clouds/0/media/4/phase", "180"},
                  {"/clouds/0/media/4/phase/file", "phase.csv", "/clouds/0/media/4/phase/file", "both given"},
                  {"/clouds/0/media/5/phase/value", {1, 2}, "/clouds/0/media/5/phase/value", "both given"}});
}

TEST_CASE("mistakes in objects, materials and air are each told with a remedy", "[scene][reader][surfaces]") {
  const SceneFolder folder("io_surfaces");
  check_mistakes(
      full_scene(), folder.path(),
      {{"/objects/0/material", "pant", "/objects/0/material", "did you mean \"paint\"?"},
       {"/objects/0/groups/wheel/material", "rubbber", "/objects/0/groups/wheel/material", "did you mean \"rubber\"?"},
       {"/objects/0/groups/wheel/K", -1, "/objects/0/groups/wheel/K", "at least 0"},
       {"/objects/0/groups/wheel/colour", 1, "/objects/0/groups/wheel/colour", "unknown key"},
       {"/objects/0/mesh", "absent.obj", "/objects/0/mesh", "no such file"},
       {"/objects/0/mesh", "table.csv", "/objects/0/mesh", ".asc.gz"},
       {"/objects/0/temperature/file", "absent.csv", "/objects/0/temperature/file", "no such file"},
       {"/objects/0/K", -1, "/objects/0/K", "out of range"},
       {"/objects/0/radiance", 5, "/objects/0/radiance", "both given"},
       {"/objects/0/double_sided", 1, "/objects/0/double_sided", "true or false"},
       {"/objects/0/shape", "box", "/objects/0/shape", "does not go with \"mesh\""},
       {"/objects/0/place/scale", 0, "/objects/0/place/scale", "above 0"},
       {"/objects/1/name", "truck", "/objects/1/name", "given twice"},
       {"/objects/1/size_m", {1, 0}, "/objects/1/size_m/1", "above 0"},
       {"/objects/1/size_m", {1, 1, 1}, "/objects/1/size_m", "list of 2"},
       {"/objects/1/groups", {{"a", {{"K", 3}}}}, "/objects/1/groups", "does not go with \"plane\""},
       {"/objects/1/shape", "disc", "/objects/1/shape", "plane, box, sphere"},
       {"/objects/2/size_m", {1, 1}, "/objects/2/size_m", "list of 3"},
       {"/objects/3/radius_m", 0, "/objects/3/radius_m", "above 0"},
       {"/objects/3/radius_m", nullptr, "/objects/3/radius_m", "is missing"},
       {"/objects/3/shape", nullptr, "/objects/3/mesh", "mesh | shape"},
       {"/materials/paint/emissivity", 1.5, "/materials/paint/emissivity", "from 0 to 1"},
       {"/materials/paint/specular", -0.1, "/materials/paint/specular", "from 0 to 1"},
       {"/materials/paint/roughness", -0.1, "/materials/paint/roughness", "at least 0"},
       {"/materials/paint/permeable", 2, "/materials/paint/permeable", "from 0 to 1"},
       {"/materials/paint/emisivity", 1, "/materials/paint/emisivity", "did you mean \"emissivity\"?"},
       {"/materials/paint/emissivity_by_angle/factor",
        {1},
        "/materials/paint/emissivity_by_angle",
        "2 angles but 1 factors"},
       {"/materials/paint/emissivity_by_angle/angle_deg",
        {90, 0},
        "/materials/paint/emissivity_by_angle/angle_deg/1",
        "increase"},
       {"/materials/paint/emissivity_by_angle/angle_deg",
        {0, 91},
        "/materials/paint/emissivity_by_angle/angle_deg/1",
        "from 0 to 90"},
       {"/materials", 3, "/materials", "expected an object"},
       {"/environment/moon", {{"toward", {0, 0, 0}}}, "/environment/moon/toward", "no length"},
       {"/environment/moon", {{"irradiance", 1}}, "/environment/moon/toward", "toward | zenith_deg"},
       {"/environment/atmosphere/extinction_per_m", -1, "/environment/atmosphere/extinction_per_m", "out of range"},
       {"/environment/atmosphere/extinction", 1, "/environment/atmosphere/extinction",
        "did you mean \"extinction_per_m\"?"},
       {"/environment/atmosphere/radiance", 1, "/environment/atmosphere/radiance", "both given"},
       {"/sensor/specular_depth", -1, "/sensor/specular_depth", "out of range"},
       {"/sensor/specular_depth", 0.5, "/sensor/specular_depth", "whole number"}});
  Json scene = full_scene();
  scene.erase("materials");
  const auto problems = problems_of(scene.dump(), folder.path());
  INFO(text_of(problems));
  CHECK(problems.size() == 3);
  CHECK(has(problems[0].hint, "describe it in \"materials\""));
  CHECK(parse_scene(kSmallest, ".", {{"/sensor/specular_depth", "0", ""}}).sensor.specular_depth == 0);
  CHECK(parse_scene(kSmallest, ".", {{"/materials", R"({"black": null})", ""}}).materials.count("black") == 1);
}

TEST_CASE("a grey band takes neither kelvin nor wavelengths", "[scene][reader][grey]") {
  const Json grey = Json::parse(R"({
    "obscura": 1, "bands": [{"name": "grey"}],
    "clouds": [{"grid": {"shape": "sphere", "radius_m": 1, "voxel_m": 0.1}, "media": [{"extinction": 1}], "source": 1}],
    "sources": [{"position_m": [0, 0, 2], "radius_m": 0.1, "radiance": 1}],
    "environment": {"sky": {"radiance": 1}},
    "sensor": {"position_m": [0, -10, 1], "look_at_m": [0, 0, 1]}
  })");
  const SceneFolder folder("io_grey");
  CHECK(problems_of(grey.dump()).empty());
  const Json table = Json::parse(R"({"um": [8, 12], "value": [1, 2]})");
  check_mistakes(
      grey, folder.path(),
      {{"/clouds/0/temperature", {{"K", 300}}, "/clouds/0/temperature/K", "grey band \"grey\""},
       {"/clouds/0/temperature", {{"grid", "density"}}, "/clouds/0/temperature", "grey band"},
       {"/sources/0", {{"position_m", {0, 0, 2}}, {"radius_m", 0.1}, {"K", 900}}, "/sources/0/K", "grey band"},
       {"/environment/sky", {{"K", 250}}, "/environment/sky/K", "give \"radiance\" instead"},
       {"/particles", {{"file", "p.csv"}}, "/particles", "grey band"},
       {"/clouds/0/media/0/extinction", table, "/clouds/0/media/0/extinction", "no wavelength"},
       {"/objects", {{{"shape", "sphere"}, {"radius_m", 1}, {"K", 300}}}, "/objects/0/K", "give \"radiance\" instead"},
       {"/objects", {{{"shape", "sphere"}, {"radius_m", 1}, {"K", 300}, {"radiance", 1}}}, "/objects/0/K", "grey band"},
       {"/objects",
        {{{"mesh", "truck.obj"}, {"temperature", {{"file", "K.csv"}}}}},
        "/objects/0/temperature",
        "grey band"},
       {"/objects", {{{"mesh", "truck.obj"}, {"groups", {{"a", {{"K", 3}}}}}}}, "/objects/0/groups/a/K", "grey band"},
       {"/materials",
        {{"paint", {{"emissivity", {{"um", {8, 12}}, {"value", {0.5, 1}}}}}}},
        "/materials/paint/emissivity",
        "no wavelength"},
       {"/environment/atmosphere", {{"extinction_per_m", 1}, {"K", 300}}, "/environment/atmosphere/K", "grey band"},
       {"/bands/0/samples", 2, "/bands/0/samples", "no wavelengths"},
       {"/bands/0/response", table, "/bands/0/response", "no wavelengths"}});

  // Beside a band with wavelengths each takes its own.
  Json mixed = grey;
  mixed["bands"].push_back({{"name", "lwir"}, {"um", {8, 12}}});
  mixed["clouds"][0]["temperature"] = {{"K", 300}};
  mixed["objects"] = {{{"shape", "sphere"}, {"radius_m", 1}, {"K", 300}, {"radiance", 2}}};
  const Description scene = parse_scene(mixed.dump(), ".");
  CHECK(emitter(scene, scene.bands[0], true, true) == Emitter::radiance);
  CHECK(emitter(scene, scene.bands[1], true, true) == Emitter::planck);
  CHECK(emitter(scene, scene.bands[0], true, false) == Emitter::none);
  CHECK(emitter(scene, scene.bands[1], false, true) == Emitter::radiance);
  mixed["clouds"][0].erase("source");
  CHECK(problems_of(mixed.dump()).size() == 1);
}

TEST_CASE("keys that come later are refused by name unless they hold their default", "[scene][reader][later]") {
  const SceneFolder folder("io_later");
  const Json some = {{"a", 1}};
  std::vector<Mistake> later;
  for (const char* pointer :
       {"/objects/0/trajectory", "/objects/0/carried_by", "/clouds/0/trajectory", "/clouds/0/carried_by",
        "/clouds/0/media/0/mie", "/clouds/0/media/0/coefficients", "/clouds/0/media/0/radius", "/environment/sky/file",
        "/environment/sky/elevation_deg", "/render/memory_MiB"}) {
    later.push_back({pointer, some, pointer, "not available yet"});
    later.push_back({pointer, 12, pointer, "not available yet"});
  }
  check_mistakes(full_scene(), folder.path(), later);
  check_mistakes(full_scene(), folder.path(), {{"/render/final_gather", 2, "/render/final_gather", "out of range"}});

  check_mistakes(full_scene(), folder.path(),
                 {{"/environment/sky",
                   {{"elevation_deg", {0, 90}}, {"K", {280, 250}}},
                   "/environment/sky/elevation_deg",
                   "not available yet"}});

  Json frames = full_scene();
  frames["clouds"][0].erase("grid");
  frames["clouds"][0]["frames"] = {{"by", "time"}};
  const auto problems = problems_of(frames.dump(), folder.path());
  INFO(text_of(problems));
  REQUIRE(problems.size() == 1);
  CHECK(problems[0].where == "/clouds/0/frames");

  for (const auto& [pointer, value] :
       std::vector<std::pair<const char*, Json>>{{"/sensor/antialiasing", {{"polygons", 2.0}}},
                                                 {"/sensor/detector", Json::object()},
                                                 {"/sensor/detector/range", {0.0, 1.0}},
                                                 {"/objects/0/trajectory", Json::object()},
                                                 {"/particles", Json::object()},
                                                 {"/render/final_gather", 0}}) {
    Json changed = full_scene();
    changed[Json::json_pointer(pointer)] = value;
    INFO(pointer << " " << value.dump());
    CHECK(problems_of(changed.dump(), folder.path()).empty());
  }
}

TEST_CASE("files that cannot be read are told with the rest", "[scene][reader]") {
  const SceneFolder folder("io_files");
  folder.write("wrong.csv", "wavelength,value\n8,1\n");
  folder.write("letters.csv", "um,value\n8,one\n");
  folder.write("falling.csv", "um,value\n8,1\n7,1\n");
  folder.write("empty.csv", "um,value\n");
  folder.write("truck.gltf", R"({"buffers": [{"uri": "data:,x"}, {"uri": "K.csv"}, {"uri": "two%20words.bin"}]})");
  folder.write("old.gltf", R"({"buffers": {"b": {"uri": "absent.bin"}}})");
  folder.write("raw2.json", R"([{"raw": "cloud.f32"}, {"raw": "absent.f32"}])");
  check_mistakes(full_scene(), folder.path(),
                 {{"/clouds/0/grid/file", "absent.vdb", "/clouds/0/grid/file", "no such file"},
                  {"/clouds/0/grid/file", ".", "/clouds/0/grid/file", "extension"},
                  {"/clouds/0/grid/file", "table.csv", "/clouds/0/grid/file", ".nvdb"},
                  {"/clouds/0/grid/file", "raw2.json", "/clouds/0/grid/file", "absent.f32"},
                  {"/clouds/0/media/0/albedo/file", "absent.csv", "/clouds/0/media/0/albedo/file", "no such file"},
                  {"/clouds/0/media/0/albedo/file", "wrong.csv", "/clouds/0/media/0/albedo/file", "um,value"},
                  {"/clouds/0/media/0/albedo/file", "letters.csv", "/clouds/0/media/0/albedo/file", "line 2"},
                  {"/clouds/0/media/0/albedo/file", "falling.csv", "/clouds/0/media/0/albedo/file", "7 um"},
                  {"/clouds/0/media/0/albedo/file", "empty.csv", "/clouds/0/media/0/albedo/file", "no numbers"},
                  {"/clouds/0/media/5/phase/file", "table.csv", "/clouds/0/media/5/phase/file", "angle_deg,value"},
                  {"/particles/file", "table.csv", "/particles/file", "s,x_m,y_m,z_m,radius_m,K"},
                  {"/objects/0/mesh", "truck.gltf", "/objects/0/mesh", "two words.bin: there is no such file"},
                  {"/objects/0/mesh", "old.gltf", "/objects/0/mesh", "absent.bin"}});
  Json raw = full_scene();
  raw["clouds"][0]["grid"]["file"] = "raw.json";
  CHECK(problems_of(raw.dump(), folder.path()).empty());
  folder.write("two words.bin", "x");
  raw["objects"][0]["mesh"] = "truck.gltf";
  CHECK(problems_of(raw.dump(), folder.path()).empty());
}

TEST_CASE("text that is not JSON is told with its place, a key given twice with its pointer", "[scene][reader]") {
  const auto where = [](const std::string& text) {
    const auto problems = problems_of(text);
    return problems.empty() ? std::string() : problems[0].where;
  };
  CHECK(where("{\n  \"obscura\": 1,\n  \"bands\": [}\n") == "scene: line 3, column 13");
  CHECK(has(where(""), "line 1, column 1"));
  CHECK(has(where("{\"obscura\": 1} x"), "line 1, column 16"));
  CHECK(has(where("{\"obscura\": 1e999}"), "line 1"));
  CHECK(has(where("{\"obscura\": \""
                  "\xff"
                  "\"}"),
            "line 1"));
  CHECK(where("[]").empty());  // the whole document: pointer ""
  CHECK(problems_of("[]")[0].problem == "expected an object, found the list []");
  CHECK(has(text_of(problems_of(std::string(100000, '['))), "nested deeper"));

  const auto twice = problems_of(R"({"obscura": 1, "bands": [{"name": "a"}, {"name": "b", "name": "c"}],
                                      "sensor": {"position_m": [0, -10, 1], "look_at_m": [0, 0, 1]}})");
  REQUIRE(twice.size() == 1);
  CHECK(twice[0].where == "/bands/1/name");
  CHECK(has(twice[0].problem, "given twice"));
}
