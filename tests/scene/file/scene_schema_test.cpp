#include "scene/file/scene_schema.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <functional>
#include <set>
#include <sstream>

#include "octree/base/error.h"
#include "scene/file/scene_io.h"
#include "tests/scene/full_scene.h"
#include "tests/support/json_schema.h"
#include "tests/support/places.h"

using namespace obscura;
using obscura::test::Json;

namespace {

// Every JSON pointer of a document's members and elements.
void collect(const Json& value, const Json::json_pointer& at, std::vector<Json::json_pointer>& pointers) {
  if (!at.empty()) pointers.push_back(at);
  if (value.is_object()) {
    for (const auto& [key, member] : value.items()) collect(member, at / key, pointers);
  } else if (value.is_array()) {
    for (std::size_t i = 0; i < value.size(); ++i) collect(value[i], at / i, pointers);
  }
}

// The keys that a schema names anywhere, below "properties".
void collect_keys(const Json& schema, std::set<std::string>& keys) {
  if (schema.is_array()) {
    for (const Json& element : schema) collect_keys(element, keys);
  } else if (schema.is_object()) {
    for (const auto& [keyword, rule] : schema.items()) {
      if (keyword == "default" || keyword == "enum") continue;
      if (keyword == "properties") {
        for (const auto& [key, sub] : rule.items()) {
          keys.insert(key);
          collect_keys(sub, keys);
        }
      } else {
        collect_keys(rule, keys);
      }
    }
  }
}

// Refusals that only the reader can know of.
bool is_about_meaning(const std::string& text) {
  for (const char* phrase :
       {"is missing",           "cannot be read",      "by its extension", "is parallel",          "no length",
        "have to increase",     "its own position",    "per angle",        "phase function",       "wavelengths but",
        "periods for",          "no axis is periodic", "neither",          "there is no material", "there is no band",
        "angles but",           "perspective camera",  "voxels",           "response is 0",        "control characters",
        "are both given",       "grey band",           "no grid",          "angles do not go",     "seed: 1e+30",
        "band has temperatures"}) {
    if (text.find(phrase) != std::string::npos) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("the published schema is the one that the reader's keys make", "[scene][schema]") {
  std::ifstream stream(test::source_file("scene/scene.schema.json"));
  std::ostringstream text;
  text << stream.rdbuf();
  INFO("write it anew with: obscura schema > scene/scene.schema.json");
  CHECK((text.str() == scene_schema()));
}

TEST_CASE("the test's scenes hold every key of the schema", "[scene][schema]") {
  std::set<std::string> keys, used;
  collect_keys(Json::parse(scene_schema()), keys);
  std::function<void(const Json&)> use = [&](const Json& value) {
    if (value.is_object()) {
      for (const auto& [key, member] : value.items()) {
        used.insert(key);
        use(member);
      }
    } else if (value.is_array()) {
      for (const Json& element : value) use(element);
    }
  };
  for (const Json& scene : test::all_scenes()) use(scene);
  for (const std::string& key : keys) {
    INFO(key);
    CHECK(used.count(key) == 1);
  }
}

TEST_CASE("schema and reader accept and refuse the same values at every key", "[scene][schema]") {
  const test::SceneFolder folder("schema_test");
  const Json schema = Json::parse(scene_schema());
  const std::vector<Json> values = {nullptr,
                                    true,
                                    "zzz",
                                    "",
                                    -1,
                                    0,
                                    0.5,
                                    3,
                                    1e30,
                                    Json::array(),
                                    Json::object(),
                                    Json::array({1, 2}),
                                    Json::array({1, 2, 3}),
                                    Json::parse(R"({"zzz": 1})"),
                                    Json::array({"zzz"})};
  std::string details;
  int disagreements = 0, refused = 0, accepted = 0;
  for (const Json& scene : test::all_scenes()) {
    REQUIRE(test::validates(schema, scene));
    REQUIRE_NOTHROW(parse_scene(scene.dump(), folder.path()));
    std::vector<Json::json_pointer> pointers;
    collect(scene, Json::json_pointer(""), pointers);
    for (const auto& pointer : pointers) {
      for (const Json& value : values) {
        Json changed = scene;
        changed[pointer] = value;
        const bool by_schema = test::validates(schema, changed);
        bool by_reader = true;
        std::string why;
        try {
          parse_scene(changed.dump(), folder.path());
        } catch (const InputError& error) {
          why = error.what();
          by_reader = false;
        }
        (by_reader ? accepted : refused) += 1;
        // What the schema refuses, the reader refuses, and says where.
        const bool somewhere = by_reader || why.find(pointer.parent_pointer().to_string()) != std::string::npos;
        // The reader also knows files, directions and grey bands.
        const bool agree = by_schema == by_reader || (by_schema && is_about_meaning(why));
        if (!agree || (!by_schema && !somewhere)) {
          ++disagreements;
          details += pointer.to_string() + " = " + value.dump() + (by_schema ? ": only" : ": not") +
                     " the schema accepts it; " + why + "\n";
        }
      }
    }
  }
  INFO(details);
  CHECK(disagreements == 0);
  CHECK(accepted > 100);
  CHECK(refused > 1000);
}
