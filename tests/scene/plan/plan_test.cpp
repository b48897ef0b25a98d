// What the plan says of surfaces, light and air, and which settings it hands on.
#include <algorithm>
#include <catch2/catch.hpp>

#include "scene/file/scene_io.h"
#include "scene/run/run.h"
#include "scene/session/session.h"

using namespace obscura;

namespace {

Plan plan_of(const std::string& rest) {
  std::string text = R"({"obscura": 1, "bands": [{"name": "lwir", "um": [8, 12]}],)";
  text += R"("sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "specular_depth": 2})";
  if (!rest.empty()) text += ", " + rest;
  text += "}";
  const Description scene = parse_scene(text, ".");
  return Session(scene, 0).plan();
}

PlanRow row_of(const Plan& plan, const std::string& effect) {
  const auto row =
      std::find_if(plan.effects.begin(), plan.effects.end(), [&](const PlanRow& r) { return r.effect == effect; });
  REQUIRE(row != plan.effects.end());
  CHECK_FALSE(row->reason.empty());
  return *row;
}

const std::string kBall =
    R"("environment": {"sky": {"K": 260}}, "objects": [{"shape": "sphere", "radius_m": 1, "material": "m"}], "materials": {"m": )";

}  // namespace

TEST_CASE("an empty scene has no surfaces, mirrors, air, sun or masks", "[scene][plan]") {
  const Plan plan = plan_of("");
  for (const char* effect : {"surfaces", "specular", "sun", "atmosphere", "masking"})
    CHECK_FALSE(row_of(plan, effect).on);
  CHECK(plan.method.specular_depth == 2);
}

TEST_CASE("objects put surfaces and masking on", "[scene][plan]") {
  const Plan plan = plan_of(R"("objects": [{"shape": "sphere", "radius_m": 1}])");
  CHECK(row_of(plan, "surfaces").on);
  CHECK(row_of(plan, "masking").on);
  CHECK_FALSE(row_of(plan, "specular").on);
  CHECK(row_of(plan, "masking").reason == "objects hide what is behind them");
  CHECK(row_of(plan_of(R"("sources": [{"position_m": [0, 0, 0], "radius_m": 1, "K": 900}])"), "masking").reason ==
        "hot spheres hide what is behind them");
}

TEST_CASE("specular is on where something mirrors", "[scene][plan]") {
  CHECK(row_of(plan_of(kBall + R"({"emissivity": 0.5, "specular": 0.5}})"), "specular").on);
  CHECK_FALSE(row_of(plan_of(kBall + R"({"emissivity": 0.5}})"), "specular").on);
  // Black reflects nothing, unless its emissivity falls with the angle.
  CHECK_FALSE(row_of(plan_of(kBall + R"({"emissivity": 1, "specular": 0.5}})"), "specular").on);
  CHECK(
      row_of(plan_of(kBall + R"({"specular": 0.5, "emissivity_by_angle": {"angle_deg": [0, 90], "factor": [1, 0]}}})"),
             "specular")
          .on);
  // A material that nothing is made of does not count.
  CHECK_FALSE(
      row_of(
          plan_of(
              R"("objects": [{"shape": "sphere", "radius_m": 1}], "materials": {"m": {"emissivity": 0, "specular": 1}})"),
          "specular")
          .on);

  const Description scene = parse_scene(R"({"obscura": 1, "bands": [{"um": [8, 12]}],
    "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "specular_depth": 0}, )" +
                                            kBall + R"({"emissivity": 0, "specular": 1}}})",
                                        ".");
  const Plan none = Session(scene, 0).plan();
  CHECK_FALSE(row_of(none, "specular").on);
  CHECK(row_of(none, "specular").reason == "specular_depth is 0");
}

