#include "scene/file/scene_io.h"

#include <catch2/catch.hpp>
#include <functional>

#include "octree/base/error.h"
#include "tests/scene/file/scene_mistakes.h"
#include "tests/scene/full_scene.h"

using namespace obscura;
using obscura::test::full_scene;
using obscura::test::has;
using obscura::test::Json;
using obscura::test::kSmallest;
using obscura::test::other_scene;
using obscura::test::problems_of;
using obscura::test::SceneFolder;
using obscura::test::text_of;

TEST_CASE("the smallest scene holds the defaults", "[scene][reader]") {
  const Description scene = parse_scene(kSmallest, ".");
  CHECK(scene.bands.size() == 1);
  CHECK(scene.bands[0].samples == 1);
  CHECK(scene.bands[0].response == Spectrum::constant(1));
  CHECK(scene.clouds.empty());
  CHECK_FALSE(scene.sky);
  CHECK_FALSE(scene.sun);
  CHECK(scene.sensor.up == Vec3d(0, 0, 1));
  CHECK(scene.sensor.projection == Projection::perspective);
  CHECK(scene.sensor.fov_deg == 20);
  CHECK(scene.sensor.resolution == std::array<int, 2>{320, 240});
  CHECK(scene.sensor.max_oversampling == 16);
  CHECK_FALSE(scene.sensor.scattering_depth);
  CHECK(scene.sensor.specular_depth == 4);
  CHECK(scene.objects.empty());
  CHECK(scene.materials.empty());
  CHECK_FALSE(scene.moon);
  CHECK_FALSE(scene.atmosphere);
  CHECK_FALSE(scene.sensor.detector.on());
  CHECK(scene.sensor.detector.nedt_at_K == 300);
  CHECK(scene.sensor.detector.range == std::array<double, 2>{0, 1});
  CHECK(scene.render.photons == 1000000);
  CHECK(scene.render.nearest == 64);
  CHECK(scene.render.kernel == Kernel::epanechnikov);
  CHECK(scene.render.photon_power_min == 0);
  CHECK(scene.render.directions == Directions::stratified);
  CHECK_FALSE(scene.render.final_gather);
  CHECK(scene.render.samples == 64);
  CHECK(scene.render.octree_tolerance == 0.001);
  CHECK(scene.render.seed == 1);
  CHECK(scene.warnings.empty());
}

