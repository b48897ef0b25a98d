// The keys of antialiasing: each asks for rays where what it names varies, and for none where its threshold allows it.
#include <algorithm>
#include <catch2/catch.hpp>

#include "scene/file/scene_io.h"
#include "scene/run/run.h"

using namespace obscura;

namespace {

struct Parts {
  std::string objects = "", clouds = "", environment = R"("sky": {"K": 250})", sensor = "";
};

RunResult run(const Parts& parts, const std::string& antialiasing, int most = 16) {
  std::string text = R"({"obscura": 1, "bands": [{"name": "lwir", "um": [8, 12]}], "materials": {
      "paint": {"emissivity": 0.9}, "cloth": {"emissivity": 0.9}, "rust": {"emissivity": 0.8},
      "mirror": {"emissivity": 0.05, "specular": 1}, "chalk": {"emissivity": 0.5}},
    "objects": [)";
  text += parts.objects + R"(], "clouds": [)" + parts.clouds + R"(], "environment": {)" + parts.environment;
  text +=
      R"(}, "sensor": {"position_m": [0, 0, 20], "look_at_m": [0, 0, 0], "up": [0, 1, 0], "projection": "orthographic",
      "width_m": 8, "resolution": [16, 16], "max_oversampling": )";
  text += std::to_string(most) + parts.sensor + R"(, "antialiasing": {)" + antialiasing +
          R"(}}, "render": {"photons": 2000}})";
  RunResult result = run_scene(parse_scene(text, "."), {});
  CHECK(!result.failure);
  return result;
}

std::uint64_t rays(const RunResult& result, const std::string& criterion) {
  for (const auto& [name, count] : result.report.rays) {
    if (name == criterion) return count;
  }
  FAIL("no criterion " << criterion);
  return 0;
}

std::string plane(const std::string& rest, double x = 0, double z = 0, double size = 4,
                  const std::string& rotate = "[0, 0, 0]") {
  std::string text = R"({"shape": "plane", "size_m": [)";
  text += std::to_string(size) + ", 20], " + rest + R"(, "place": {"translate_m": [)" + std::to_string(x) + ", 0, " +
          std::to_string(z) + R"(], "rotate_deg": )" + rotate + "}}";
  return text;
}

}  // namespace

TEST_CASE("each threshold of antialiasing asks for rays by itself", "[scene][run][antialiasing]") {
  const std::string paint = R"("material": "paint", "K": 300)";
  // A second plane beside the first, with its edge at x = 0.13, in no pixel's corner.
  const auto beside = [&](const std::string& second, double z = 0) {
    return plane(paint, -9.87, 0, 20) + "," + plane(second, 10.13, z, 20);
  };
  const std::string smoke =
      R"({"grid": {"shape": "box", "size_m": [3.3, 9, 1], "voxel_m": 0.1}, "place": {"translate_m": [0, 0, 5]},
      "media": [{"density": "density", "extinction": 1)";
  const std::string sun = R"("sky": {"K": 250}, "sun": {"toward": [1, 0, 1], "irradiance": 10})";
  const std::string chalk = R"("material": "chalk", "K": 300)";
  const std::string others = R"("polygons": 99, "materials": 99)";
  struct Case {
    Parts parts;
    std::string criterion;
    std::string asks, allows;  // thresholds
  };
  for (
      const Case& c : {
          Case{{beside(paint)}, "polygons", "", R"("polygons": 3)"},
          Case{{beside(R"("material": "cloth", "K": 300)")}, "materials", R"("polygons": 99)", others},
          Case{{plane(paint, -9.87, 0, 20) + "," + plane(paint, 10.13 * 0.995, 0.88, 20, "[0, -5, 0]")},
               "normal",
               others + R"(, "normal_deg": 4, "depth": 9)",
               others + R"(, "normal_deg": 6, "depth": 9)"},
          Case{{beside(paint, 2.0)}, "depth", others, others + R"(, "depth": 0.2)"},
          Case{{beside(R"("material": "paint", "K": 303)")}, "temperature", others, others + R"(, "temperature_K": 4)"},
          Case{{beside(R"("material": "rust", "K": 300)")}, "emissivity", others, others + R"(, "emissivity": 0.2)"},
          Case{
              {plane(chalk, 0, 0, 40) + "," +
                   R"({"shape": "box", "size_m": [1, 1, 1], "material": "chalk", "K": 300, "place": {"translate_m": [9, 0, 5]}})",
               "", sun},
              "shadow",
              others + R"(, "radiance": 99)",
              others + R"(, "radiance": 99, "shadow": 1)"},
          Case{{"", smoke + "}]}"}, "transmission", R"("radiance": 99)", R"("radiance": 99, "transmission": 1)"},
          Case{{"", smoke + R"(}], "temperature": {"K": 320}})"},
               "radiance",
               R"("transmission": 1)",
               R"("transmission": 1, "radiance": 99)"},
          Case{
              {plane(R"("material": "mirror", "K": 300)", 0, 0, 40) + "," +
               R"({"shape": "box", "size_m": [1, 1, 1], "material": "paint", "K": 400, "place": {"translate_m": [0, 0, 30]}})"},
              "reflection",
              "",
              R"("polygons": 99, "materials": 99, "normal_deg": 360, "depth": 99, "temperature_K": 999, "emissivity": 9, "radiance": 99)"},
      }) {
    INFO(c.criterion);
    const RunResult asked = run(c.parts, c.asks), allowed = run(c.parts, c.allows);
    CHECK(rays(asked, c.criterion) > 0);
    CHECK(rays(allowed, c.criterion) == 0);
    const auto all = asked.image.channel("rays.N");
    // A slope's depth varies half as much in a quarter, whose threshold is higher.
    CHECK(*std::max_element(all.begin(), all.end()) >= (std::string(c.criterion) == "depth" ? 4 : 10));
    CHECK(*std::min_element(all.begin(), all.end()) == 1);
    // The report accounts for every ray that was averaged.
    double averaged = 0, reported = 0;
    for (const float n : all) averaged += n;
    for (const auto& [name, count] : asked.report.rays)
      reported += name == "deciding" ? 0.0 : static_cast<double>(count);
    CHECK(averaged == reported);
    CHECK(rays(asked, "base") == 256);
    CHECK(rays(asked, "deciding") >= 17 * 17);
  }
}

TEST_CASE("a threshold of 0 polygons gives every pixel as many rays, and an error goes on until it is met",
          "[scene][run][antialiasing]") {
  const Parts smoke{
      "",
      R"({"grid": {"shape": "box", "size_m": [40, 40, 1], "voxel_m": 1}, "media": [{"density": "density", "extinction": 1, "albedo": 0.8}]})"};
  const RunResult everywhere = run(smoke, R"("polygons": 0)", 9);
  for (const float n : everywhere.image.channel("rays.N")) CHECK(n == 9);
  CHECK(rays(everywhere, "deciding") == 0);
  CHECK_FALSE(everywhere.image.has("rays.criterion"));

  const RunResult few = run(smoke, R"("radiance": 99, "error": 0.5)"),
                  many = run(smoke, R"("radiance": 99, "error": 0.001)");
  CHECK(rays(few, "error") == 256);  // the second half
  CHECK(rays(many, "error") > 4 * 256);
}