TEST_CASE("a moon is a sun, and air counts where it absorbs", "[scene][plan]") {
  const std::string ball =
      R"("objects": [{"shape": "sphere", "radius_m": 1, "K": 290, "material": "m"}], "materials": {"m": {"emissivity": 0.9}}, )";
  const Plan moon = plan_of(ball + R"("environment": {"moon": {"zenith_deg": 30}})");
  CHECK(row_of(moon, "sun").on);
  CHECK_THAT(row_of(moon, "sun").reason, Catch::StartsWith("the scene has a moon"));
  CHECK_FALSE(row_of(plan_of(R"("environment": {"moon": {"zenith_deg": 30, "irradiance": 0}})"), "sun").on);
  CHECK(row_of(plan_of(ball + R"("environment": {"atmosphere": {"extinction_per_m": 1e-4}})"), "atmosphere").on);
  CHECK_FALSE(
      row_of(plan_of(ball + R"("environment": {"atmosphere": {"extinction_per_m": 0, "K": 300}})"), "atmosphere").on);
}

namespace {

/// One scene of the truth table. `bands`, `cloud` (its media and source) and `rest` are JSON.
struct Row {
  const char* name;
  std::string bands, cloud, rest;
  std::string on;  // the effects that are expected to be, in their order
};

const char* const kGrey = R"([{"name": "grey"}])";
const char* const kThermal = R"([{"name": "lwir", "um": [8, 12]}])";

std::string scene_text(const std::string& bands, const std::string& cloud, const std::string& rest) {
  std::string text = R"({"obscura": 1, "bands": )" + bands;
  text +=
      R"(, "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "resolution": [16, 12], "max_oversampling": 4, "antialiasing": {"polygons": 0}})";
  if (!cloud.empty())
    text +=
        R"(, "clouds": [{"name": "c", "grid": {"shape": "box", "size_m": [2, 2, 2], "voxel_m": 0.5}, )" + cloud + "}]";
  if (!rest.empty()) text += ", " + rest;
  return text + "}";
}

std::string media(double extinction, double albedo) {
  return R"("media": [{"extinction": )" + std::to_string(extinction) + R"(, "albedo": )" + std::to_string(albedo) +
         "}]";
}

std::string effects_on(const Plan& plan) {
  std::string list;
  for (const PlanRow& row : plan.effects) {
    if (row.on) list += (list.empty() ? "" : ", ") + row.effect;
    CHECK_FALSE(row.reason.empty());
    if (row.on) CHECK_FALSE(row.bound);
  }
  return list;
}

}  // namespace