TEST_CASE("what a scene says arrives in the description", "[scene][reader]") {
  const SceneFolder folder("io_values");
  const Description scene = parse_scene(full_scene().dump(), folder.path());
  REQUIRE(scene.clouds.size() == 5);
  const CloudDescription& smoke = scene.clouds[0];
  CHECK(smoke.grid->file == folder.path() / "smoke.vdb");
  CHECK(smoke.media[0].extinction == Spectrum::constant(0.2));
  CHECK(smoke.media[0].albedo.value(10) == Approx(0.15));
  CHECK(smoke.media[0].phase.mean_cosine() == Approx(0.7));
  CHECK(smoke.media[1].density == "density");
  CHECK(smoke.media[3].phase.mean_cosine() == Approx(0.9 * 0.8 - 0.1 * 0.3));
  CHECK(smoke.temperature->grid == "temperature");
  CHECK(smoke.place.rotate_deg == Vec3d(0, 0, 90));
  CHECK(smoke.place.scale == 2);
  CHECK(smoke.periodic == std::array<bool, 2>{true, true});
  CHECK(smoke.period_m == std::array<double, 2>{640, 740});
  CHECK(scene.clouds[1].puffs->sources[0].mass_g == 300);
  CHECK(scene.clouds[1].puffs->wind_m_s == Vec3d(2, 0, 0));
  CHECK(scene.clouds[1].temperature->K == 320);
  CHECK(scene.clouds[1].name == "cloud2");
  CHECK(scene.clouds[2].grid->kind == GridKind::sphere);
  CHECK(scene.clouds[4].grid->sigma_m == 0.5);
  CHECK(scene.hot_spheres[0].K == 2000.0);
  CHECK(scene.hot_spheres[1].radiance == Spectrum::constant(5));
  REQUIRE(scene.particles.size() == 2);
  CHECK(scene.particles[1].s == 1);
  CHECK(scene.particles[1].K == 800);
  CHECK(scene.sun->toward == Vec3d(0, 0, 1));
  CHECK(scene.flux[0].size_m == std::array<double, 2>{2, 2});
  CHECK(scene.beams[0].power == Spectrum::constant(1));

  REQUIRE(scene.objects.size() == 4);
  const ObjectDescription& truck = scene.objects[0];
  CHECK(truck.kind == SurfaceKind::mesh);
  CHECK(truck.mesh == folder.path() / "truck.obj");
  CHECK(truck.temperature == folder.path() / "K.csv");
  CHECK(truck.material == "paint");
  CHECK(truck.K == 310.0);
  CHECK_FALSE(truck.double_sided);
  CHECK(truck.place.translate_m == Vec3d(1, 2, 3));
  CHECK(truck.groups.at("wheel").material == "rubber");
  CHECK(truck.groups.at("wheel").K == 320.0);
  CHECK(scene.objects[1].name == "object2");
  CHECK(scene.objects[1].kind == SurfaceKind::plane);
  CHECK(scene.objects[1].plane_m == std::array<double, 2>{100, 50});
  CHECK(scene.objects[1].double_sided);
  CHECK_FALSE(scene.objects[1].K);
  CHECK(scene.objects[2].kind == SurfaceKind::box);
  CHECK(scene.objects[2].box_m == Vec3d(1, 2, 3));
  CHECK(scene.objects[2].radiance == Spectrum::constant(2));
  CHECK(scene.objects[3].kind == SurfaceKind::sphere);
  CHECK(scene.objects[3].radius_m == 0.5);
  const MaterialDescription& paint = scene.materials.at("paint");
  CHECK(paint.emissivity == Spectrum::constant(0.9));
  CHECK(paint.specular == 0.2);
  CHECK(paint.roughness == 0.1);
  CHECK(paint.permeable == 0.25);
  CHECK(paint.angle_deg == std::vector<double>{0, 90});
  CHECK(paint.angle_factor == std::vector<double>{1, 0.5});
  CHECK(scene.materials.at("rubber").emissivity == Spectrum::constant(1));
  CHECK(scene.moon->toward.x == Approx(0.866025));
  CHECK(scene.moon->irradiance == Spectrum::constant(0.25));
  CHECK(scene.atmosphere->extinction_per_m == Spectrum::constant(1e-4));
  CHECK(scene.atmosphere->K == 280.0);

  const Description other = parse_scene(other_scene().dump(), folder.path());
  CHECK(other.bands[0].name == "band1");
  CHECK(other.sky->K == 250.0);
  CHECK(other.atmosphere->radiance == Spectrum::constant(2));
  CHECK_FALSE(other.atmosphere->K);
  CHECK(other.sun->diameter_deg == 0.533);
  // scene/FORMAT.md: (sin z sin a, sin z cos a, cos z) at z = 30, a = 135 degrees.
  CHECK((other.sun->toward - Vec3d(0.353553, -0.353553, 0.866025)).length() < 1e-6);
  const DetectorSettings& detector = scene.sensor.detector;
  CHECK(detector.psf.columns == 3);
  CHECK(detector.psf.weights[4] == Approx(60.0 / 110));
  CHECK(detector.nedt_K == 0.05);
  CHECK(detector.nedt_at_K == 290);
  CHECK(detector.integration_s == 0.01);
  CHECK(detector.reference_integration_s == 0.02);
  CHECK(detector.dead_share == 0.001);
  CHECK(detector.gain_nonuniformity == 0.01);
  CHECK(detector.offset_nonuniformity == 0.02);
  CHECK(detector.gain == 2);
  CHECK(detector.offset == -1);
  CHECK(detector.bits == 14);
  CHECK(detector.range == std::array<double, 2>{0, 50});
  CHECK(detector.seed == 3u);
  CHECK(detector.of_band("lwir").range == std::array<double, 2>{0, 60});
  CHECK(detector.of_band("mwir").range == std::array<double, 2>{0, 50});
  CHECK(other.sensor.scattering_depth == 3);
  CHECK(other.sensor.width_m == 5);
  CHECK(other.render.kernel == Kernel::cone);
  CHECK(other.render.seed == 7);
}

TEST_CASE("null is the default everywhere", "[scene][reader]") {
  const SceneFolder folder("io_null");
  std::function<void(const Json&, const Json::json_pointer&, std::vector<Json::json_pointer>&)> collect =
      [&](const Json& value, const Json::json_pointer& at, std::vector<Json::json_pointer>& pointers) {
        if (!value.is_object()) return;
        for (const auto& [key, member] : value.items()) {
          pointers.push_back(at / key);
          collect(member, at / key, pointers);
        }
      };
  for (const char* part : {"/sensor", "/render", "/environment/sun"}) {
    Json scene = full_scene();
    std::vector<Json::json_pointer> pointers;
    collect(scene[Json::json_pointer(part)], Json::json_pointer(part), pointers);
    for (const auto& pointer : pointers) {
      Json changed = scene;
      changed[pointer] = nullptr;
      const auto problems = problems_of(changed.dump(), folder.path());
      const std::string name = pointer.to_string();
      INFO(name << text_of(problems));
      const bool required = name == "/sensor/position_m" || name == "/sensor/look_at_m" ||
                            name == "/environment/sun/toward" ||
                            name.ends_with("integration_s");  // the reference goes with the time, and back
      CHECK(problems.size() == (required ? 1 : 0));
    }
  }
  CHECK(parse_scene(R"({"obscura": 1, "bands": [{"um": [8, 12], "samples": null}], "clouds": null, "render": null,
                        "sensor": {"position_m": [0, -10, 1], "look_at_m": [0, 0, 1], "fov_deg": null}})",
                    ".")
            .sensor.fov_deg == 20);
}

