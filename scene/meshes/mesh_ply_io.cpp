// Stanford PLY, text and binary: positions, polygons and, where there is a property K, temperatures.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include "octree/base/error.h"
#include "scene/meshes/line_reader_io.h"
#include "scene/meshes/mesh_formats.h"

namespace obscura::detail {
namespace {

struct Type {
  const char* name;
  const char* other_name;
  std::size_t bytes;
  char kind;  // i: signed, u: unsigned, f: floating point
};
constexpr Type kTypes[] = {{"char", "int8", 1, 'i'},     {"uchar", "uint8", 1, 'u'},   {"short", "int16", 2, 'i'},
                           {"ushort", "uint16", 2, 'u'}, {"int", "int32", 4, 'i'},     {"uint", "uint32", 4, 'u'},
                           {"float", "float32", 4, 'f'}, {"double", "float64", 8, 'f'}};

struct Property {
  std::string name;
  const Type* type;
  const Type* count_type;  // of a list
};

struct Element {
  std::string name;
  std::uint64_t count;
  std::vector<Property> properties;

  std::optional<std::size_t> find(std::initializer_list<const char*> names) const {
    for (std::size_t i = 0; i < properties.size(); ++i) {
      if (std::find(names.begin(), names.end(), properties[i].name) != names.end()) return i;
    }
    return std::nullopt;
  }
};

template <class T>
double number_of(const unsigned char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

class PlyReader {
 public:
  explicit PlyReader(const std::filesystem::path& file) : file_(file), reader_(file), builder_(file) {}

  MeshFile read() {
    header();
    for (const Element& element : elements_) {
      if (element.name == "vertex") {
        vertices(element);
      } else if (element.name == "face") {
        faces(element);
      } else {
        for (row_ = 0; row_ < element.count; ++row_) row(element);
      }
    }
    std::string_view line;
    if (text_ && reader_.next_filled(line))
      reader_.fail("there is more than the header announces", "correct its counts or export the mesh anew");
    return builder_.finish();
  }

 private:
  void header() {
    std::string_view line;
    if (!reader_.next(line) || without_blanks(line) != "ply")
      reader_.fail("a PLY file begins with \"ply\"", "give a PLY file");
    bool has_format = false;
    while (true) {
      if (!reader_.next(line)) reader_.fail("the header has no end", "the file is cut off: copy or export it anew");
      const std::string_view whole = without_blanks(line);
      const std::string_view keyword = next_word(line);
      if (keyword == "end_header") break;
      if (keyword.empty() || keyword == "comment" || keyword == "obj_info") continue;
      if (keyword == "format") {
        const std::string_view format = next_word(line);
        has_format = true;
        text_ = format == "ascii";
        swap_ = format == (std::endian::native == std::endian::little ? "binary_big_endian" : "binary_little_endian");
        if (!text_ && format != "binary_big_endian" && format != "binary_little_endian") {
          reader_.fail(fmt::format("the format \"{:.40}\" is not known", format),
                       "export it as ascii or binary_little_endian");
        }
      } else if (keyword == "element") {
        const std::string_view name = next_word(line);
        std::int64_t count = -1;
        if (!to_number(next_word(line), count) || count < 0) bad_header(whole);
        for (const Element& other : elements_) {
          if (other.name == name)
            reader_.fail(fmt::format("the element {} is announced twice", name), "export the mesh anew");
        }
        elements_.push_back({std::string(name), static_cast<std::uint64_t>(count), {}});
      } else if (keyword == "property" && !elements_.empty()) {
        std::string_view word = next_word(line);
        const bool list = word == "list";
        Property property{{}, nullptr, nullptr};
        if (list) {
          property.count_type = type(next_word(line), whole);
          word = next_word(line);
        }
        property.type = type(word, whole);
        property.name = std::string(next_word(line));
        if (property.name.empty() || (list && property.count_type->kind == 'f')) bad_header(whole);
        elements_.back().properties.push_back(std::move(property));
      } else {
        bad_header(whole);
      }
    }
    if (!has_format) reader_.fail("the header names no format", "export the mesh anew");
  }

  [[noreturn]] void bad_header(std::string_view line) {
    reader_.fail(fmt::format("\"{:.40}\" does not belong in a PLY header", line), "export the mesh anew");
  }

  const Type* type(std::string_view name, std::string_view line) {
    for (const Type& type : kTypes) {
      if (name == type.name || name == type.other_name) return &type;
    }
    bad_header(line);
  }

  [[noreturn]] void fail(const std::string& problem, const std::string& hint) {
    if (text_) reader_.fail(problem, hint);
    throw InputError(file_.string(), fmt::format("{} {}: {}", element_, row_, problem), hint);
  }

  double number(const Type& type) {
    if (text_) {
      double value = 0;
      const std::string_view word = next_word(line_);
      if (word.empty()) fail(fmt::format("the {} has too few numbers", element_), "export the mesh anew");
      if (!to_number(word, value)) fail(fmt::format("\"{:.40}\" is no number", word), "export the mesh anew");
      return value;
    }
    unsigned char bytes[8];
    if (reader_.read(bytes, type.bytes) < type.bytes)
      fail("the file ends here", "it is cut off: copy or export it anew");
    if (swap_) std::reverse(bytes, bytes + type.bytes);
    switch (type.bytes) {
      case 1:
        return type.kind == 'i' ? number_of<std::int8_t>(bytes) : number_of<std::uint8_t>(bytes);
      case 2:
        return type.kind == 'i' ? number_of<std::int16_t>(bytes) : number_of<std::uint16_t>(bytes);
      case 8:
        return number_of<double>(bytes);
      default:
        break;
    }
    if (type.kind == 'f') return number_of<float>(bytes);
    return type.kind == 'i' ? number_of<std::int32_t>(bytes) : number_of<std::uint32_t>(bytes);
  }

  // Reads one vertex, face or other element: single numbers to values_, the numbers of lists to lists_, by property.
  void row(const Element& element) {
    element_ = element.name;
    if (text_ && !reader_.next_filled(line_))
      fail(fmt::format("the file ends at {} {} of {}", element_, row_, element.count),
           "it is cut off: copy or export it anew");
    values_.clear();
    lists_.resize(element.properties.size());
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const Property& property = element.properties[i];
      if (!property.count_type) {
        values_.push_back(number(*property.type));
        continue;
      }
      values_.push_back(0);
      const double count = number(*property.count_type);
      if (!(count >= 0) || count != std::floor(count) || count > 1e9)
        fail(fmt::format("a list of {:g}", count), "export the mesh anew");
      lists_[i].clear();
      for (double k = 0; k < count; ++k) lists_[i].push_back(number(*property.type));
    }
    if (text_ && !without_blanks(line_).empty())
      fail(fmt::format("the {} has too many numbers", element_), "export the mesh anew");
  }

  float kelvin(double value) {
    if (!(value >= 0) || !std::isfinite(value))
      fail(fmt::format("{:g} is no temperature", value), "K is kelvin of at least 0");
    return static_cast<float>(value);
  }

  void vertices(const Element& element) {
    const auto x = element.find({"x"}), y = element.find({"y"}), z = element.find({"z"}), K = element.find({"K"});
    if (!x || !y || !z) throw InputError(file_.string(), "its vertices have no x, y and z", "export the mesh anew");
    for (row_ = 0; row_ < element.count; ++row_) {
      row(element);
      const Vec3d position(values_[*x], values_[*y], values_[*z]);
      if (const char* bad = bad_coordinate(position); *bad)
        fail(fmt::format("{} is not finite", bad), "export the mesh anew without NaN and infinity");
      builder_.vertex(position);
      if (K) builder_.vertex_K(kelvin(values_[*K]));
    }
  }

  void faces(const Element& element) {
    const auto corners = element.find({"vertex_indices", "vertex_index"}), K = element.find({"K"});
    if (!corners || !element.properties[*corners].count_type) {
      throw InputError(file_.string(), "its faces have no list vertex_indices", "export the mesh anew");
    }
    const auto count = static_cast<double>(builder_.vertex_count());
    std::vector<std::uint32_t> polygon;
    for (row_ = 0; row_ < element.count; ++row_) {
      row(element);
      polygon.clear();
      for (const double index : lists_[*corners]) {
        if (!(index >= 0) || !(index < count) || index != std::floor(index)) {
          fail(fmt::format("the face names vertex {:.15g}, but there are {}", index, builder_.vertex_count()),
               "vertices are numbered from 0 and stand before faces; export the mesh anew");
        }
        polygon.push_back(static_cast<std::uint32_t>(index));
      }
      if (polygon.size() < 3)
        fail(fmt::format("the face has {} of at least three corners", polygon.size()), "export the mesh anew");
      builder_.polygon(polygon);
      if (K) builder_.polygon_K(kelvin(values_[*K]));
    }
  }

  std::filesystem::path file_;
  LineReader reader_;
  MeshBuilder builder_;
  std::vector<Element> elements_;
  bool text_ = true;
  bool swap_ = false;
  std::string element_;
  std::uint64_t row_ = 0;
  std::string_view line_;
  std::vector<double> values_;
  std::vector<std::vector<double>> lists_;
};

}  // namespace

MeshFile read_ply(const std::filesystem::path& file) { return PlyReader(file).read(); }

}  // namespace obscura::detail
