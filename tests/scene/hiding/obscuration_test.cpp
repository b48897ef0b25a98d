// Small scenes whose obscuration is known on paper: a warm box before a cool wall behind a cloud.
#include "scene/hiding/obscuration.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "octree/base/error.h"
#include "photon/optics/band.h"
#include "scene/file/scene_io.h"

using namespace obscura;

namespace {

constexpr double kBox = 310, kWall = 285, kCloud = 295, kDepth = 1.5;

/// An orthographic sensor looks through a slab that every line of sight crosses straight.
std::string scene_text(const std::string& medium, const std::string& more = "") {
  return R"({"obscura": 1,
    "bands": [{"name": "lwir", "um": [8, 12]}],
    "clouds": [{"name": "slab", "grid": {"shape": "box", "size_m": [24, 1, 24], "voxel_m": 1}, "media": [)" +
         medium + R"(],
                "temperature": {"K": 295}, "place": {"translate_m": [0, -5, 0]}}],
    "objects": [{"name": "wall", "shape": "box", "size_m": [60, 1, 60], "K": 285, "place": {"translate_m": [0, 5, 0]}},
                {"name": "box", "shape": "box", "size_m": [2, 1, 2], "K": 310}],
    "sensor": {"position_m": [0, -20, 0], "look_at_m": [0, 0, 0], "projection": "orthographic", "width_m": 9.7,
               "resolution": [24, 24], "max_oversampling": 16},
    "render": {"photons": 30000, "octree_tolerance": 0})" +
         more + "}";
}

Obscuration find(const std::string& text, ObscurationWish wish = {}) {
  wish.replicas = 4;
  return find_obscuration(parse_scene(text, "."), wish);
}

const BandObscuration& first(const Obscuration& obscuration) {
  REQUIRE_FALSE(obscuration.objects.empty());
  return obscuration.objects.front().bands.front();
}

void check_absorption(const BandObscuration& found, double depth) {
  const Band band("lwir", 8, 12);
  const double T = std::exp(-depth), glow = (1 - T) * band.planck(kCloud);
  const double object = T * band.planck(kBox) + glow, wall = T * band.planck(kWall) + glow;
  CHECK(found.transmission->value == Approx(T).epsilon(1e-4));
  CHECK(found.without.difference->value == Approx(band.planck(kBox) - band.planck(kWall)).epsilon(1e-4));
  CHECK(found.without.difference_K->value == Approx(kBox - kWall).epsilon(1e-4));
  CHECK(found.difference_ratio->value == Approx(T).epsilon(1e-4));
  CHECK(found.relative_ratio->value == Approx(T * band.planck(kWall) / wall).epsilon(1e-4));
  CHECK(found.with.difference_K->value ==
        Approx(band.brightness_temperature(object) - band.brightness_temperature(wall)).epsilon(1e-4));
}

std::vector<Problem> problems_of(const std::string& text, const ObscurationWish& wish = {}) {
  try {
    find_obscuration(parse_scene(text, "."), wish);
  } catch (const InputError& error) {
    return error.problems();
  }
  return {};
}

}  // namespace

TEST_CASE("behind a cloud that absorbs and glows contrast falls by exp(-depth)", "[scene][obscuration]") {
  const Obscuration found = find(scene_text(R"({"extinction": 1.5})"));
  REQUIRE(found.objects.size() == 1);
  CHECK(found.objects[0].name == "box");
  CHECK(found.left_out.size() == 1);
  // 2 m of 9.7 m in 24 pixels: edges fall into pixels, and mixed ones do not dilute the contrast.
  CHECK(found.objects[0].mask.area() == Approx(std::pow(2 / 9.7 * 24, 2)).epsilon(0.05));
  CHECK(found.objects[0].mask.interior() < found.objects[0].mask.area());
  check_absorption(first(found), kDepth);
  CHECK(first(found).obscured->value == 0);
  // Its twin: the check sees an optical depth that is 1 % off.
  const Obscuration wrong = find(scene_text(R"({"extinction": 1.515})"));
  CHECK(std::abs(first(wrong).difference_ratio->value - std::exp(-kDepth)) > 100 * 1e-4 * std::exp(-kDepth));
}

TEST_CASE("where the cloud scatters, contrast falls by less than exp(-depth) and more than by absorption alone",
          "[scene][obscuration]") {
  // The box's light that is scattered forward arrives from near its place: part of what its lines of sight have lost.
  const std::string text =
      scene_text(R"({"extinction": 1.5, "albedo": 0.6, "phase": {"type": "henyey_greenstein", "g": 0.85}})");
  ObscurationWish wish;
  wish.replicas = 4;
  const auto by = [&](const char* method) {
    return first(
        find_obscuration(parse_scene(text, ".", {{"/render/method", method}, {"/render/photons", "100000"}}), wish));
  };
  const BandObscuration paths = by("path"), photons = by("photon");
  CHECK(paths.transmission->value == Approx(std::exp(-kDepth)).epsilon(1e-4));
  REQUIRE(paths.difference_ratio.has_value());
  REQUIRE(photons.difference_ratio.has_value());
  CHECK(paths.difference_ratio->low > std::exp(-kDepth));
  CHECK(paths.difference_ratio->high < std::exp(-kDepth * (1 - 0.6)));
  CHECK(photons.difference_ratio->low < paths.difference_ratio->high);
  CHECK(photons.difference_ratio->high > paths.difference_ratio->low);
}

