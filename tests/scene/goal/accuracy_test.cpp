// Images to a target error, and within a time.
#include "scene/goal/accuracy.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "photon/paths/radiance.h"
#include "scene/file/scene_io.h"
#include "scene/run/run.h"
#include "sensor/judge/compare.h"

using namespace obscura;

namespace {

std::string smoke(const std::string& render,
                  const std::string& media = R"("albedo": 0.9, "phase": {"type": "henyey_greenstein", "g": 0.6})") {
  std::string text = R"({"obscura": 1, "bands": [{"name": "vis"}],
    "clouds": [{"grid": {"shape": "gaussian", "sigma_m": 1, "size_m": [6, 6, 6], "voxel_m": 0.25},
                "media": [{"extinction": 1.5, )";
  text +=
      media +
      R"(}], "source": 0.2}], "environment": {"sky": {"radiance": 0.1}, "sun": {"zenith_deg": 50, "azimuth_deg": 90, "irradiance": 1}},
    "sensor": {"position_m": [0, -20, 2], "look_at_m": [0, 0, 0], "fov_deg": 20, "resolution": [24, 20], "max_oversampling": 4},
    "render": {)";
  return text + render + "}}";
}

RunResult run(const std::string& text) { return run_scene(parse_scene(text, "."), {}); }

/// Takes a second for each question.
RunClock slow_clock(double& now) {
  return [&now] { return now += 1; };
}

}  // namespace

TEST_CASE("the number of passes and their samples are the cheapest for an error", "[scene][accuracy]") {
  // Time is product of passes and pass; the plan is compared with all others.
  RecipeModel model;
  for (const double fixed : {0.0, 0.3, 20.0}) {
    for (const double floor : {0.0, 1e-4, 1e-2}) {
      model.fixed_s = fixed;
      model.sample_s = 0.01;
      model.floor = floor;
      model.noise = 0.04;
      model.bias = 1e-5;
      for (const double error : {0.1, 0.02, 0.005}) {
        const auto plan = plan_for_error(model, error);
        REQUIRE(plan);
        CHECK(plan->error <= error * (1 + 1e-9));
        CHECK(plan->passes >= model.least_passes);
        double best = kInfinity;
        for (int samples = 1; samples <= kMostPoints; ++samples) {
          const double passes = std::max<double>(model.least_passes,
                                                 std::ceil(model.pass_square(samples) / (error * error - model.bias)));
          best = std::min(best, passes * model.pass_s(samples));
        }
        CAPTURE(fixed, floor, error, plan->samples, plan->passes);
        CHECK(plan->seconds < 1.25 * best);
      }
      CHECK_FALSE(plan_for_error(model, std::sqrt(model.bias)));
      const PassPlan timed = plan_for_time(model, 1000);
      CHECK(timed.seconds <= 1000);
      CHECK(timed.seconds > 600);
    }
  }
}

TEST_CASE("a target error is reached and the interval tells where", "[scene][accuracy]") {
  const RunResult truth = run(smoke(R"("method": "path", "seed": 99, "target_error": 0.004)"));
  REQUIRE(truth.report.accuracy->reached);
  int inside = 0, runs = 0;
  for (const char* method : {"", R"("method": "path",)", R"("method": "photon", "nearest": 32,)"}) {
    for (const double target : {0.05, 0.02}) {
      for (const int seed : {1, 2}) {
        const RunResult result = run(smoke(std::string(method) + "\"seed\": " + std::to_string(seed) +
                                           ", \"target_error\": " + std::to_string(target)));
        REQUIRE(result.report.accuracy);
        const AccuracyReport& told = *result.report.accuracy;
        const double off = compare(result.image, truth.image).image_error();
        const double found =
            std::sqrt(std::max(0.0, off * off - truth.report.accuracy->error * truth.report.accuracy->error));
        CAPTURE(method, target, seed, told.method, told.passes, told.error, told.interval[0], told.interval[1], found);
        CHECK(told.reached);
        CHECK(told.ended == "target");
        CHECK(found < 1.15 * target);  // sixteen-odd per cent of noise in the error of 480 pixels are five of its
                                       // standard deviations
        CHECK(found > 0.4 * target);   // nor is it far better than it was asked for
        inside += found > told.interval[0] && found < told.interval[1];
        ++runs;
        CHECK(told.trials.size() >= 1);
        if (*method != 0) CHECK(result.image.has("vis.bias") == (told.method != kPathTracer.name));
      }
    }
  }
  CHECK(inside >= runs - 3);
}

TEST_CASE("a scene where nothing scatters takes its rays from the target", "[scene][accuracy]") {
  const std::string media = R"("albedo": 0)";
  const RunResult coarse = run(smoke(R"("target_error": 0.02)", media)),
                  fine = run(smoke(R"("target_error": 0.0005)", media));
  CHECK(coarse.report.accuracy->reached);
  CHECK(fine.report.accuracy->reached);
  double coarse_rays = 0, fine_rays = 0;
  for (const float n : coarse.image.channel("rays.N")) coarse_rays += n;
  for (const float n : fine.image.channel("rays.N")) fine_rays += n;
  CHECK(fine_rays > coarse_rays);
  CHECK(compare(coarse.image, fine.image).image_error() < 0.02);
}

TEST_CASE("a time limit ends the run before a pass that would not fit", "[scene][accuracy]") {
  // Nothing scatters: passes are short, whatever the clock says.
  Session session(parse_scene(smoke(R"("time_limit_s": 200)", R"("albedo": 0)"), "."), 0);
  double now = 0;
  const AccurateImage made = render_to_goal(session, {std::nullopt, 200.0}, slow_clock(now));
  CHECK(made.accuracy.ended == "time");
  CHECK(now <= 201);
  CHECK(now > 150);
  CHECK(made.accuracy.passes > 10);
  CHECK_FALSE(made.accuracy.reached());
  CHECK(made.rendered.film.passes(0, 0) == made.accuracy.passes);
  // Passes of the slow clock take as long each; a shorter time has fewer.
  double then = 0;
  CHECK(render_to_goal(session, {std::nullopt, 60.0}, slow_clock(then)).accuracy.passes < made.accuracy.passes);
}

TEST_CASE("a run by photons ends in its time too", "[scene][accuracy]") {
  // A blurred map, which more photons would sharpen; by the slow clock a hundred thousand of them take a second.
  Session session(parse_scene(smoke(R"("method": "photon", "final_gather": 0, "nearest": 2000)"), "."), 0);
  AccuracyGoal goal{std::nullopt, 14.0};
  goal.most_photons = 3200000;
  double now = 0;
  const AccurateImage made = render_to_goal(session, goal, slow_clock(now));
  CHECK(made.accuracy.ended == "time");
  CAPTURE(made.accuracy.recipe.text(), made.accuracy.passes, made.accuracy.pilot_s, made.accuracy.trials.size(),
          made.accuracy.photons_s, made.accuracy.image_s);
  CHECK(made.accuracy.recipe.method.photons <= 400000);
  CHECK(now <= 16);
}

TEST_CASE("a method whose bias stands above the target says so", "[scene][accuracy]") {
  // As many neighbours as photons: the map is one blur.
  const std::string blur = R"("method": "photon", "final_gather": 0, "nearest": 2000)";
  Session session(parse_scene(smoke(blur), "."), 0);
  AccuracyGoal goal{ErrorTarget{0.01}, std::nullopt};
  goal.most_photons = 4000;
  double now = 0;
  const AccurateImage made = render_to_goal(session, goal, slow_clock(now));
  CHECK(made.accuracy.ended == "bias");
  CHECK_FALSE(made.accuracy.reached());
  CHECK(made.accuracy.bias > 0.01);
  // With more photons allowed their number grows until it is reached.
  goal.target_error = ErrorTarget{0.08};
  goal.most_photons = 400000;
  const AccurateImage more = render_to_goal(session, goal, slow_clock(now));
  CHECK(more.accuracy.ended == "target");
  CHECK(more.accuracy.recipe.method.photons > 4000);
}

TEST_CASE("a run to a goal keeps its report: seed, energies, photons of all passes", "[scene][accuracy]") {
  const RunResult result = run(smoke(R"("method": "photon", "final_gather": 1, "seed": 7, "target_error": 0.05)"));
  const AccuracyReport& told = *result.report.accuracy;
  CHECK(result.report.seed == 7);
  CHECK(result.report.photons.emitted == told.photons * static_cast<std::uint64_t>(told.passes));
  const EnergyReport& energy = result.report.energy.at(0).second;
  const RunResult plain = run(smoke(R"("method": "photon", "photons": 100000)"));
  CHECK(energy.emitted_W == Approx(plain.report.energy.at(0).second.emitted_W).epsilon(0.01));
  CHECK(energy.emitted_W == Approx(energy.absorbed_W + energy.escaped_W).epsilon(1e-9));
  CHECK_FALSE(plain.report.accuracy);
}