TEST_CASE("every scene has the effects that it calls for", "[scene][plan]") {
  const std::string sky = R"("environment": {"sky": {"radiance": 1}})";
  const std::string warm_sky = R"("environment": {"sky": {"K": 280}})";
  const std::string day = R"("environment": {"sky": {"radiance": 1}, "sun": {"zenith_deg": 30, "irradiance": 5}})";
  const std::string ball =
      R"("objects": [{"shape": "sphere", "radius_m": 0.5, "K": 300, "material": "m"}], "materials": {"m": {"emissivity": 0.9}}, )";
  const std::string seven = R"([{"name": "lwir", "um": [8, 12], "samples": 7}])";
  const std::string two = R"([{"name": "mwir", "um": [3, 5]}, {"name": "lwir", "um": [8, 12], "samples": 3}])";
  const std::string coloured =
      R"("media": [{"extinction": {"um": [8, 12], "value": [1, 2]}}], "temperature": {"K": 300})";
  const std::vector<Row> table = {
      {"no cloud at all", kGrey, "", sky, "sky"},
      {"nothing at all", kGrey, "", "", ""},
      {"absorption only", kGrey, media(1, 0), sky, "absorption, sky"},
      {"emission only", kGrey, media(1, 0) + R"(, "source": 2)", "", "absorption, emission"},
      {"scattering, conservative", kGrey, media(1, 1), sky, "single scattering, multiple scattering, sky"},
      {"single scatter: thin by bound", kGrey, media(4e-4, 0.9), sky, "absorption, single scattering, sky"},
      {"thin: scatters nothing that shows", kGrey, media(1e-6, 0.9), sky, "absorption, sky"},
      {"thick", kGrey, media(20, 0.9), sky, "absorption, single scattering, multiple scattering, sky"},
      {"night", kThermal, media(1, 0.3) + R"(, "temperature": {"K": 300})", warm_sky,
       "absorption, emission, single scattering, multiple scattering, sky"},
      {"day", kGrey, media(1, 0.9), day, "absorption, single scattering, multiple scattering, sun, sky"},
      {"no polygons, sun beside the picture", kGrey, media(1, 0), day, "absorption, sky"},
      {"polygons", kThermal, "", ball + warm_sky, "surfaces, sky, masking"},
      {"black polygons do not reflect the sun", kThermal, "",
       R"("objects": [{"shape": "sphere", "radius_m": 0.5, "K": 300}], )" + day, "surfaces, sky, masking"},
      {"one band whose intervals are alike", seven, media(1, 0) + R"(, "temperature": {"K": 300})", warm_sky,
       "absorption, emission, sky"},
      {"many intervals", seven, coloured, warm_sky, "absorption, emission, sky, spectral sampling"},
      {"many bands", two, coloured, warm_sky, "absorption, emission, sky, spectral sampling"},
      {"air", kThermal, media(1, 0),
       ball + R"("environment": {"sky": {"K": 280}, "atmosphere": {"extinction_per_m": 1e-3}})",
       "absorption, surfaces, sky, atmosphere, masking"},
      {"air that hardly shows", kThermal, "",
       ball + R"("environment": {"sky": {"K": 280}, "atmosphere": {"extinction_per_m": 1e-7}})",
       "surfaces, sky, masking"},
  };
  for (const Row& row : table) {
    INFO(row.name);
    Session session(parse_scene(scene_text(row.bands, row.cloud, row.rest), "."), 0);
    CHECK(effects_on(session.plan()) == row.on);
    // Photons only where something asks for them.
    const bool asks = row.on.find("multiple") != std::string::npos || row.rest.find("\"m\"") != std::string::npos;
    CHECK(session.plan().estimator.again == asks);
  }
}

TEST_CASE("suns are off where their light is nowhere", "[scene][plan]") {
  const auto sun_row = [](const std::string& bands, const std::string& rest) {
    return row_of(Session(parse_scene(scene_text(bands, media(1, 0.9), rest), "."), 0).plan(), "sun");
  };
  const PlanRow dark = sun_row(
      kThermal,
      R"("environment": {"sky": {"K": 280}, "sun": {"zenith_deg": 30, "irradiance": {"um": [1, 2], "value": [1, 0]}}})");
  CHECK_FALSE(dark.on);
  CHECK(dark.bound == 0.0);
  CHECK(dark.reason == "the bands have no solar part");
  // Below the horizon it lights clouds from below, unless the ground is in its way everywhere.
  const std::string low =
      R"("environment": {"sky": {"radiance": 1}, "sun": {"zenith_deg": 100, "azimuth_deg": 90, "irradiance": 5}})";
  const std::string floating = sun_row(kGrey, low).reason;
  CHECK_THAT(floating, Catch::Contains("below the horizon: nothing keeps"));
  const auto ground = [&](int side) {
    return R"("objects": [{"shape": "plane", "size_m": [)" + std::to_string(side) + ", " + std::to_string(side) +
           R"(], "place": {"translate_m": [0, 0, -2]}}], )" + low;
  };
  const PlanRow hidden = sun_row(kGrey, ground(200));
  CHECK_FALSE(hidden.on);
  CHECK(hidden.bound == 0.0);
  CHECK_THAT(hidden.reason, Catch::Contains("the ground keeps"));
  CHECK(sun_row(kGrey, ground(20)).on);  // too small: light comes in beside it
}