TEST_CASE("a cloud before half of the object obscures half of it", "[scene][obscuration]") {
  std::string text = scene_text(R"({"extinction": 6})");
  text.replace(text.find("[0, -5, 0]"), 10, "[12, -5, 0]");
  ObscurationWish wish;
  wish.objects = {"box"};
  wish.thresholds.transmission = 0.01;
  const BandObscuration found = first(find(text, wish));
  CHECK(found.obscured->value == Approx(0.5).margin(0.02));
  CHECK(found.obscured->low <= 0.5);
  CHECK(found.obscured->high >= 0.5);
  CHECK(found.transmission->value == Approx(0.5 * (1 + std::exp(-6.0))).margin(0.02));
  CHECK(found.transmission_min == Approx(std::exp(-6.0)).epsilon(1e-3));
  CHECK(found.transmission_max == 1);
}

TEST_CASE("what is asked for and is not there is told", "[scene][obscuration]") {
  const std::string text = scene_text(R"({"extinction": 1})");
  ObscurationWish wish;
  wish.objects = {"bocks"};
  std::vector<Problem> problems = problems_of(text, wish);
  REQUIRE(problems.size() == 1);
  CHECK(problems[0].where == "--object bocks");
  CHECK(problems[0].hint.find("wall, box") != std::string::npos);

  wish.objects = {"wall"};
  problems = problems_of(text, wish);
  CHECK(problems.empty());

  std::string away = text;
  away.replace(away.find(R"("K": 310)"), 8, R"("K": 310, "place": {"translate_m": [0, -60, 0]})");
  wish.objects = {"box"};
  problems = problems_of(away, wish);
  REQUIRE(problems.size() == 1);
  CHECK(problems[0].problem.find("not in view") != std::string::npos);
  CHECK(problems[0].hint.find("wall") != std::string::npos);

  std::string clear = text;
  clear.replace(clear.find("\"clouds\""), clear.find("\"objects\"") - clear.find("\"clouds\""), "");
  problems = problems_of(clear);
  REQUIRE(problems.size() == 1);
  CHECK(problems[0].where == "clouds");
}

TEST_CASE("what surfaces reflect is gathered in both looks unless the scene forbids it, and then it is told",
          "[scene][obscuration]") {
  std::string text = scene_text(R"({"extinction": 0.2, "albedo": 0.5})");
  text.replace(text.find(R"("K": 310)"), 8, R"("K": 310, "material": "paint")");
  text.replace(text.find(R"("sensor")"), 8,
               R"("materials": {"paint": {"emissivity": 0.5}}, "environment": {"sky": {"K": 270}}, "sensor")");
  ObscurationWish wish;
  wish.replicas = 2;
  const auto by = [&](const char* gather) {
    return find_obscuration(
        parse_scene(text, ".",
                    {{"/render/method", "\"photon\""}, {"/render/final_gather", gather}, {"/render/photons", "5000"}}),
        wish);
  };
  const Obscuration open = by("null"), on = by("1"), off = by("0");
  CHECK(first(open).without.object->value == first(on).without.object->value);
  CHECK(first(open).with.object->value == first(on).with.object->value);
  CHECK(first(open).with.object->value != first(off).with.object->value);
  const auto told = [](const Obscuration& o) {
    return std::ranges::any_of(o.warnings,
                               [](const std::string& w) { return w.find("nothing is gathered") != std::string::npos; });
  };
  CHECK_FALSE(told(open));
  CHECK(told(off));
}

TEST_CASE("the texts hold every number, and the page holds its pictures", "[scene][obscuration]") {
  ObscurationWish wish;
  wish.pictures = true;
  wish.thresholds.difference_K = 2;
  const Obscuration found = find(scene_text(R"({"extinction": 1.5})"), wish);
  const auto json = nlohmann::json::parse(obscuration_json(found));
  const auto& band = json["objects"][0]["bands"]["lwir"];
  CHECK(band["difference_ratio"]["value"].get<double>() == first(found).difference_ratio->value);
  CHECK(band["with"]["share_below_nedt"]["value"] == 0);
  CHECK(json["replicas"] == 4);
  const std::string csv = obscuration_csv(found);
  CHECK(csv.find("box,lwir,difference of apparent temperature,K,with,") != std::string::npos);
  CHECK(csv.find("box,lwir,difference of apparent temperature,,ratio,") != std::string::npos);
  const std::string table = obscuration_table(found);
  CHECK(table.find("share with less than 2 K of difference") != std::string::npos);
  CHECK(table.find("left out: wall") != std::string::npos);
  REQUIRE(found.with.has_value());
  REQUIRE(found.without.has_value());
}

TEST_CASE("the numbers do not depend on the number of threads", "[scene][obscuration]") {
  const std::string text = scene_text(R"({"extinction": 1.5, "albedo": 0.5})");
  const std::string all = obscuration_json(find(text));
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  CHECK(obscuration_json(find(text)) == all);
}
