// Plan, session and run: what is on, what is kept, what comes out.
#include "scene/run/run.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>

#include "octree/base/error.h"
#include "scene/file/scene_io.h"
#include "scene/session/session.h"

using namespace obscura;

namespace {

std::string scene(const std::string& medium = R"("albedo": 0.5)", const std::string& rest = "") {
  return R"({"obscura": 1, "name": "test", "bands": [{"name": "lwir", "um": [8, 12]}, {"name": "mwir", "um": [3, 5]}],
    "clouds": [{"grid": {"shape": "sphere", "radius_m": 1, "voxel_m": 0.1},
                "media": [{"density": "density", "extinction": 2, )" +
         medium + R"(}], "temperature": {"K": 320}}],
    "environment": {"sky": {"K": 260}},
    "sensor": {"position_m": [0, -8, 0], "look_at_m": [0, 0, 0], "resolution": [24, 16], "max_oversampling": 4},
    "render": {"method": "photon", "photons": 20000, "nearest": 32})" +
         rest + "}";
}

bool is_on(const std::vector<PlanRow>& plan, const std::string& effect) {
  const auto row = std::find_if(plan.begin(), plan.end(), [&](const PlanRow& r) { return r.effect == effect; });
  REQUIRE(row != plan.end());
  CHECK(!row->reason.empty());
  return row->on;
}

}  // namespace

TEST_CASE("the plan has every effect on that the scene holds, and no other", "[scene][plan]") {
  const auto plan_of = [](const std::string& text) {
    Session session(parse_scene(text, "."), 0);
    return session.plan().effects;
  };
  const auto scattering = plan_of(scene());
  for (const char* effect : {"absorption", "emission", "single scattering", "multiple scattering", "sky"}) {
    CHECK(is_on(scattering, effect));
  }
  for (const char* effect : {"surfaces", "specular", "sun", "atmosphere", "time", "spectral sampling", "masking"}) {
    CHECK(!is_on(scattering, effect));
  }
  const auto absorbing = plan_of(scene(R"("albedo": 0)"));
  CHECK(!is_on(absorbing, "single scattering"));
  CHECK(!is_on(absorbing, "multiple scattering"));
  CHECK(!is_on(plan_of(scene(R"("albedo": 1)")), "absorption"));
}

TEST_CASE("a run gives image and report of every band", "[scene][run]") {
  const RunResult result =
      run_scene(parse_scene(scene(R"("albedo": 0.5)", R"(, "probes": [{"name": "middle", "position_m": [0, 0, 0]}],
        "flux": [{"name": "above", "center_m": [0, 0, 1.5], "normal": [0, 0, 1], "size_m": [8, 8]}])"),
                            "."),
                {});
  CHECK(!result.failure);
  for (const char* channel : {"lwir.radiance", "lwir.error", "lwir.bias", "lwir.transmission", "lwir.temperature",
                              "mwir.radiance", "depth.Z", "object.id", "rays.N"}) {
    CHECK(result.image.has(channel));
  }
  // The corner sees the sky and nothing else.
  CHECK(result.image.channel("lwir.temperature")[0] == Approx(260).epsilon(1e-5));
  CHECK(result.image.channel("lwir.transmission")[0] == 1);
  const std::size_t middle = 8 * 24 + 12;
  CHECK(result.image.channel("lwir.temperature")[middle] > 290);
  CHECK(result.image.channel("lwir.temperature")[middle] < 320);

  const Report& report = result.report;
  REQUIRE(report.energy.size() == 2);
  for (const auto& [band, energy] : report.energy) {
    CHECK(energy.emitted_W ==
          Approx(energy.absorbed_W + energy.surface_W + energy.escaped_W + energy.truncated_W).epsilon(1e-9));
  }
  CHECK(report.photons.emitted == 40000);
  REQUIRE(report.octree.size() == 1);
  CHECK(report.octree[0].bytes < report.octree[0].bytes_dense);
  REQUIRE(report.probes.size() == 1);
  // Between the fluence of a cavity at 260 K and at 320 K.
  const double fluence = report.probes[0].bands[0].second.fluence;
  const Band band("lwir", 8, 12);
  CHECK(fluence > 4 * kPi * band.planck(260));
  CHECK(fluence < 4 * kPi * band.planck(320));
  CHECK(report.probes[0].bands[0].second.error < 0.05 * fluence);
  REQUIRE(report.flux.size() == 1);
  CHECK(report.flux[0].bands[0].second.forward > 0);
  CHECK(report.flux[0].bands[0].second.backward > 0);
  CHECK(report.rays[0] == std::pair<std::string, std::uint64_t>("base", 24 * 16));
  CHECK(report.rays[1] ==
        std::pair<std::string, std::uint64_t>("deciding", 25 * 17));  // pixels of 4 rays are split once
}

TEST_CASE("paths and photons agree on image, probes and flux", "[scene][run][path]") {
  const std::string text = scene(R"("albedo": 0.7)", R"(, "probes": [{"name": "p", "position_m": [0.3, 0, 0]}],
    "flux": [{"name": "f", "center_m": [0, 0, 1.2], "normal": [0, 0, 1], "size_m": [2, 2]}])");
  const RunResult photon = run_scene(parse_scene(text, "."), {});
  const RunResult path = run_scene(parse_scene(text, ".", {{"/render/method", "\"path\"", ""}}), {});
  CHECK(path.report.photons.emitted == 0);
  CHECK(path.report.energy.empty());
  double mean[2] = {0, 0};
  for (const float value : photon.image.channel("lwir.radiance")) mean[0] += static_cast<double>(value);
  for (const float value : path.image.channel("lwir.radiance")) mean[1] += static_cast<double>(value);
  CHECK(mean[1] == Approx(mean[0]).epsilon(0.003));
  const FluenceReport& a = photon.report.probes[0].bands[0].second;
  const FluenceReport& b = path.report.probes[0].bands[0].second;
  CHECK(std::abs(a.fluence - b.fluence) < 4 * std::hypot(a.error, b.error));
  CHECK(b.error < 0.01 * b.fluence);
  const CrossingReport& c = photon.report.flux[0].bands[0].second;
  const CrossingReport& d = path.report.flux[0].bands[0].second;
  CHECK(std::abs(c.forward - c.backward - (d.forward - d.backward)) < 4 * std::hypot(c.error, d.error));
  CHECK(d.forward == Approx(c.forward).epsilon(0.02));
  CHECK(d.backward == Approx(c.backward).epsilon(0.02));
}

TEST_CASE("ordinates make images, probes and fluxes too, with errors", "[scene][run]") {
  const std::string text = scene(
      R"("albedo": 0.5)",
      R"(, "probes": [{"position_m": [0, 0, 0]}], "flux": [{"center_m": [0, 0, -1.2], "normal": [0, 0, -1], "size_m": [2, 2]}])");
  const auto by = [&](const char* method) {
    return run_scene(parse_scene(text, ".", {{"/render/method", method, ""}, {"/render/samples", "256", ""}}), {});
  };
  const RunResult grid = by("\"ordinates\""), paths = by("\"path\"");
  CHECK(grid.report.method.used == "ordinates");
  CHECK_FALSE(grid.image.has("lwir.bias"));  // nothing is left to chance: it is the error
  const FluenceReport& a = grid.report.probes[0].bands[0].second;
  const FluenceReport& b = paths.report.probes[0].bands[0].second;
  CHECK(a.error > 0);
  CHECK(std::abs(a.fluence - b.fluence) < 4 * std::hypot(a.error, b.error));
  REQUIRE(grid.report.flux.size() == 1);
  CHECK_THAT(grid.report.warnings.back(), Catch::Contains("found by paths"));
  double sum = 0, reference = 0, doubt = 0;
  for (std::size_t p = 0; p < grid.image.pixel_count(); ++p) {
    sum += grid.image.channel("lwir.radiance")[p];
    reference += paths.image.channel("lwir.radiance")[p];
    doubt += grid.image.channel("lwir.error")[p];
  }
  CHECK(std::abs(sum - reference) < 2 * doubt + 0.005 * reference);
  CHECK(doubt < 0.05 * reference);
}

TEST_CASE("a path tracer says what it cannot find", "[scene][run][path]") {
  const std::string text = scene(R"("albedo": 0.7)", R"(, "beams": [{"position_m": [0, 0, 5], "toward": [0, 0, -1]}])");
  CHECK_THROWS_AS(run_scene(parse_scene(text, ".", {{"/render/method", "\"path\"", ""}}), {}), NumericalError);
  CHECK_NOTHROW(run_scene(parse_scene(text, "."), {}));
  CHECK_THROWS_AS(run_scene(parse_scene(text, ".", {{"/render/final_gather", "1", ""}}), {}), NumericalError);
}

TEST_CASE("scattering_depth cuts off, and the report says how much", "[scene][run]") {
  const std::string text = scene(R"("albedo": 0.9)");
  const auto at = text.find("\"max_oversampling\"");
  const std::string limited = text.substr(0, at) + "\"scattering_depth\": 1, " + text.substr(at);
  const RunResult result = run_scene(parse_scene(limited, "."), {});
  CHECK(result.report.energy[0].second.truncated_W > 0);
  CHECK(result.report.warnings.size() >= 1);
  const RunResult whole = run_scene(parse_scene(text, "."), {});
  CHECK(whole.report.energy[0].second.truncated_W == 0);
  const std::size_t middle = 8 * 24 + 12;
  CHECK(result.image.channel("lwir.radiance")[middle] < whole.image.channel("lwir.radiance")[middle]);
}

TEST_CASE("a session keeps World and photon maps when only the camera moves", "[scene][session]") {
  Session session(parse_scene(scene(), "."), 0);
  const Plan plan = session.plan();
  const Light* light = session.estimator(plan.method, 1).light;
  const std::size_t photons = light->maps[0].volume.size();
  const Photon* first = light->maps[0].volume.photons().data();
  const Film before = session.render().film;

  CameraSettings above = plan.camera;
  above.position_m = {0, 0, 8};
  above.up = {0, 1, 0};
  session.render(above, plan.sampling, plan.method, 1);
  const Film after = session.render().film;
  light = session.estimator(plan.method, 1).light;
  CHECK(light->maps[0].volume.photons().data() == first);
  CHECK(light->maps[0].volume.size() == photons);
  const auto a = before.values(0, Film::Value::radiance);
  const auto b = after.values(0, Film::Value::radiance);
  CHECK(std::equal(a.begin(), a.end(), b.begin()));

  Method fewer = plan.method;
  fewer.photons = 5000;
  CHECK(session.estimator(fewer, 1).light->emitted == 10000);
  // What was asked for in between does not change the result.
  const Film again = session.render().film;
  const auto c = again.values(0, Film::Value::radiance);
  CHECK(std::equal(a.begin(), a.end(), c.begin()));
}

TEST_CASE("a run that is cancelled over its image gives what there is, marked partial", "[scene][run]") {
  std::atomic<bool> cancelled{false};
  const Progress progress(
      [&](std::string_view stage, std::uint64_t, std::uint64_t) { cancelled = cancelled || stage == "image"; },
      &cancelled);
  const std::string text = scene();
  const auto at = text.find("[24, 16]");
  const RunResult result =
      run_scene(parse_scene(text.substr(0, at) + "[240, 160]" + text.substr(at + 8), "."), {}, progress);
  CHECK(result.report.partial);
  CHECK(result.report.energy[0].second.absorbed_W > 0);
  const auto rays = result.image.channel("rays.N");
  const auto done = static_cast<std::size_t>(std::count_if(rays.begin(), rays.end(), [](float n) { return n > 0; }));
  CHECK(done > 0);
  CHECK(done < rays.size());
}

TEST_CASE("a run that is cancelled before there is anything says so", "[scene][run]") {
  const std::atomic<bool> cancelled{true};
  CHECK_THROWS_AS(run_scene(parse_scene(scene(), "."), {}, Progress(nullptr, &cancelled)), ResourceError);
}

TEST_CASE("an empty scene shows the sky exactly", "[scene][run]") {
  const RunResult result = run_scene(parse_scene(R"({"obscura": 1, "bands": [{"name": "grey"}],
    "environment": {"sky": {"radiance": 0.7}},
    "sensor": {"position_m": [0, -8, 0], "look_at_m": [0, 0, 0], "resolution": [8, 8]}})",
                                                 "."),
                                     {});
  for (const float value : result.image.channel("grey.radiance")) CHECK(value == 0.7f);
  CHECK(!result.image.has("grey.temperature"));
}

