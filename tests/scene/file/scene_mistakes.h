// What is said of scenes with mistakes, and the smallest scene that has none.
#pragma once

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "octree/base/error.h"
#include "scene/file/scene_io.h"
#include "tests/scene/full_scene.h"

namespace obscura::test {

inline constexpr const char* kSmallest = R"({
  "obscura": 1,
  "bands": [{"name": "lwir", "um": [8, 12]}],
  "sensor": {"position_m": [0, -10, 1], "look_at_m": [0, 0, 1]}
})";

inline std::vector<Problem> problems_of(const std::string& text, const std::filesystem::path& folder = ".") {
  try {
    parse_scene(text, folder);
    return {};
  } catch (const InputError& error) {
    return error.problems();
  }
}

inline std::string text_of(const std::vector<Problem>& problems) {
  std::string text;
  for (const Problem& p : problems) text += p.text() + "\n";
  return text;
}

inline bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// One change to a scene, the pointer of its only problem and words of the message.
struct Mistake {
  std::string pointer;
  Json value;
  std::string where;
  std::string says;
};

inline void check_mistakes(const Json& scene, const std::filesystem::path& folder,
                           const std::vector<Mistake>& mistakes) {
  for (const Mistake& m : mistakes) {
    Json changed = scene;
    changed[Json::json_pointer(m.pointer)] = m.value;
    const auto problems = problems_of(changed.dump(), folder);
    INFO(m.pointer << " = " << m.value.dump() << "\n" << text_of(problems));
    REQUIRE(problems.size() == 1);
    CHECK(problems[0].where == m.where);
    CHECK(has(problems[0].text(), m.says));
    CHECK_FALSE(problems[0].hint.empty());
  }
}

}  // namespace obscura::test
