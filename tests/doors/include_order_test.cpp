// The folders are the layers, and rooms within them: a file includes its own room and those to its left, never to
// the right; every header stands alone; big libraries stay behind the files that are named for them.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>

#include "tests/support/places.h"

namespace fs = std::filesystem;

namespace {

constexpr std::array<const char*, 5> kLayers{"octree", "photon", "sensor", "scene", "tests"};

// The rooms of each layer, in the order in which they may include each other.
const std::map<std::string, std::vector<std::string>> kRooms{
    {"octree", {"base", "tree", "source", "build", "io"}},
    {"photon", {"optics", "world", "spot", "map", "trace", "paths", "ordinates", "methods", "limits"}},
    {"sensor", {"capture", "picture", "judge", "sight"}},
    {"scene",
     {"file", "meshes", "world", "plan", "session", "goal", "run", "page", "verify", "hiding", "study", "cli"}},
    {"tests", {}},
};

int layer_of(const std::string& path) {
  const std::string folder = path.substr(0, path.find('/'));
  const auto found = std::ranges::find(kLayers, folder);
  return found == kLayers.end() ? -1 : static_cast<int>(found - kLayers.begin());
}

// -1: a file that stands in none.
int room_of(const std::string& path) {
  const std::size_t layer = path.find('/'), room = path.find('/', layer + 1);
  if (room == std::string::npos) return -1;
  const std::vector<std::string>& rooms = kRooms.at(path.substr(0, layer));
  const auto found = std::ranges::find(rooms, path.substr(layer + 1, room - layer - 1));
  return found == rooms.end() ? -1 : static_cast<int>(found - rooms.begin());
}

// Path from the root to text, of every source and header.
using Sources = std::map<std::string, std::string>;

Sources read_sources() {
  Sources result;
  const fs::path root = obscura::test::source_file("");
  for (const char* layer : kLayers) {
    if (!fs::exists(root / layer)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / layer)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".h" && extension != ".cpp") continue;
      std::ostringstream text;
      text << std::ifstream(entry.path()).rdbuf();
      result[fs::relative(entry.path(), root).generic_string()] = text.str();
    }
  }
  return result;
}

// The first group of the pattern, of each line that has it.
std::vector<std::string> matches(const std::string& text, const char* pattern) {
  const std::regex regex(pattern);
  std::vector<std::string> result;
  std::istringstream lines(text);
  std::smatch match;
  for (std::string line; std::getline(lines, line);) {
    if (std::regex_search(line, match, regex)) result.push_back(match[1]);
  }
  return result;
}