TEST_CASE("clouds out of every ray's way are left out, unless others bring their light", "[scene][plan]") {
  const auto session = [](double albedo, const std::string& more = "") {
    std::string text =
        R"({"obscura": 1, "bands": [{"name": "grey"}], "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "resolution": [16, 12]}, "clouds": [)";
    for (const int x : {0, 40}) {
      text +=
          R"({"name": "at )" + std::to_string(x) +
          R"(", "grid": {"shape": "box", "size_m": [2, 2, 2], "voxel_m": 0.5}, "source": 1, "place": {"translate_m": [)";
      text += std::to_string(x) + ", 0, 0]}, " + media(1, x == 0 ? albedo : 0.5) + (x == 0 ? "}, " : "}");
    }
    return Session(parse_scene(text + R"(], "environment": {"sky": {"radiance": 1}})" + more + "}", "."), 0);
  };
  Session black = session(0);
  CHECK(black.world().cloud_count() == 1);
  CHECK_THAT(row_of(black.plan(), "absorption").reason, Catch::Contains("\"at 40\" out of every ray's way"));
  CHECK_FALSE(row_of(black.plan(), "single scattering").on);
  CHECK(row_of(black.plan(), "single scattering").bound == 0.0);
  CHECK(session(0.5).world().cloud_count() == 2);  // the one in view scatters the other's light
  CHECK(session(0, R"(, "probes": [{"position_m": [40, 0, 0]}])").world().cloud_count() == 2);
  // Another view calls for it again, and as it scatters, for what may light it.
  Session moved = session(0);
  CameraSettings camera = moved.plan().camera;
  camera.look_at_m = {40, 0, 0};
  CHECK(moved.world(camera).cloud_count() == 2);
  CHECK(moved.world().cloud_count() == 1);
}

namespace {

/// The image error (sensor/METHODS.md, "Comparing images") between two renderings of a scene.
double image_error(const std::span<const float>& image, const std::span<const float>& reference) {
  double brightest = 0, sum = 0;
  for (const float value : reference) brightest = std::max(brightest, static_cast<double>(std::abs(value)));
  for (std::size_t p = 0; p < image.size(); ++p) {
    const double truth = reference[p];
    sum += std::pow((static_cast<double>(image[p]) - truth) / std::max(std::abs(truth), 0.05 * brightest), 2);
  }
  return std::sqrt(sum / static_cast<double>(image.size()));
}

}  // namespace

TEST_CASE("what is dropped changes the image by no more than its bound", "[scene][plan]") {
  struct Border {
    const char* effect;
    std::string cloud, rest;
    bool furnace;   // with the effect the radiance is that of the sky, 1, everywhere
    double within;  // the bound is at most so many times too large
  };
  const std::string sky = R"("environment": {"sky": {"radiance": 1}})";
  // Fills the picture: the sky is seen by reflection alone.
  const std::string wall =
      R"("materials": {"grey": {"emissivity": 0.5}}, "objects": [{"shape": "plane", "size_m": [100, 100], "material": "grey", "radiance": 1, "place": {"rotate_deg": [90, 0, 0]}}], )";
  const std::string ball = R"("objects": [{"shape": "sphere", "radius_m": 1, "radiance": 1}], )";
  const std::vector<Border> borders = {
      {"atmosphere", "",
       ball + R"("environment": {"sky": {"radiance": 1}, "atmosphere": {"extinction_per_m": 4e-5, "radiance": 0.1}})",
       false, 10},
      {"sky", "", wall + R"("environment": {"sky": {"radiance": 4e-5}})", false, 10},
      {"emission", media(2e-4, 0) + R"(, "source": 0.5)", sky, false, 10},
      {"single scattering", media(2e-4, 1), sky, true, 10},
      {"multiple scattering", media(8e-3, 1), sky, true, 30},
      {"sun", media(2e-3, 1), R"("environment": {"sky": {"radiance": 1}, "sun": {"zenith_deg": 60, "irradiance": 3}})",
       false, 10},
  };
  for (const Border& border : borders) {
    INFO(border.effect);
    const auto render = [&](const std::string& more) {
      return run_scene(
          parse_scene(scene_text(kGrey, border.cloud,
                                 border.rest + R"(, "render": {"method": "path", "samples": 16, "target_error": null)" +
                                     more + "}"),
                      "."),
          {});
    };
    // Forced, so that the same scene is rendered with it and without.
    const std::string off = R"(, "effects": {")" + std::string(border.effect) + R"(": false})";
    const std::string on = R"(, "effects": {")" + std::string(border.effect) + R"(": true})";
    const RunResult without = render(off), with = render(on);
    const auto row = std::find_if(without.report.plan.begin(), without.report.plan.end(),
                                  [&](const PlanRow& r) { return r.effect == border.effect; });
    REQUIRE(row->bound);
    CHECK_FALSE(row->on);
    const std::span<const float> dropped = without.image.channel("grey.radiance");
    const std::vector<float> exact(dropped.size(), 1.0f);
    const double error =
        image_error(dropped, border.furnace ? std::span<const float>(exact) : with.image.channel("grey.radiance"));
    INFO("error " << error << " bound " << *row->bound);
    CHECK(*row->bound < 3e-3);
    CHECK(error > 0);
    CHECK(error <= *row->bound);
    // A bound divided by what it holds would be broken.
    CHECK(error > *row->bound / border.within);
  }
}

