// From a description to the World: places, optics, temperatures, lattices, sources.
#include "scene/world/build_world.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "photon/world/spectral_world.h"
#include "scene/file/scene_io.h"
#include "tests/support/scratch_folder.h"

using namespace obscura;

namespace {

std::string scene_with(std::string_view cloud, std::string_view rest = "") {
  std::string text = R"({"obscura": 1, "bands": [{"name": "lwir", "um": [8, 12]}], "clouds": [)";
  text += cloud;
  text += R"(], "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0]})";
  text += rest;
  text += "}";
  return text;
}

/// A scene with one cloud, a box of smoke, to which `rest` adds keys.
std::string scene_with_box(std::string_view rest, std::string_view beside = "") {
  std::string cloud = R"({"grid": {"shape": "box", "size_m": [2, 1, 1], "voxel_m": 0.125},
                          "media": [{"density": "density", "extinction": 0.5, "albedo": 0.25}])";
  cloud += rest;
  cloud += "}";
  return scene_with(cloud, beside);
}

BuiltWorld build(const std::string& text, double time_s = 0, const std::filesystem::path& folder = ".") {
  return build_world(parse_scene(text, folder), time_s);
}

double depth_along(const World& world, const Vec3d& from, const Vec3d& direction, int interval = 0) {
  const Ray ray{from, direction, 0, kInfinity};
  double depth = 0;
  SpectralWorld(world, interval).optical_depths({&ray, 1}, {&depth, 1});
  return depth;
}

}  // namespace

TEST_CASE("a place scales lengths, turns and shifts a cloud, and leaves its density", "[scene][world]") {
  const World world =
      build(scene_with_box(R"(, "place": {"translate_m": [10, 20, 30], "rotate_deg": [0, 0, 90], "scale": 3})")).world;
  CHECK(world.bounds().min.x == Approx(10 - 1.5));
  CHECK(world.bounds().max.y == Approx(20 + 3));
  // The long side, 2 m, has become 6 m along y.
  CHECK(depth_along(world, {10.1, -100, 30.1}, {0, 1, 0}) == Approx(0.5 * 6).epsilon(1e-5));
  CHECK(depth_along(world, {-100, 20.1, 30.1}, {1, 0, 0}) == Approx(0.5 * 3).epsilon(1e-5));
  CHECK(SpectralWorld(world, 0).at({10, 22.9, 30}).extinction == Approx(0.5));
  CHECK(SpectralWorld(world, 0).at({10, 23.1, 30}).extinction == 0);
}

TEST_CASE("media of one grid add up and keep their own albedo", "[scene][world]") {
  const World world = build(scene_with(R"({"grid": {"shape": "box", "size_m": [1, 1, 1], "voxel_m": 0.25}, "media": [
      {"density": "density", "extinction": 0.5, "albedo": 0.25}, {"density": "density", "extinction": 2, "albedo": 0.75}]})"))
                          .world;
  CHECK(SpectralWorld(world, 0).at(Vec3d(0)).extinction == Approx(2.5));
  CHECK(SpectralWorld(world, 0).at(Vec3d(0)).scattering == Approx(0.125 + 1.5));
}

TEST_CASE("a temperature emits Planck's radiance by Kirchhoff's law", "[scene][world]") {
  const World world = build(scene_with_box(R"(, "temperature": {"K": 300})")).world;
  CHECK(SpectralWorld(world, 0).at(Vec3d(0)).emission == Approx(0.5 * 0.75 * world.bands()[0].planck(300)));
}

TEST_CASE("a source stands in for Planck, an emission is added as it is", "[scene][world]") {
  const World world = build(scene_with_box(R"(, "source": 2, "emission": 3)")).world;
  // Both are per um over a band of 4 um.
  CHECK(SpectralWorld(world, 0).at(Vec3d(0)).emission == Approx(0.5 * 0.75 * 2 * 4 + 3 * 4));
}

TEST_CASE("spectral optics are taken where each interval is", "[scene][world]") {
  const World world = build(R"({"obscura": 1, "bands": [{"name": "lwir", "um": [8, 12], "samples": 2}],
    "clouds": [{"grid": {"shape": "box", "size_m": [1, 1, 1], "voxel_m": 0.25},
                "media": [{"density": "density", "extinction": {"um": [8, 12], "value": [1, 5]}}]}],
    "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0]}})")
                          .world;
  REQUIRE(world.interval_count() == 2);
  CHECK(SpectralWorld(world, 0).at(Vec3d(0)).extinction == Approx(2));
  CHECK(SpectralWorld(world, 1).at(Vec3d(0)).extinction == Approx(4));
}