std::vector<std::string> included_files(const std::string& text) {
  return matches(text, R"re(^\s*#\s*include\s*"([^"]+)")re");
}

std::vector<std::string> included_libraries(const std::string& text) {
  return matches(text, R"re(^\s*#\s*include\s*<([^>]+)>)re");
}

std::vector<std::string> wrong_includes(const Sources& sources) {
  std::vector<std::string> wrong;
  for (const auto& [path, text] : sources) {
    if (layer_of(path) < 4 && room_of(path) < 0) wrong.push_back(path + ": stands in no room");
    for (const std::string& included : included_files(text)) {
      if (included.starts_with("hwy/")) continue;  // Highway's own, quoted as its manual asks
      const std::string line = path + " includes " + included;
      // From the root, or beside the file that includes it.
      const std::string beside = (fs::path(path).parent_path() / included).lexically_normal().generic_string();
      const std::string target = sources.count(beside) > 0 ? beside : included;
      if (sources.count(target) == 0) {
        wrong.push_back(line + ": there is no such file");
      } else if (layer_of(target) > layer_of(path)) {
        wrong.push_back(line + ": to the right");
      } else if (layer_of(target) == layer_of(path) && room_of(target) > room_of(path)) {
        wrong.push_back(line + ": to a room on the right");
      }
    }
  }
  return wrong;
}

// Libraries that only some files may know: their headers cost seconds, or they open files.
std::vector<std::string> wrong_libraries(const Sources& sources) {
  std::vector<std::string> wrong;
  for (const auto& [path, text] : sources) {
    if (path.starts_with("tests/")) continue;
    for (const std::string& included : included_libraries(text)) {
      const auto behind = [&](const char* library, bool allowed) {
        if (included.starts_with(library) && !allowed) {
          wrong.push_back(path + " includes <" + included + ">");
        }
      };
      behind("OpenImageIO/", path == "sensor/picture/image_io.cpp");
      behind("openvdb/", path.starts_with("octree/") && path.ends_with("_io.cpp"));
      behind("netcdf", path.starts_with("octree/") && path.ends_with("_io.cpp"));
      behind("CLI/", path.starts_with("scene/cli/"));
      behind("nlohmann/", path.starts_with("scene/") || path.ends_with("_io.cpp"));
      behind("catch2/", false);
      behind("random", false);
    }
  }
  return wrong;
}

std::vector<std::string> virtuals(const Sources& sources) {
  std::vector<std::string> wrong;
  for (const auto& [path, text] : sources) {
    if (layer_of(path) > 1) continue;
    if (!matches(text, R"re(^[^/"]*\b(virtual)\b)re").empty()) wrong.push_back(path);
  }
  return wrong;
}

}  // namespace

TEST_CASE("a file includes its own layer and those to its left, never to the right", "[doors][includes]") {
  const Sources sources = read_sources();
  REQUIRE(sources.size() > 50);
  CHECK(wrong_includes(sources) == std::vector<std::string>{});

  // Twins: each kind of mistake is seen.
  const auto mistakes = [&](const char* path, const std::string& text) {
    Sources planted = sources;
    planted[path] = text;
    return wrong_includes(planted).size() - wrong_includes(sources).size();
  };
  CHECK(mistakes("octree/tree/planted.h", "#include \"photon/optics/band.h\"\n") == 1);
  CHECK(mistakes("photon/map/planted.cpp", "  # include \"sensor/capture/film.h\"\n") == 1);
  CHECK(mistakes("scene/cli/planted.cpp", "#include \"tests/support/agree.h\"\n") == 1);
  CHECK(mistakes("sensor/capture/planted.cpp", "#include \"../../scene/file/description.h\"\n") == 1);
  CHECK(mistakes("sensor/capture/planted.cpp", "#include \"film.h\"\n") == 0);
  CHECK(mistakes("sensor/capture/planted.cpp", "#include \"sensor/capture/filn.h\"\n") == 1);
  CHECK(mistakes("scene/run/planted.cpp", "#include \"octree/base/math.h\"\n#include <map>\n") == 0);
  CHECK(mistakes("sensor/planted.cpp", "#include <map>\n") == 1);
  CHECK(mistakes("sensor/attic/planted.cpp", "#include <map>\n") == 1);
  CHECK(mistakes("octree/base/planted.h", "#include \"octree/tree/octree.h\"\n") == 1);
  CHECK(mistakes("photon/trace/planted.h", "#include \"../paths/radiance.h\"\n") == 1);
  CHECK(mistakes("photon/paths/planted.h", "#include \"photon/trace/light.h\"\n") == 0);
}

TEST_CASE("big libraries stay behind the files that are named for them", "[doors][includes]") {
  Sources sources = read_sources();
  CHECK(wrong_libraries(sources) == std::vector<std::string>{});
  sources = {{"sensor/planted.cpp", "#include <OpenImageIO/imageio.h>\n"},
             {"photon/planted.cpp", "#include <openvdb/openvdb.h>\n"},
             {"octree/planted.cpp", "#include <random>\n"}};
  CHECK(wrong_libraries(sources).size() == 3);
}

TEST_CASE("octree and photon know no virtual function", "[doors][includes]") {
  CHECK(virtuals(read_sources()) == std::vector<std::string>{});
  CHECK(virtuals({{"octree/planted.h", "struct A {\n  virtual void f();\n};\n"}}).size() == 1);
  CHECK(virtuals({{"octree/planted.h", "// no virtual here\n"}}).empty());
}

TEST_CASE("public headers compile, each alone and all in one file", "[doors][includes]") {
  if (std::system("c++ --version > /dev/null 2>&1") != 0) {
    WARN("SKIPPED: no compiler is on the path");
    return;
  }
  std::vector<std::string> headers;
  for (const auto& [path, text] : read_sources()) {
    // Those end in -inl.h that only their own .cpp files include: Highway's, once per target, and Embree's scene.
    if (path.ends_with(".h") && layer_of(path) < 4 && !path.ends_with("-inl.h")) headers.push_back(path);
  }
  const auto compiles = [](const std::vector<std::string>& included, const std::string& after = {}) {
    std::string text;
    for (const std::string& header : included) text += "#include \"" + header + "\"\n";
    const std::string command = "printf '%s' '" + text + after + "' | c++ -std=c++20 -fsyntax-only -x c++ -I'" +
                                obscura::test::source_file(".") + "' -isystem /usr/include/Imath - > /dev/null 2>&1";
    return std::system(command.c_str()) == 0;
  };
  std::vector<char> good(headers.size());
  tbb::parallel_for(std::size_t{0}, headers.size(), [&](std::size_t i) { good[i] = compiles({headers[i]}); });
  for (std::size_t i = 0; i < headers.size(); ++i) {
    INFO(headers[i]);
    CHECK(good[i]);
  }
  CHECK(!compiles({"octree/no_such_header.h"}));

  // What an installed library offers may be included together: no name stands for two things.
  std::erase_if(headers, [](const std::string& path) { return path.starts_with("scene/cli/"); });
  CHECK(compiles(headers));
  CHECK(!compiles(headers, "namespace obscura { struct HalfSpace {}; }\n"));
}
