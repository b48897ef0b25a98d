// What a pixel shows is judged by that pixel: faint things beside bright ones are not left out, and what is left out
// stands in the error of the pixels that it touches.
#include <catch2/catch.hpp>
#include <cmath>

#include "scene/file/scene_io.h"
#include "scene/run/run.h"

using namespace obscura;

namespace {

RunResult run(const std::string& text) { return run_scene(parse_scene(text, "."), {}); }

/// Smoke left, a flare right, the sky above them: 25 x 15 pixels.
std::string flare_scene(double flare_K, double smoke_K, const char* band_um, const std::string& render) {
  return R"({"obscura": 1, "bands": [{"name": "b", "um": )" + std::string(band_um) +
         R"(}], "clouds": [{"grid": {"shape": "sphere", "radius_m": 1, "voxel_m": 0.2}, "media": [{"extinction": 4}],
           "temperature": {"K": )" +
         std::to_string(smoke_K) +
         R"(}, "place": {"translate_m": [-1.2, 0, 0]}}],
           "sources": [{"position_m": [1.2, 0, 0], "radius_m": 0.3, "K": )" +
         std::to_string(flare_K) + R"(}], "environment": {"sky": {"K": 220}},
           "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "fov_deg": 30, "resolution": [25, 15]},
           "render": {)" +
         render + "}}";
}

double planck(const char* band_um, double K) {
  const bool mid = std::string(band_um) == "[3, 5]";
  return Band("b", mid ? 3 : 8, mid ? 5 : 12, 1, Spectrum::constant(1)).planck(K);
}

}  // namespace

TEST_CASE("a flare does not switch the sky off, nor the smoke beside it", "[scene][run][faint]") {
  for (const char* band : {"[3, 5]", "[8, 12]"}) {
    for (const double flare_K : {800.0, 2500.0, 3300.0}) {
      for (const double smoke_K : {260.0, 290.0}) {
        for (const char* method : {"", R"("method": "path")", R"("method": "photon", "photons": 10000)"}) {
          CAPTURE(band, flare_K, smoke_K, method);
          const Image image = run(flare_scene(flare_K, smoke_K, band, method)).image;
          const auto radiance = image.channel("b.radiance"), kelvin = image.channel("b.temperature"),
                     error = image.channel("b.error");
          // The sky is known exactly; the smoke of depth 8 hides it to 3e-4.
          for (const std::size_t corner : {std::size_t{0}, std::size_t{24}}) {
            CHECK(radiance[corner] == Approx(planck(band, 220)).epsilon(1e-6));
            CHECK(kelvin[corner] == Approx(220).margin(0.01));
            CHECK(error[corner] <= 1e-6 * radiance[corner]);
          }
          const std::size_t smoke = 7 * 25 + 6;
          CHECK(kelvin[smoke] == Approx(smoke_K).margin(0.1));
          CHECK(std::abs(radiance[smoke] - planck(band, smoke_K)) < 1.96 * error[smoke] + 1e-3 * radiance[smoke]);
          for (std::size_t p = 0; p < radiance.size(); ++p) REQUIRE(radiance[p] > 0);
        }
      }
    }
  }
}

TEST_CASE("what was left out stands in the error of the pixels that it touches", "[scene][run][faint]") {
  // A cloud that emits so little that it is left out, and kept where that is forced.
  const auto scene = [](const std::string& render) {
    return R"({"obscura": 1, "bands": [{"name": "b"}],
      "clouds": [{"grid": {"shape": "box", "size_m": [2, 2, 2], "voxel_m": 0.5}, "media": [{"extinction": 2e-5}],
        "source": 0.5}], "environment": {"sky": {"radiance": 1}},
      "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "fov_deg": 40, "resolution": [33, 25]},
      "render": {"method": "path")" +
           render + "}}";
  };
  const RunResult left_out = run(scene(""));
  const RunResult kept = run(scene(R"(, "effects": {"emission": true})"));
  const auto radiance = left_out.image.channel("b.radiance"), truth = kept.image.channel("b.radiance"),
             error = left_out.image.channel("b.error"), depth = left_out.image.channel("b.transmission");
  double most = 0;
  for (std::size_t p = 0; p < radiance.size(); ++p) {
    // 0.5 times a depth of 4e-5 straight through, 7e-5 along a diagonal.
    const double off = std::abs(radiance[p] - truth[p]);
    most = std::max(most, off);
    CHECK(off <= 1.96 * error[p] + 1e-6);
    if (depth[p] < 1) CHECK(error[p] > 0.5 * 4e-5 / 1.96);
    if (depth[p] == 1 && p % 33 == 32) CHECK(error[p] == 0);  // nowhere near the cloud
    CHECK(error[p] < 0.01);
  }
  CHECK(most > 1e-5);
}

TEST_CASE("the floor says below which radiance of a grey band nothing matters", "[scene][run][faint]") {
  // A sky of a thousandth behind a lamp: by itself it is all that its pixels show.
  const auto sky = [](const std::string& floor) {
    const RunResult made = run(R"({"obscura": 1, "bands": [{"name": "b"}], "environment": {"sky": {"radiance": 1e-3}},
      "sources": [{"position_m": [0, 0, 0], "radius_m": 1, "radiance": 100}],
      "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "resolution": [9, 7]}, "render": {)" +
                               floor + "}}");
    return std::pair(made.image.channel("b.radiance")[0], made.image.channel("b.error")[0]);
  };
  CHECK(sky("").first == Approx(1e-3));
  CHECK(sky(R"("floor": 1)").first == Approx(1e-3));
  const auto [radiance, error] = sky(R"("floor": 100)");
  CHECK(radiance == 0);
  CHECK(1.96 * error >= 1e-3 * (1 - 1e-6));
  // A pixel of radiance 0 whose error is 0 shows nothing.
  CHECK(sky(R"("floor": 100)").second > 0);
}

TEST_CASE("a target in kelvin holds for 95 of 100 pixels", "[scene][run][accuracy]") {
  const auto scene = [](const std::string& render) {
    return R"({"obscura": 1, "bands": [{"name": "lwir", "um": [8, 12]}, {"name": "nir", "um": [1, 2]}],
      "clouds": [{"grid": {"shape": "gaussian", "sigma_m": 1, "size_m": [6, 6, 6], "voxel_m": 0.25},
                  "media": [{"extinction": 1.5, "albedo": 0.6}], "temperature": {"K": 310}}],
      "environment": {"sky": {"K": 240}},
      "sensor": {"position_m": [0, -20, 2], "look_at_m": [0, 0, 0], "fov_deg": 20, "resolution": [24, 20],
                 "max_oversampling": 4},
      "render": {"method": "path", )" +
           render + "}}";
  };
  const RunResult truth = run(scene(R"("seed": 9, "target_error": "300mK")"));
  REQUIRE(truth.report.accuracy);
  CHECK(truth.report.accuracy->unit == "K");
  for (const double target : {3.0, 1.5}) {
    const RunResult made = run(scene("\"target_error\": \"" + std::to_string(target) + "K\""));
    REQUIRE(made.report.accuracy);
    CHECK(made.report.accuracy->reached);
    CHECK(made.report.accuracy->interval[1] <= target);
    const auto kelvin = made.image.channel("lwir.temperature"), right = truth.image.channel("lwir.temperature");
    double within = 0, square = 0;
    for (std::size_t p = 0; p < kelvin.size(); ++p) {
      within += std::abs(kelvin[p] - right[p]) < target;
      square += (kelvin[p] - right[p]) * (kelvin[p] - right[p]);
    }
    // Nearly all of the pixels are within the half-width that 95 of 100 have, and it is no luxury.
    CHECK(within / static_cast<double>(kelvin.size()) > 0.95);
    CHECK(std::sqrt(square / static_cast<double>(kelvin.size())) > 0.1 * target);
  }
  CHECK_THROWS_WITH(parse_scene(R"({"obscura": 1, "bands": [{"name": "nir", "um": [1, 2]}],
      "sensor": {"position_m": [0, -1, 0], "look_at_m": [0, 0, 0]}, "render": {"target_error": "20mK"}})",
                                "."),
                    Catch::Contains("/render/target_error") && Catch::Contains("2.5 um"));
}