TEST_CASE("comments are white space and whole numbers may be written with an exponent", "[scene][reader]") {
  const Description scene = parse_scene(R"({ // one
    "obscura": 1, /* two */ "bands": [{"name": "g"}], "render": {"photons": 1e5, "nearest": 32.0},
    "sensor": {"position_m": [0, -10, 1], "look_at_m": [0, 0, 1]}})",
                                        ".");
  CHECK(scene.render.photons == 100000);
  CHECK(scene.render.nearest == 32);
  CHECK(scene.bands[0].grey());
}

TEST_CASE("warnings tell what a scene leaves out", "[scene][reader][warnings]") {
  const auto warnings = [](const char* band, const char* cloud) {
    return parse_scene(std::string(R"({"obscura": 1, "bands": [)") + band +
                           R"(], "clouds": [{"grid": {"shape": "sphere", "radius_m": 1, "voxel_m": 0.1},)" + cloud +
                           R"(}], "sensor": {"position_m": [0, -10, 1], "look_at_m": [0, 0, 1]}})",
                       ".")
        .warnings;
  };
  const char* const plain = R"("media": [{"extinction": 1}])";
  const auto cold = warnings(R"({"name": "lwir", "um": [8, 12]})", plain);
  REQUIRE(cold.size() == 1);
  CHECK(has(cold[0], "does not emit in band \"lwir\""));
  CHECK(warnings(R"({"name": "vis", "um": [0.4, 0.7]})", plain).empty());
  CHECK(warnings(R"({"name": "grey"})", plain).empty());
  CHECK(warnings(R"({"um": [8, 12]})", R"("media": [{"extinction": 1}], "temperature": {"K": 300})").empty());
  CHECK(warnings(R"({"um": [8, 12]})", R"("media": [{"extinction": 1}], "source": 2)").empty());
  const auto unnormalised =
      warnings(R"({"name": "vis", "um": [0.4, 0.7]})",
               R"("media": [{"extinction": 1, "phase": {"type": "table", "angle_deg": [0, 180], "value": [1, 1]}}])");
  REQUIRE(unnormalised.size() == 1);
  CHECK(has(unnormalised[0], "12.57"));  // 4 pi
  CHECK(parse_scene(
            kSmallest, ".",
            {{"/render/method", "\"photon\"", ""}, {"/render/samples", "8", ""}, {"/render/final_gather", "0", ""}})
            .warnings.size() == 1);
  CHECK(parse_scene(kSmallest, ".", {{"/render/samples", "8", ""}}).warnings.empty());
}

TEST_CASE("an edit changes the scene before it is read", "[scene][reader][set]") {
  const Description scene = parse_scene(kSmallest, ".",
                                        {{"/render/photons", "1e4", "--photons"},
                                         {"/bands/0/um", "[3, 5]", "--set"},
                                         {"/bands/1", R"({"name": "b"})", "--set"},
                                         {"/environment/sun/toward", "[0, 1, 0]", "--set"},
                                         {"/environment/sun/irradiance", "5", "--set"},
                                         {"/sensor/projection", "fisheye", "--set"}});
  CHECK(scene.render.photons == 10000);
  CHECK(scene.bands[0].um == std::array<double, 2>{3, 5});
  CHECK(scene.bands[1].name == "b");
  CHECK(scene.sun->toward == Vec3d(0, 1, 0));
  CHECK(scene.sensor.projection == Projection::fisheye);
  try {
    parse_scene(kSmallest, ".",
                {{"/render/photons", "x", "--photons"},
                 {"photons", "1", "--set"},
                 {"/bands/7/um", "1", "--set"},
                 {"/obscura/a", "1", "--set"}});
    FAIL("accepted");
  } catch (const InputError& error) {
    INFO(error.what());
    CHECK(error.problems().size() == 4);
    CHECK(has(error.what(), "from --photons"));
    CHECK(has(error.what(), "no element of a list of 1"));
    CHECK(has(error.what(), "nothing below /obscura"));
  }
}

TEST_CASE("the hash belongs to the values, not to how they are written", "[scene][reader][hash]") {
  const std::string hash = parse_scene(kSmallest, ".").hash;
  CHECK(hash.size() == 16);
  CHECK(parse_scene(R"(/* the same */ {"sensor": {"look_at_m": [0,0,1.0], "position_m": [0,-1e1,1]},
                      "obscura": 1, "bands": [{"um": [8, 12], "name": "lwir"}]})",
                    ".")
            .hash == hash);
  CHECK(parse_scene(kSmallest, ".", {{"/bands/0/um", "[8, 12.5]", ""}}).hash != hash);
}