TEST_CASE("raw grids of one lattice share an octree, others get their own with the temperature sampled there",
          "[scene][world]") {
  const obscura::test::ScratchFolder folder;
  const auto write = [&](const char* name, const std::vector<float>& values) {
    std::ofstream(folder / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(4 * values.size()));
  };
  write("fine.f32", std::vector<float>(512, 1.0f));
  write("coarse.f32", std::vector<float>(64, 400.0f));
  std::ofstream(folder / "cloud.json") << R"([
    {"raw": "fine.f32", "type": "float32", "resolution": [8, 8, 8], "order": "x-fastest", "voxel_m": [1, 1, 1],
     "origin_m": [0, 0, 0], "grid": "smoke"},
    {"raw": "coarse.f32", "type": "float32", "resolution": [4, 4, 4], "order": "x-fastest", "voxel_m": [2, 2, 2],
     "origin_m": [0, 0, 0], "grid": "heat"}])";
  const BuiltWorld built = build(scene_with(R"({"grid": {"file": "cloud.json"},
      "media": [{"density": "smoke", "extinction": 1}], "temperature": {"grid": "heat"}})"),
                                 0, folder.path());
  REQUIRE(built.world.cloud_count() == 1);
  CHECK(built.world.clouds()[0].octree->channel_count() == 2);
  CHECK(SpectralWorld(built.world, 0).at(Vec3d(4)).emission ==
        Approx(built.world.bands()[0].planck(400)).epsilon(1e-3));

  CHECK_THROWS_WITH(build(scene_with(R"({"grid": {"file": "cloud.json"},
      "media": [{"density": "dust", "extinction": 1}]})"),
                          0, folder.path()),
                    Catch::Contains("dust"));
}

TEST_CASE("sky, sun, hot spheres and beams arrive in the World", "[scene][world]") {
  const World world = build(scene_with_box("", R"(,
    "environment": {"sky": {"K": 250}, "sun": {"zenith_deg": 90, "azimuth_deg": 90, "irradiance": 2}},
    "sources": [{"name": "flare", "position_m": [0, 0, 2], "radius_m": 0.1, "K": 2000}],
    "beams": [{"position_m": [0, 0, 5], "toward": [0, 0, -2], "power": 1}])"))
                          .world;
  CHECK(SpectralWorld(world, 0).sky() == Approx(world.bands()[0].planck(250)));
  REQUIRE(world.suns().size() == 1);
  CHECK(world.suns()[0].toward.x == Approx(1));
  CHECK(world.suns()[0].irradiance[0] == Approx(8));
  REQUIRE(world.spheres().size() == 1);
  CHECK(world.spheres()[0].radiance[0] == Approx(world.bands()[0].planck(2000)));
  REQUIRE(world.beams().size() == 1);
  CHECK(world.beams()[0].direction.z == -1);
  CHECK(world.beams()[0].power[0] == Approx(4));
}

TEST_CASE("objects, moon and air arrive in the World", "[scene][world]") {
  const World world = build(scene_with_box("", R"(,
    "objects": [{"name": "ball", "shape": "sphere", "radius_m": 2, "K": 300}, {"shape": "box", "size_m": [1, 1, 1]}],
    "environment": {"sun": {"toward": [1, 0, 0], "irradiance": 2}, "moon": {"toward": [0, 1, 0], "irradiance": 0.5},
                    "atmosphere": {"extinction_per_m": 0.01, "K": 280}})"))
                          .world;
  REQUIRE(world.suns().size() == 2);
  CHECK(world.suns()[0].irradiance[0] == Approx(8));
  CHECK(world.suns()[1].toward == Vec3d(0, 1, 0));
  CHECK(world.suns()[1].irradiance[0] == Approx(2));
  REQUIRE(world.atmosphere());
  CHECK(world.atmosphere()->extinction[0] == 0.01);
  CHECK(world.atmosphere()->radiance[0] == Approx(world.bands()[0].planck(280)));
  CHECK(world.bounds().max.z == Approx(2));
}

TEST_CASE("air has 288 K unless its temperature or radiance is given, and is none where it is clear",
          "[scene][world]") {
  const auto air = [](const std::string& keys, const std::string& bands) {
    std::string text = R"({"obscura": 1, "bands": [)";
    text += bands;
    text += R"(], "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0]}, "environment": {"atmosphere": {)";
    text += keys;
    text += "}}}";
    return build(text).world;
  };
  const std::string lwir = R"({"name": "lwir", "um": [8, 12]})", both = lwir + R"(, {"name": "grey"})";
  const World by_default = air(R"("extinction_per_m": 0.1)", both);
  const double warm = by_default.bands()[0].planck(288);
  CHECK(by_default.atmosphere()->radiance == std::vector<double>{warm, 0});
  CHECK(air(R"("extinction_per_m": 0.1, "radiance": 3)", both).atmosphere()->radiance == std::vector<double>{12, 3});
  CHECK(air(R"("extinction_per_m": 0.1, "radiance": 3, "K": 288)", both).atmosphere()->radiance ==
        std::vector<double>{warm, 3});
  CHECK_FALSE(air(R"("extinction_per_m": 0, "K": 300)", lwir).atmosphere());
}

TEST_CASE("a periodic cloud repeats after n dx where no period is given", "[scene][world]") {
  const World world = build(scene_with_box(R"(, "periodic": ["x"])")).world;
  CHECK(world.period()[0].x == Approx(2));
  CHECK(SpectralWorld(world, 0).at({1000.3, 0, 0}).extinction == Approx(0.5));
  CHECK(SpectralWorld(world, 0).at({0, 1000.3, 0}).extinction == 0);
}
