// A sun on the horizon of clouds that repeat: half of its disc is up, and lights them.
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "octree/base/error.h"
#include "photon/trace/emission.h"
#include "scene/file/scene_io.h"
#include "scene/run/run.h"
#include "scene/session/session.h"

using namespace obscura;

namespace {

std::string scene(double zenith_deg, double diameter_deg, const std::string& render) {
  return R"({"obscura": 1, "bands": [{"name": "b"}], "clouds": [{"grid": {"shape": "box", "size_m": [1, 1, 1],
      "voxel_m": 0.25}, "media": [{"extinction": 5, "albedo": 0.99}], "periodic": ["x", "y"]}],
      "environment": {"sun": {"zenith_deg": )" +
         std::to_string(zenith_deg) + R"(, "azimuth_deg": 90, "diameter_deg": )" + std::to_string(diameter_deg) +
         R"(, "irradiance": 1000}},
      "sensor": {"position_m": [0, 0, 5], "look_at_m": [0, 0, 0], "up": [0, 1, 0], "projection": "orthographic",
        "width_m": 1, "resolution": [16, 16], "max_oversampling": 4}, "render": {)" +
         render + "}}";
}

/// The picture's mean and, as its pixels' paths and photons are independent enough here, a bound of its error.
std::pair<double, double> shown(const std::string& text) {
  const Image image = run_scene(parse_scene(text, "."), {}).image;
  double sum = 0, squares = 0;
  for (const float value : image.channel("b.radiance")) sum += value;
  for (const float error : image.channel("b.error")) squares += error * error;
  return {sum / 256, std::sqrt(squares) / 256};
}

}  // namespace

TEST_CASE("half of a sun on the horizon lights clouds that repeat", "[stability][horizon]") {
  // Its light on the faces: E times the mean of |cosine| over the disc, 4 / (3 pi) of the disc's half angle.
  Session session(parse_scene(scene(90, 0.533, ""), "."), 0);
  const double half = std::sin(0.5 * 0.533 * kPi / 180);
  CHECK(PhotonEmitter({session.world(), 0}).power() == Approx(1000 * half * 4 / (3 * kPi)).epsilon(1e-3));
  // Well above it the whole disc counts, as its centre does.
  Session high(parse_scene(scene(60, 0.533, ""), "."), 0);
  CHECK(PhotonEmitter({high.world(), 0}).power() == Approx(500).epsilon(1e-4));

  for (const double zenith_deg : {89.85, 90.0, 90.1}) {
    CAPTURE(zenith_deg);
    const auto [path, path_error] = shown(scene(zenith_deg, 0.533, R"("method": "path", "samples": 512)"));
    for (const char* method : {R"("method": "photon", "photons": 100000, "final_gather": 1, "samples": 256)",
                               R"("method": "photon", "photons": 200000, "final_gather": 0)"}) {
      const auto [photon, photon_error] = shown(scene(zenith_deg, 0.533, method));
      CAPTURE(method, path, photon, path_error, photon_error);
      // Pixels of a map share their photons: 256 of them know their mean a few times worse than independent ones.
      CHECK(std::abs(photon - path) < 4 * std::hypot(path_error, 3 * photon_error));
      CHECK(std::abs(photon - path) < 0.3 * path);  // without the light from below or above it would be half
    }
    if (zenith_deg == 90) CHECK(path == Approx(0.217).margin(0.004 + 3 * path_error));
  }
  // Its light would have to be followed for ever: the ordinates say so.
  CHECK_THROWS_WITH(run_scene(parse_scene(scene(90, 0.533, R"("method": "ordinates")"), "."), {}),
                    Catch::Contains("on the horizon"));
}
