// Wavefront OBJ: positions and polygons with their groups and materials.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "scene/meshes/line_reader_io.h"
#include "scene/meshes/mesh_formats.h"

namespace obscura::detail {
namespace {

/// Lines that say nothing about positions and faces.
constexpr std::array kIgnored = {"vt",    "vn",       "vp",       "s",      "l",      "p",          "mtllib",
                                 "mg",    "lod",      "bevel",    "maplib", "usemap", "shadow_obj", "trace_obj",
                                 "ctech", "stech",    "cstype",   "deg",    "bmat",   "step",       "curv",
                                 "curv2", "parm",     "trim",     "hole",   "scrv",   "sp",         "end",
                                 "con",   "c_interp", "d_interp", "call",   "csh",    "scmp"};

class ObjReader {
 public:
  explicit ObjReader(const std::filesystem::path& file) : reader_(file), builder_(file) {}

  MeshFile read() {
    std::string_view line;
    while (next(line)) {
      const std::string_view keyword = next_word(line);
      if (keyword.empty() || keyword[0] == '#') continue;
      if (keyword == "v") {
        vertex(line);
      } else if (keyword == "f" || keyword == "fo") {
        face(line);
      } else if (keyword == "g" || keyword == "o" || keyword == "usemtl") {
        (keyword == "g" ? group_ : keyword == "o" ? object_ : material_) = std::string(without_blanks(line));
        renamed_ = true;
      } else if (keyword == "surf") {
        reader_.fail("free-form surfaces cannot be read", "export the mesh as polygons");
      } else if (std::find(kIgnored.begin(), kIgnored.end(), keyword) == kIgnored.end()) {
        reader_.fail(fmt::format("\"{:.20}\" does not begin a line of an OBJ file", keyword),
                     "export the mesh anew; it may be broken or of another kind");
      }
    }
    return builder_.finish();
  }

 private:
  // A line that ends in a backslash goes on in the next.
  bool next(std::string_view& line) {
    if (!reader_.next(line)) return false;
    if (line.empty() || line.back() != '\\') return true;
    joined_.clear();
    do {
      joined_.append(line.substr(0, line.size() - 1)) += ' ';
    } while (reader_.next(line) && !line.empty() && line.back() == '\\');
    joined_.append(line);
    line = joined_;
    return true;
  }

  void vertex(std::string_view line) {
    Vec3d position(0);
    for (int k = 0; k < 3; ++k) {
      const std::string_view word = next_word(line);
      if (!to_number(word, position[k])) {
        reader_.fail(word.empty() ? "a vertex has three coordinates" : fmt::format("\"{:.40}\" is no coordinate", word),
                     "a line is like v 1 2 3");
      }
    }
    if (const char* bad = bad_coordinate(position); *bad) {
      reader_.fail(fmt::format("{} is not finite", bad), "export the mesh anew without NaN and infinity");
    }
    builder_.vertex(position);
  }

  void face(std::string_view line) {
    corners_.clear();
    const auto count = static_cast<std::int64_t>(builder_.vertex_count());
    for (std::string_view word = next_word(line); !word.empty() && word[0] != '#'; word = next_word(line)) {
      std::int64_t index = 0;
      if (!to_number(word.substr(0, word.find('/')), index)) {
        reader_.fail(fmt::format("\"{:.40}\" is no corner of a face", word),
                     "a line is like f 1 2 3 or f 1/1/1 2/2/2 3/3/3");
      }
      const std::int64_t vertex = index < 0 ? count + index : index - 1;
      if (index == 0 || vertex < 0 || vertex >= count) {
        reader_.fail(fmt::format("the face names vertex {}, but there are {} before it", index, count),
                     "vertices are numbered from 1, or from -1 backwards; export the mesh anew");
      }
      corners_.push_back(static_cast<std::uint32_t>(vertex));
    }
    if (corners_.size() < 3) {
      reader_.fail(fmt::format("the face has {} of at least three corners", corners_.size()),
                   "export the mesh anew, or leave the line out");
    }
    if (renamed_) rename();
    builder_.polygon(corners_);
  }

  // A face may be in several groups; some write names with blanks, so the whole counts as a name too.
  void rename() {
    std::vector<std::string> names;
    const auto add = [&names](std::string_view name) {
      if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.emplace_back(name);
    };
    add(group_);
    std::string_view rest = group_;
    for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) add(word);
    add(object_);
    add(material_);
    builder_.names(names);
    renamed_ = false;
  }

  LineReader reader_;
  MeshBuilder builder_;
  std::string joined_;
  std::string group_, object_, material_;
  bool renamed_ = false;
  std::vector<std::uint32_t> corners_;
};

}  // namespace

MeshFile read_obj(const std::filesystem::path& file) { return ObjReader(file).read(); }

}  // namespace obscura::detail
