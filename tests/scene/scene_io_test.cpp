#include <catch2/catch.hpp>

#include "octree/base/error.h"
#include "scene/scene_io.h"

using namespace obscura;

namespace {

const char* const kSmallest = R"({
  "obscura": 1,
  "bands": [{"name": "lwir", "um": [8, 12]}],
  "sensor": {"position_m": [0, -10, 1], "look_at_m": [0, 0, 1]}
})";

}  // namespace

TEST_CASE("the smallest scene holds the defaults", "[scene][reader]") {
  const Description scene = parse_scene(kSmallest, ".");
  CHECK(scene.bands.size() == 1);
  CHECK(scene.render.photons == 1000000);
  CHECK(scene.sensor.resolution == std::array<int, 2>{320, 240});
  CHECK(scene.warnings.empty());
}

TEST_CASE("six mistakes give six messages, each with pointer, problem and remedy", "[scene][reader]") {
  const char* const text = R"({
    "obscura": 1,
    "bands": [{"name": "lwir", "um": [12, 8]}],
    "clouds": [{"grid": {"file": "absent.vdb"}, "media": [{"density": "density", "extinction": -1}]}],
    "sensor": {"position_m": [0, -10, 1], "look_at_m": [0, 0], "fov": 20},
    "render": {"photons": "many"}
  })";
  try {
    parse_scene(text, ".");
    FAIL("the scene was accepted");
  } catch (const InputError& error) {
    INFO(error.what());
    CHECK(error.problems().size() == 6);
    for (const Problem& p : error.problems()) {
      CHECK(p.where[0] == '/');
      CHECK_FALSE(p.problem.empty());
      CHECK_FALSE(p.hint.empty());
    }
  }
}