TEST_CASE("more is dropped with a larger budget, never more than a tenth of it", "[scene][plan]") {
  const Description scene = parse_scene(
      scene_text(
          kGrey, media(8e-3, 0.9) + R"(, "source": 1e-3)",
          R"("objects": [{"shape": "sphere", "radius_m": 0.2, "radiance": 1}], "environment": {"sky": {"radiance": 0.003}, "sun": {"zenith_deg": 60, "irradiance": 1e-3}, "atmosphere": {"extinction_per_m": 1e-6, "radiance": 1}})"),
      ".");
  Session session(scene, 0, {}, 0);
  std::vector<bool> before(12, true);
  int changes = 0;
  for (const double budget : {0.0, 1e-4, 1e-3, 1e-2, 0.1, 0.5, 1.0, 10.0}) {
    INFO(budget);
    const Plan plan = make_plan(scene, session.summary(), budget);
    double dropped = 0;
    for (std::size_t e = 0; e < plan.effects.size(); ++e) {
      const PlanRow& row = plan.effects[e];
      CHECK((before[e] || !row.on));  // what was off stays off
      changes += before[e] && !row.on && budget > 0;
      before[e] = row.on;
      if (!row.on) dropped += row.bound.value_or(0);
    }
    CHECK(dropped <= 0.1 * budget);
    CHECK(plan.budget.dropped == Approx(dropped));
    CHECK(plan.budget.sampled == Approx(budget - dropped));
  }
  CHECK(changes >= 4);  // the sky is in sight: it is never little
}

TEST_CASE("the user's word comes before any bound", "[scene][plan]") {
  const std::string text = R"("environment": {"sky": {"radiance": 1}}, "render": {"effects": )";
  const auto forced = [&](const std::string& effects, double extinction = 1e-6) {
    return Session(parse_scene(scene_text(kGrey, media(extinction, 0.9), text + effects + "}"), "."), 0);
  };
  CHECK(row_of(forced(R"({"single scattering": true, "multiple scattering": true})").plan(), "multiple scattering").on);
  Session dark = forced(R"({"sky": false})", 1);
  CHECK_FALSE(row_of(dark.plan(), "sky").on);
  CHECK(row_of(dark.plan(), "sky").reason == "forced off");
  CHECK(row_of(dark.plan(), "sky").bound);
  CHECK(SpectralWorld(dark.world(), 0).sky() == 0);
  CHECK(dark.plan().budget.dropped == 0);
  CHECK(dark.plan().warnings.size() == 1);
  // What is absent cannot be forced on.
  Session absent = forced(R"({"sun": true})", 1);
  CHECK_FALSE(row_of(absent.plan(), "sun").on);
  REQUIRE(absent.plan().warnings.size() == 1);
  CHECK_THAT(absent.plan().warnings[0], Catch::Contains("cannot be forced on"));
  CHECK_THROWS_WITH(forced(R"({"atmospere": true})"), Catch::Contains("atmosphere"));
  Session single = forced(R"({"multiple scattering": false})", 5);
  CHECK_FALSE(single.plan().estimator.again);
  CHECK(row_of(single.plan(), "single scattering").on);
}
