// Keys of surfaces, one at a time, and what each changes in the picture.
#include <catch2/catch.hpp>

#include "photon/optics/band.h"
#include "scene/file/scene_io.h"
#include "scene/run/run.h"
#include "tests/support/scratch_folder.h"

using namespace obscura;

namespace {

/// Looks down at z = 0 from 10 m, straight and in parallel; `keys` are the scene's other keys.
Image picture(const std::string& keys, const std::string& sensor = "", const std::filesystem::path& folder = ".") {
  std::string text = R"({"obscura": 1, "bands": [{"name": "lwir", "um": [8, 12]}],
    "sensor": {"position_m": [0, 0, 10], "look_at_m": [0, 0, 0], "up": [0, 1, 0], "projection": "orthographic", "width_m": 2,
               "resolution": [8, 8], "max_oversampling": 64)";
  text += sensor;
  text += R"(}, "render": {"photons": 2000, "nearest": 16}, )";
  text += keys;
  text += "}";
  const RunResult result = run_scene(parse_scene(text, folder), {});
  CHECK_FALSE(result.failure);
  return result.image;
}

double mean(const Image& image, const std::string& channel) {
  double sum = 0;
  const auto values = image.channel(channel);
  for (const float value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Radiance of a plane of 20 m with these keys, over nothing but a cold sky.
double plane(const std::string& object, const std::string& material, const std::string& rest = "",
             const std::string& sensor = "") {
  std::string text = R"("objects": [{"shape": "plane", "size_m": [20, 20], "material": "m")";
  text += object;
  text += R"(}], "materials": {"m": {)";
  text += material;
  text += "}}";
  text += rest;
  return mean(picture(text, sensor), "lwir.radiance");
}

double planck(double K) { return Band("lwir", 8, 12, 1, Spectrum::constant(1)).planck(0, K); }

}  // namespace

TEST_CASE("K, emissivity, its angle and double_sided change what a plane emits", "[scene][run][surfaces]") {
  CHECK(plane(R"(, "K": 300)", "") == Approx(planck(300)).epsilon(1e-6));
  CHECK(plane(R"(, "K": 310)", "") == Approx(planck(310)).epsilon(1e-6));
  CHECK(plane("", "") == 0);
  CHECK(plane(R"(, "K": 300)", R"("emissivity": 0.6)") == Approx(0.6 * planck(300)).epsilon(1e-6));
  CHECK(plane(R"(, "K": 300)",
              R"("emissivity": 0.6, "emissivity_by_angle": {"angle_deg": [0, 90], "factor": [0.5, 1]})") ==
        Approx(0.3 * planck(300)).epsilon(1e-6));
  CHECK(plane(R"(, "radiance": 2)", R"("emissivity": 0.5)") == Approx(4).epsilon(1e-6));  // per um over 4 um
  // Turned over, its back looks up.
  CHECK(plane(R"(, "K": 300, "place": {"rotate_deg": [180, 0, 0]})", "") == 0);
  CHECK(plane(R"(, "K": 300, "double_sided": true, "place": {"rotate_deg": [180, 0, 0]})", "") ==
        Approx(planck(300)).epsilon(1e-6));
}

TEST_CASE("specular, specular_depth and permeable change what a plane shows", "[scene][run][surfaces]") {
  const std::string sky = R"(, "environment": {"sky": {"K": 280}})";
  CHECK(plane("", R"("emissivity": 0.25, "specular": 1)", sky) == Approx(0.75 * planck(280)).epsilon(1e-6));
  // Sky behind a net whose threads are warm; each of 4096 rays meets the one or the other.
  const double net_error = std::sqrt(0.25 * 0.75 / 4096) * (planck(300) - planck(280));
  CHECK(plane(R"(, "K": 300)", R"("permeable": 0.25)", sky) ==
        Approx(0.75 * planck(300) + 0.25 * planck(280)).margin(4.9 * net_error).epsilon(0));

  // A mirror shows the warm lid above the sensor; where no mirror is followed the plane is like chalk, lit by all of
  // the sky as well.
  const std::string lid = R"("objects": [{"shape": "plane", "size_m": [20, 20], "material": "m"},
      {"shape": "plane", "size_m": [4, 4], "K": 400, "place": {"translate_m": [0, 0, 20], "rotate_deg": [180, 0, 0]}}],
      "materials": {"m": {"emissivity": 0, "specular": 1}})";
  CHECK(mean(picture(lid), "lwir.radiance") == Approx(planck(400)).epsilon(1e-6));
  CHECK(mean(picture(lid, R"(, "specular_depth": 0)"), "lwir.radiance") < 0.1 * planck(400));

  // Rough, it mixes the lid with the dark beside it.
  std::string rough = lid;
  rough.replace(rough.find(R"("specular": 1)"), 13, R"("specular": 1, "roughness": 0.3)");
  const double seen = mean(picture(rough), "lwir.radiance");
  CHECK(seen < 0.7 * planck(400));
  CHECK(seen > 0);
}

TEST_CASE("a moon lights a plane as a sun does, and air dims and glows", "[scene][run][surfaces]") {
  // Lambert: E (1 - e) cos z / pi.
  const std::string moon = R"(, "environment": {"moon": {"zenith_deg": 60, "irradiance": 2}})";
  CHECK(plane("", R"("emissivity": 0)", moon) == Approx(8 * 0.5 / kPi).epsilon(1e-3));
  const std::string air = R"(, "environment": {"atmosphere": {"extinction_per_m": 0.05, "K": 260}})";
  const double t = std::exp(-0.5);  // over 10 m
  CHECK(plane(R"(, "K": 300)", "", air) == Approx(t * planck(300) + (1 - t) * planck(260)).epsilon(1e-6));
}

TEST_CASE("depth and number of the object that is seen arrive in the picture", "[scene][run][surfaces]") {
  const Image image = picture(R"("objects": [{"shape": "plane", "size_m": [20, 20]},
    {"shape": "box", "size_m": [4, 4, 2], "place": {"translate_m": [0, 0, 1], "scale": 2}}])");
  CHECK(mean(image, "depth.Z") == Approx(7).epsilon(1e-6));
  CHECK(mean(image, "object.id") == 2);
}

TEST_CASE("groups and tables of temperature show in the picture", "[scene][run][surfaces]") {
  const test::ScratchFolder folder;
  // Left half and right half of what the sensor sees.
  folder.write("halves.obj",
               "v -1 -1 0\nv 0 -1 0\nv 0 1 0\nv -1 1 0\nv 1 -1 0\nv 1 1 0\ng left\nf 1 2 3 4\ng right\nf 2 5 6 3\n");
  folder.write("K.csv", "face,K\n1,330\n");
  const auto halves = [&](const std::string& keys) {
    const Image image = picture(R"("objects": [{"mesh": "halves.obj", "K": 300)" + keys + "}]", "", folder / "");
    const auto values = image.channel("lwir.temperature");
    return std::pair<float, float>{values[0], values[7]};
  };
  CHECK(halves("").first == Approx(300).epsilon(1e-5));
  CHECK(halves(R"(, "groups": {"left": {"K": 320}})").first == Approx(320).epsilon(1e-5));
  CHECK(halves(R"(, "groups": {"left": {"K": 320}})").second == Approx(300).epsilon(1e-5));
  CHECK(halves(R"(, "temperature": {"file": "K.csv"})").first == Approx(300).epsilon(1e-5));
  CHECK(halves(R"(, "temperature": {"file": "K.csv"})").second == Approx(330).epsilon(1e-5));
}
