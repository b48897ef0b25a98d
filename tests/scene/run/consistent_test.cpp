// What a pixel says of itself agrees: radiance and transmission are of the same rays, what is too dark for the file is
// not taken for nothing, and powers have errors.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "octree/base/statistics.h"
#include "scene/file/scene_io.h"
#include "scene/run/run.h"

using namespace obscura;

namespace {

RunResult run(const std::string& text) { return run_scene(parse_scene(text, "."), {}); }

}  // namespace

TEST_CASE("radiance and transmission of a pixel are of the same rays", "[scene][run][consistent]") {
  // Of a cloud of one source S before a sky of radiance L the one tells the other: S (1 - T) + L T.
  for (const char* rays :
       {"", R"(, "max_oversampling": 1)", R"(, "antialiasing": {"polygons": 0}, "max_oversampling": 4)"}) {
    CAPTURE(rays);
    const Image image = run(R"({"obscura": 1, "bands": [{"name": "b"}],
      "clouds": [{"grid": {"shape": "gaussian", "sigma_m": 1, "size_m": [6, 6, 6], "voxel_m": 0.1},
        "media": [{"extinction": 1}], "source": 1.0}], "environment": {"sky": {"radiance": 0.2}},
      "sensor": {"position_m": [0, -20, 0], "look_at_m": [0, 0, 0], "fov_deg": 16, "resolution": [48, 36])" +
                            std::string(rays) + "}}")
                            .image;
    const auto radiance = image.channel("b.radiance"), transmission = image.channel("b.transmission");
    double worst = 0;
    for (std::size_t p = 0; p < radiance.size(); ++p) {
      CHECK((transmission[p] >= 0 && transmission[p] <= 1));
      worst = std::max(worst, std::abs(radiance[p] - (1 - 0.8 * transmission[p])));
    }
    CHECK(worst < 1e-5);
  }
}

TEST_CASE("what is darker than float32 holds is not nothing", "[scene][run][consistent]") {
  const auto cold = [](double body_K, double sky_K) {
    return run(R"({"obscura": 1, "bands": [{"name": "lwir", "um": [8, 12]}], "objects": [{"shape": "sphere",
      "radius_m": 1, "K": )" +
               std::to_string(body_K) + R"(}], "environment": {"sky": {"K": )" + std::to_string(sky_K) +
               R"(}}, "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "resolution": [9, 7]}})");
  };
  const float least = std::numeric_limits<float>::min();
  const std::size_t middle = 3 * 9 + 4;
  const RunResult five = cold(5, 4);
  for (const std::size_t p : {std::size_t{0}, middle}) {
    CHECK(five.image.channel("lwir.radiance")[p] == 0);
    CHECK(five.image.channel("lwir.error")[p] == least);
    CHECK(five.image.channel("lwir.temperature")[p] == 0);
  }
  bool warned = false;
  for (const std::string& warning : five.report.warnings)
    warned = warned || warning.find("darker than an image can hold") != std::string::npos;
  CHECK(warned);
  // Of 30 K there is something to be held.
  const RunResult thirty = cold(30, 4);
  CHECK(thirty.image.channel("lwir.radiance")[middle] > 0);
  CHECK(thirty.image.channel("lwir.temperature")[middle] == Approx(30).margin(0.01));
  // Where there is nothing at all 0 is exact.
  const RunResult nothing = run(R"({"obscura": 1, "bands": [{"name": "lwir", "um": [8, 12]}],
    "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "resolution": [9, 7]}})");
  CHECK(nothing.image.channel("lwir.radiance")[0] == 0);
  CHECK(nothing.image.channel("lwir.error")[0] == 0);
}

TEST_CASE("powers of a report have standard errors that their scatter confirms", "[scene][run][consistent]") {
  Moments absorbed, escaped, claimed_absorbed, claimed_escaped;
  for (int seed = 1; seed <= 60; ++seed) {
    const RunResult made = run(R"({"obscura": 1, "bands": [{"name": "b"}],
      "clouds": [{"grid": {"shape": "box", "size_m": [1, 1, 1], "voxel_m": 0.25},
        "media": [{"extinction": 2, "albedo": 0.7}]}],
      "environment": {"sun": {"toward": [0, 0, 1], "irradiance": 3}},
      "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "resolution": [2, 2]},
      "render": {"method": "photon", "final_gather": 0, "photons": 4000, "directions": "random", "seed": )" +
                               std::to_string(seed) + "}}");
    const EnergyReport& energy = made.report.energy.at(0).second;
    absorbed.add(energy.absorbed_W);
    escaped.add(energy.escaped_W);
    claimed_absorbed.add(energy.errors_W[1] * energy.errors_W[1]);
    claimed_escaped.add(energy.errors_W[3] * energy.errors_W[3]);
    CHECK(energy.errors_W[2] == 0);  // there are no surfaces
  }
  // A variance of 60 has a relative standard deviation of 0.18; each claim, of 16 batches, 0.37, and 60 of them 0.05.
  CHECK(claimed_absorbed.mean() == Approx(absorbed.variance()).epsilon(0.6));
  CHECK(claimed_escaped.mean() == Approx(escaped.variance()).epsilon(0.6));
}
