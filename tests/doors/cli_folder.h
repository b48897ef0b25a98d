// A folder with a scene for the program to work on, and a look at what it said.
#pragma once

#include <sstream>
#include <string>

#include "tests/scene/full_scene.h"
#include "tests/support/run_program.h"

namespace obscura::test {

inline constexpr const char* kScene = R"({
  // a comment
  "obscura": 1,
  "bands": [{"name": "lwir", "um": [8, 12]}],
  "clouds": [{"grid": {"shape": "sphere", "radius_m": 1, "voxel_m": 0.25},
              "media": [{"extinction": 1, "albedo": 0.5}], "temperature": {"K": 300}}],
  "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "resolution": [8, 6], "max_oversampling": 2},
  "render": {"photons": 1000}
})";

struct Folder : SceneFolder {
  explicit Folder(const std::string& name) : SceneFolder("cli_" + name) { write("scene.json", kScene); }
  std::string file(const std::string& name) const { return (path() / name).string(); }
};

inline long lines_with(const std::string& text, const std::string& part) {
  std::istringstream stream(text);
  long count = 0;
  for (std::string line; std::getline(stream, line);) count += contains(line, part) ? 1 : 0;
  return count;
}

}  // namespace obscura::test
