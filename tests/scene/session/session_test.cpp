// A session asked with methods, one of which is this file's own: a method is one file and one value.
#include "scene/session/session.h"

#include <catch2/catch.hpp>

#include "scene/file/scene_io.h"
#include "scene/verify/verify.h"

using namespace obscura;

namespace {

constexpr double kLight = 3;

/// Says that all light is the same, and is not in doubt.
Estimator by_constant(const World&, const Method&, const EstimatorSettings&, const Solution&) {
  Estimator estimator;
  estimator.radiance = [](int, const RayShare&, std::span<const Ray> rays, std::span<const std::uint64_t>,
                          std::span<Incoming> incoming) {
    for (Incoming& in : incoming) in.direct = kLight;
    RadianceCounts counts;
    counts.rays = rays.size();
    return counts;
  };
  estimator.fluence = [](int, const Vec3d&, int, std::uint64_t) { return Measured{4 * kPi * kLight, 0}; };
  estimator.crossing = [](int, std::size_t, int) { return Crossing{{kPi * kLight, 0}, {kPi * kLight, 0}, 0}; };
  estimator.what = "a constant";
  return estimator;
}

const MethodType kConstant{
    .word = "constant",
    .name = "constant",
    .unfit = [](const World& world, const Method&, const EstimatorSettings&) -> std::optional<NumericalError> {
      if (world.spheres().empty()) return std::nullopt;
      return NumericalError("constant", "hot spheres are not constant", "leave them out");
    },
    .basis = [](const Method&, const EstimatorSettings&) { return SolutionBasis{}; },
    .solve = [](const World&, const Method&, const EstimatorSettings&, const Progress&) { return Solution(); },
    .estimator = by_constant};

std::string furnace(const std::string& more = "") {
  return R"({"obscura": 1, "bands": [{"name": "vis"}],
    "clouds": [{"grid": {"shape": "sphere", "radius_m": 1, "voxel_m": 0.25}, "media": [{"extinction": 2, "albedo": 0.5}], "source": 3}],
    "environment": {"sky": {"radiance": 3}}, "probes": [{"position_m": [0, 0, 0]}],
    "flux": [{"center_m": [0, 0, 2], "normal": [0, 0, 1], "size_m": [1, 1]}],
    "sensor": {"position_m": [0, -8, 0], "look_at_m": [0, 0, 0], "resolution": [12, 10], "max_oversampling": 4},
    "render": {"photons": 20000, "nearest": 16, "samples": 16})" +
         more + "}";
}

Method constant() {
  Method method;
  method.type = &kConstant;
  return method;
}

}  // namespace

TEST_CASE("a method of one's own is rendered, refused and judged as any other", "[scene][session]") {
  Session session(parse_scene(furnace(), "."), 0);
  const Plan plan = session.plan();
  const Rendered image = session.render(plan.camera, plan.sampling, constant(), 1);
  for (const float value : image.film.values(0, Film::Value::radiance)) CHECK(value == Approx(3).epsilon(1e-6));
  for (const float error : image.film.values(0, Film::Value::error)) CHECK(error < 1e-6);
  CHECK(session.estimator(constant(), 1).fluence(0, {}, 1, 1).value == Approx(4 * kPi * kLight));

  VerifySettings settings;
  settings.passes = 2;
  std::vector<VerifyMethod> found;
  for (const Method& method : referees(session)) found.push_back(run_method(session, method, settings));
  found.push_back(run_method(session, constant(), settings));
  const VerifiedScene verdict = compare_methods(session.scene(), found, settings);
  CHECK(verdict.method("constant").refusal.empty());
  CHECK(verdict.failures().empty());
  // In a scene that is no furnace the others contradict it.
  Session dark(parse_scene(furnace(R"(, "name": "dark")"), ".", {{"/environment/sky/radiance", "1", ""}}), 0);
  found.clear();
  for (const Method& method : referees(dark)) found.push_back(run_method(dark, method, settings));
  found.push_back(run_method(dark, constant(), settings));
  CHECK_FALSE(compare_methods(dark.scene(), found, settings).failures().empty());

  Session hot(parse_scene(furnace(R"(, "sources": [{"position_m": [0, 0, 3], "radius_m": 0.1, "radiance": 9}])"), "."),
              0);
  CHECK_THROWS_AS(hot.render(plan.camera, plan.sampling, constant(), 1), NumericalError);
}

TEST_CASE("what a session renders depends on its arguments alone", "[scene][session]") {
  Session session(parse_scene(furnace(), ".", {{"/environment/sky/radiance", "1", ""}}), 0);
  const Plan plan = session.plan();
  const auto picture = [&](const MethodType& type, std::uint64_t seed) {
    const Film film = session.render(plan.camera, plan.sampling, method_of(session.scene(), type), seed).film;
    const auto values = film.values(0, Film::Value::radiance);
    return std::vector<float>(values.begin(), values.end());
  };
  std::vector<std::vector<float>> first, second;
  for (const MethodType* type : methods()) first.push_back(picture(*type, 1));
  CameraSettings above = plan.camera;
  above.position_m = {0, 0, 9};
  above.up = {0, 1, 0};
  session.render(above, plan.sampling, plan.method, 5);
  for (std::size_t m = methods().size(); m-- > 0;) second.insert(second.begin(), picture(*methods()[m], 1));
  CHECK(first == second);
  CHECK(picture(kPathTracer, 2) != first[index_of(kPathTracer)]);
  CHECK(picture(kPhotonMap, 2) != first[index_of(kPhotonMap)]);
}

TEST_CASE("without a method the plan's choice makes the image, and the report says which", "[scene][session]") {
  const auto plan_of = [](const std::string& edits) {
    Session session(parse_scene(furnace(), ".", {{"/render/method", edits, ""}}), 0);
    return session.plan();
  };
  const Plan open = plan_of("null");
  CHECK(open.method.type == open.choice.cheaper);
  CHECK(open.method.type == &kPathTracer);  // few pixels
  CHECK(plan_of("\"photon\"").method.type == open.photon);
  CHECK(plan_of("\"ordinates\"").method.type == &kOrdinates);
}
