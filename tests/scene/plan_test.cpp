// What the plan says of surfaces, light and air, and which settings it hands on.
#include <catch2/catch.hpp>

#include "scene/scene_io.h"
#include "scene/session.h"

#include <algorithm>

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
  const auto row = std::find_if(plan.effects.begin(), plan.effects.end(), [&](const PlanRow& r) { return r.effect == effect; });
  REQUIRE(row != plan.effects.end());
  CHECK_FALSE(row->reason.empty());
  return *row;
}

const std::string kBall = R"("environment": {"sky": {"K": 260}}, "objects": [{"shape": "sphere", "radius_m": 1, "material": "m"}], "materials": {"m": )";

}  // namespace

TEST_CASE("an empty scene has no surfaces, mirrors, air, sun or masks", "[scene][plan]") {
  const Plan plan = plan_of("");
  for (const char* effect : {"surfaces", "specular", "sun", "atmosphere", "masking"}) CHECK_FALSE(row_of(plan, effect).on);
  CHECK(plan.radiance.specular_depth == 2);
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
  CHECK(row_of(plan_of(kBall + R"({"specular": 0.5, "emissivity_by_angle": {"angle_deg": [0, 90], "factor": [1, 0]}}})"), "specular").on);
  // A material that nothing is made of does not count.
  CHECK_FALSE(row_of(plan_of(R"("objects": [{"shape": "sphere", "radius_m": 1}], "materials": {"m": {"emissivity": 0, "specular": 1}})"), "specular").on);

  const Description scene = parse_scene(R"({"obscura": 1, "bands": [{"um": [8, 12]}],
    "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "specular_depth": 0}, )" + kBall + R"({"emissivity": 0, "specular": 1}}})", ".");
  const Plan none = Session(scene, 0).plan();
  CHECK_FALSE(row_of(none, "specular").on);
  CHECK(row_of(none, "specular").reason == "specular_depth is 0");
}

TEST_CASE("a moon is a sun, and air counts where it absorbs", "[scene][plan]") {
  const std::string ball = R"("objects": [{"shape": "sphere", "radius_m": 1, "K": 290, "material": "m"}], "materials": {"m": {"emissivity": 0.9}}, )";
  const Plan moon = plan_of(ball + R"("environment": {"moon": {"zenith_deg": 30}})");
  CHECK(row_of(moon, "sun").on);
  CHECK_THAT(row_of(moon, "sun").reason, Catch::StartsWith("the scene has a moon"));
  CHECK_FALSE(row_of(plan_of(R"("environment": {"moon": {"zenith_deg": 30, "irradiance": 0}})"), "sun").on);
  CHECK(row_of(plan_of(ball + R"("environment": {"atmosphere": {"extinction_per_m": 1e-4}})"), "atmosphere").on);
  CHECK_FALSE(row_of(plan_of(ball + R"("environment": {"atmosphere": {"extinction_per_m": 0, "K": 300}})"), "atmosphere").on);
}