TEST_CASE("a scene without scattering stores no photons and still tells where its power goes", "[scene][run][energy]") {
  // A box of optical depth 2 along each axis: 4 pi k_a B V leave its voxels.
  const std::string text = R"({"obscura": 1, "bands": [{"name": "grey"}],
    "clouds": [{"grid": {"shape": "box", "size_m": [1, 1, 1], "voxel_m": 0.25}, "media": [{"extinction": 2}], "source": 3}],
    "sensor": {"position_m": [0, -5, 0], "look_at_m": [0, 0, 0], "resolution": [4, 4]}, "render": {"photons": 1000000}})";
  const Report report = run_scene(parse_scene(text, "."), {}).report;
  CHECK(report.photons.emitted == 65536);
  CHECK(report.photons.stored == 0);
  const EnergyReport& energy = report.energy.at(0).second;
  CHECK(energy.emitted_W == Approx(4 * kPi * 2 * 3).epsilon(1e-9));
  CHECK(energy.absorbed_W + energy.escaped_W == Approx(energy.emitted_W).epsilon(1e-9));
  CHECK(energy.absorbed_W > 0.1 * energy.emitted_W);
  CHECK(run_scene(parse_scene(text, ".", {{"/render/photons", "500", ""}}), {}).report.photons.emitted == 500);
}
