#include "scene/file/scene_table_io.h"

#include <fmt/format.h>

#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>
#include <system_error>

#include "octree/base/error.h"
#include "scene/file/scene_json.h"

namespace obscura::detail {
namespace {

std::string trimmed(const std::string& text) {
  const auto begin = text.find_first_not_of(" \t\r\xEF\xBB\xBF");
  if (begin == std::string::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(trimmed(field));
  if (!line.empty() && line.back() == ',') fields.emplace_back();
  return fields;
}

bool to_number(const std::string& text, double& number) {
  const char* begin = text.data() + (text.size() > 1 && text[0] == '+' ? 1 : 0);
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(begin, end, number);
  return error == std::errc() && rest == end && std::isfinite(number);
}

}  // namespace

std::string why_unreadable(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (status.type() == std::filesystem::file_type::not_found) return "there is no such file";
  if (error) return error.message();
  if (std::filesystem::is_directory(status)) return "it is a folder, not a file";
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return errno ? std::strerror(errno) : "it cannot be opened";
  return {};
}

std::string lower_extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  if (extension == ".gz" || extension == ".GZ") extension = file.stem().extension().string() + extension;
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

std::string read_text(const std::filesystem::path& file) {
  if (const std::string why = why_unreadable(file); !why.empty()) {
    throw InputError(file.string(), why, "check the name and the permissions");
  }
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (stream.bad()) throw InputError(file.string(), "it could not be read to its end");
  return text.str();
}

Table read_table(const std::filesystem::path& file, const std::vector<std::string>& header) {
  Table table;
  table.columns.resize(header.size());
  const std::string expected = fmt::format("{}", fmt::join(header, ","));
  std::ifstream stream(file);
  bool header_seen = false;
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    line = trimmed(line);
    if (line.empty() || line[0] == '#') continue;
    const std::vector<std::string> fields = split(line);
    if (!header_seen) {
      if (fields != header) {
        table.problem = fmt::format("{}, line {}: the header is \"{:.40}\"", file.string(), number, line);
        table.hint = "the first line has to be " + expected;
        return table;
      }
      header_seen = true;
      continue;
    }
    bool good = fields.size() == header.size();
    for (std::size_t i = 0; good && i < header.size(); ++i) {
      double value = 0;
      good = to_number(fields[i], value);
      table.columns[i].push_back(value);
    }
    if (!good) {
      table.problem =
          fmt::format("{}, line {}: \"{:.40}\" is not {} numbers", file.string(), number, line, header.size());
      table.hint = "a line is " + expected;
      return table;
    }
  }
  if (!header_seen || table.columns[0].empty()) {
    table.problem = file.string() + " holds no numbers";
    table.hint = "a header line " + expected + ", then a line for each row";
  }
  return table;
}

namespace {

std::string decoded(const std::string& uri) {
  std::string name;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned code = 0;
    const char* digits = uri.data() + i + 1;
    if (uri[i] == '%' && i + 2 < uri.size() && std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2) {
      name += static_cast<char>(code);
      i += 2;
    } else {
      name += uri[i];
    }
  }
  return name;
}

// The file that a raw volume or a buffer of a glTF names under a key; empty where it names none or holds its data.
std::string part_of(const Json& thing, const char* key) {
  if (!thing.is_object() || !thing.contains(key) || !thing[key].is_string()) return {};
  const std::string name = thing[key].get<std::string>();
  return name.rfind("data:", 0) == 0 ? std::string() : name;
}

}  // namespace

std::vector<std::string> unreadable_parts(const std::filesystem::path& file) {
  const bool gltf = lower_extension(file) == ".gltf";
  std::vector<std::string> result;
  const auto check = [&](const std::string& name) {
    if (name.empty()) return;
    const std::filesystem::path part = file.parent_path() / name;
    if (const std::string why = why_unreadable(part); !why.empty()) result.push_back(part.string() + ": " + why);
  };
  try {
    std::vector<Problem> ignored;
    const Json document = parse_json(read_text(file), file.string(), ignored);
    if (gltf && document.is_object() && document.contains("buffers")) {
      // A list, or in glTF 1.0 an object.
      for (const Json& buffer : document["buffers"]) check(decoded(part_of(buffer, "uri")));
    } else if (!gltf && document.is_array()) {
      for (const Json& volume : document) check(part_of(volume, "raw"));
    } else if (!gltf) {
      check(part_of(document, "raw"));
    }
  } catch (const InputError&) {
  }
  return result;
}

}  // namespace obscura::detail
