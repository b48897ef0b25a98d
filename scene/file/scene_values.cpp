#include "scene/file/scene_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "scene/file/scene_reader.h"
#include "scene/file/scene_table_io.h"
#include "scene/file/scene_words.h"

namespace obscura {
namespace detail {

std::string Limits::text() const {
  const std::string low = fmt::format("{}{:.10g}", above_min ? "above " : "of at least ", min);
  const std::string high = fmt::format("{}{:.10g}", below_max ? "below " : "at most ", max);
  if (min == -kInfinity) return max == kInfinity ? "" : high;
  if (max == kInfinity) return low;
  if (!above_min && !below_max) return fmt::format("from {:.10g} to {:.10g}", min, max);
  return low + " and " + high;
}

namespace {

std::string give(const std::string& what, const Limits& limits) {
  const std::string range = limits.text();
  return "give " + what + (range.empty() ? "" : " " + range);
}

bool refuse_type(Findings& findings, const Json& json, const std::string& pointer, const std::string& expected,
                 const std::string& hint) {
  findings.problem(pointer, fmt::format("expected {}, found {}", expected, describe_value(json)), hint);
  return false;
}

bool in_range(Findings& findings, double value, const std::string& pointer, const Limits& limits) {
  if (limits.hold(value)) return true;
  findings.problem(pointer, fmt::format("{:g} is out of range", value), give("a number", limits));
  return false;
}

bool increasing(Findings& findings, const std::vector<double>& values, const std::string& pointer) {
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (!(values[i] > values[i - 1])) {
      findings.problem(pointer_to(pointer, i),
                       fmt::format("{:g} follows {:g}: the values have to increase", values[i], values[i - 1]),
                       "sort the list and leave out repeated values");
      return false;
    }
  }
  return true;
}

// A list of exactly n numbers.
bool read_tuple(Findings& findings, const Json& json, const std::string& pointer, const Limits& limits, std::size_t n,
                double* values) {
  const std::string expected = fmt::format("a list of {} numbers", n);
  if (!json.is_array() || json.size() != n) {
    return refuse_type(findings, json, pointer, expected, give(n == 3 ? "[x, y, z]" : "[a, b]", {}));
  }
  bool good = true;
  for (std::size_t i = 0; i < n; ++i) {
    good &= read_value(findings, json[i], pointer_to(pointer, i), values[i], limits);
  }
  return good;
}

}  // namespace

bool read_value(Findings& findings, const Json& json, const std::string& pointer, double& value, const Limits& limits) {
  if (!json.is_number()) return refuse_type(findings, json, pointer, "a number", give("a number", limits));
  const double number = json.get<double>();
  if (!in_range(findings, number, pointer, limits)) return false;
  value = number;
  return true;
}

bool read_value(Findings& findings, const Json& json, const std::string& pointer, bool& value, const Limits&) {
  if (!json.is_boolean())
    return refuse_type(findings, json, pointer, "true or false", "give true or false, without quotes");
  value = json.get<bool>();
  return true;
}

bool read_integer(Findings& findings, const Json& json, const std::string& pointer, const Limits& limits,
                  std::uint64_t most, std::uint64_t& value) {
  const std::string wanted = give("a whole number", limits);
  if (!json.is_number()) return refuse_type(findings, json, pointer, "a whole number", wanted);
  const double number = json.get<double>();
  if (number != std::floor(number)) return refuse_type(findings, json, pointer, "a whole number", wanted);
  if (number < 0 || !limits.hold(number) || (!json.is_number_integer() && number >= 0x1p64)) {
    findings.problem(pointer, fmt::format("{:g} is out of range", number), wanted);
    return false;
  }
  const std::uint64_t whole = json.is_number_integer() ? json.get<std::uint64_t>() : static_cast<std::uint64_t>(number);
  if (whole > most) {
    findings.problem(pointer, fmt::format("{} is out of range", whole), fmt::format("give at most {}", most));
    return false;
  }
  value = whole;
  return true;
}

bool read_value(Findings& findings, const Json& json, const std::string& pointer, std::string& value,
                const Limits& limits) {
  if (!limits.names.empty()) {
    std::vector<PlainWord> words;
    for (const std::string& name : limits.names) words.push_back({name, false});
    const int index = read_word(findings, json, pointer, words);
    if (index >= 0) value = limits.names[static_cast<std::size_t>(index)];
    return index >= 0;
  }
  if (!json.is_string()) return refuse_type(findings, json, pointer, "a text", "put it between quotes");
  const std::string text = json.get<std::string>();
  const bool printable = std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 32 || c == 127; });
  if (text.empty() || !printable) {
    findings.problem(pointer, text.empty() ? "the text is empty" : "the text holds control characters",
                     "give a name, or leave the key out");
    return false;
  }
  value = text;
  return true;
}

bool read_value(Findings& findings, const Json& json, const std::string& pointer, std::filesystem::path& value,
                const Limits& limits) {
  std::string name;
  if (!read_value(findings, json, pointer, name, limits)) return false;
  const std::filesystem::path file = findings.resolve(name);
  const std::string extension = lower_extension(file);
  const auto& allowed = limits.extensions;
  if (!allowed.empty() && std::find(allowed.begin(), allowed.end(), extension) == allowed.end()) {
    findings.problem(pointer, fmt::format("the kind of file of \"{}\" is not known by its extension", name),
                     fmt::format("give one of {}", fmt::join(allowed, ", ")));
    return false;
  }
  if (const std::string why = why_unreadable(file); !why.empty()) {
    findings.problem(pointer, fmt::format("\"{}\" cannot be read: {}", file.string(), why),
                     "names are relative to the scene file; check name and permissions");
    return false;
  }
  if (extension == ".json" || extension == ".gltf") {
    for (const std::string& unreadable : unreadable_parts(file)) {
      findings.problem(pointer, fmt::format("\"{}\" names a file that cannot be read: {}", file.string(), unreadable),
                       "names in it are relative to itself; check name and permissions");
      return false;
    }
  }
  value = file;
  return true;
}

bool read_value(Findings& findings, const Json& json, const std::string& pointer, Vec3d& value, const Limits& limits) {
  double v[3];
  if (!read_tuple(findings, json, pointer, limits, 3, v)) return false;
  value = Vec3d(v[0], v[1], v[2]);
  return true;
}

bool read_value(Findings& findings, const Json& json, const std::string& pointer, std::array<double, 2>& value,
                const Limits& limits) {
  double v[2];
  if (!read_tuple(findings, json, pointer, limits, 2, v)) return false;
  if (limits.increasing && !increasing(findings, {v[0], v[1]}, pointer)) return false;
  value = {v[0], v[1]};
  return true;
}

bool read_value(Findings& findings, const Json& json, const std::string& pointer, std::array<int, 2>& value,
                const Limits& limits) {
  if (!json.is_array() || json.size() != 2) {
    return refuse_type(findings, json, pointer, "a list of 2 whole numbers", "give [across, down]");
  }
  int v[2];
  const bool first = read_value(findings, json[0], pointer_to(pointer, std::size_t{0}), v[0], limits);
  const bool second = read_value(findings, json[1], pointer_to(pointer, std::size_t{1}), v[1], limits);
  if (first && second) value = {v[0], v[1]};
  return first && second;
}

bool read_value(Findings& findings, const Json& json, const std::string& pointer, std::vector<double>& value,
                const Limits& limits) {
  if (!json.is_array()) return refuse_type(findings, json, pointer, "a list of numbers", "give [a, b, ...]");
  if (json.size() < limits.min_items) {
    findings.problem(pointer, fmt::format("the list has {} of at least {} numbers", json.size(), limits.min_items),
                     "add the others");
    return false;
  }
  std::vector<double> numbers(json.size());
  bool good = true;
  for (std::size_t i = 0; i < json.size(); ++i) {
    good &= read_value(findings, json[i], pointer_to(pointer, i), numbers[i], limits);
  }
  if (!good || (limits.increasing && !increasing(findings, numbers, pointer))) return false;
  value = std::move(numbers);
  return true;
}

namespace {

const char* const kSpectralHint = "give a number, {\"um\": [..], \"value\": [..]} or {\"file\": \"table.csv\"}";

bool read_spectral_file(Findings& findings, const Json& json, const std::string& pointer, std::vector<double>& um,
                        std::vector<double>& value, const Limits& limits) {
  std::filesystem::path file;
  if (!read_value(findings, json, pointer, file, {})) return false;
  Table table = read_table(file, {"um", "value"});
  std::string problem = table.problem, hint = table.hint;
  for (std::size_t i = 0; problem.empty() && i < table.columns[0].size(); ++i) {
    const double x = table.columns[0][i], y = table.columns[1][i];
    if (!(x > 0) || (i > 0 && !(x > table.columns[0][i - 1]))) {
      problem = fmt::format("{}: wavelength {:g} um is not above the one before", file.string(), x);
      hint = "sort the rows and leave out repeated wavelengths";
    } else if (!limits.hold(y)) {
      problem = fmt::format("{}: the value {:g} at {:g} um is out of range", file.string(), y, x);
      hint = give("numbers", limits);
    }
  }
  if (!problem.empty()) {
    findings.problem(pointer, problem, hint);
    return false;
  }
  um = std::move(table.columns[0]);
  value = std::move(table.columns[1]);
  return true;
}

}  // namespace

bool read_value(Findings& findings, const Json& json, const std::string& pointer, Spectrum& spectrum,
                const Limits& limits) {
  if (json.is_number()) {
    double number = 0;
    if (!read_value(findings, json, pointer, number, limits)) return false;
    spectrum = Spectrum::constant(number);
    return true;
  }
  if (!json.is_object()) return refuse_type(findings, json, pointer, "a spectral quantity", kSpectralHint);
  bool good = true;
  const auto member = [&](const char* key) -> const Json* {
    const auto it = json.find(key);
    return it == json.end() || it->is_null() ? nullptr : &*it;
  };
  for (const auto& [key, ignored] : json.items()) {
    if (key != "um" && key != "value" && key != "file") {
      findings.problem(pointer_to(pointer, key), fmt::format("unknown key \"{}\"", key),
                       suggest(key, {"um", "value", "file"}));
      good = false;
    }
  }
  const Json *um = member("um"), *value = member("value"), *file = member("file");
  if (file && (um || value)) {
    findings.problem(pointer, "\"file\" and a table are both given", "give one of them");
    return false;
  }
  std::vector<double> wavelengths, values;
  if (file) {
    good &= read_spectral_file(findings, *file, pointer_to(pointer, "file"), wavelengths, values, limits);
  } else if (um && value) {
    Limits each = limits;
    each.min_items = 1;
    Limits wavelength = above(0);
    wavelength.min_items = 1;
    wavelength.increasing = true;
    good &= read_value(findings, *um, pointer_to(pointer, "um"), wavelengths, wavelength);
    good &= read_value(findings, *value, pointer_to(pointer, "value"), values, each);
    if (good && wavelengths.size() != values.size()) {
      findings.problem(pointer, fmt::format("{} wavelengths but {} values", wavelengths.size(), values.size()),
                       "give one value for each wavelength");
      good = false;
    }
  } else if (good) {
    findings.problem(pointer,
                     um      ? "\"value\" is missing"
                     : value ? "\"um\" is missing"
                             : "the table is missing",
                     kSpectralHint);
    good = false;
  }
  if (!good) return false;
  spectrum = Spectrum::table(std::move(wavelengths), std::move(values));
  if (!spectrum.is_constant()) findings.spectral_tables.push_back(pointer);
  return true;
}

bool read_value(Findings& findings, const Json& json, const std::string& pointer, ErrorTarget& target, const Limits&) {
  constexpr const char* kHint =
      "give a fraction such as 0.03, or in quotes a per cent or kelvin: \"3%\", \"20mK\", \"0.1K\"";
  ErrorTarget read;
  if (json.is_number()) {
    read.value = json.get<double>();
  } else if (json.is_string()) {
    const std::string text = json.get<std::string>();
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), read.value);
    std::string_view unit(rest, static_cast<std::size_t>(text.data() + text.size() - rest));
    unit.remove_prefix(std::min(unit.find_first_not_of(' '), unit.size()));
    if (unit == "K" || unit == "mK") read.unit = ErrorUnit::kelvin;
    if (error != std::errc() || !(unit.empty() || unit == "%" || unit == "K" || unit == "mK")) {
      findings.problem(pointer, fmt::format("\"{}\" is not an error", text), kHint);
      return false;
    }
    read.value *= unit == "%" ? 0.01 : unit == "mK" ? 1e-3 : 1;
  } else {
    return refuse_type(findings, json, pointer, "an error", kHint);
  }
  if (!(read.value > 0) || !std::isfinite(read.value) || (read.unit == ErrorUnit::fraction && read.value >= 1)) {
    findings.problem(pointer, fmt::format("{} is out of range", json.dump()),
                     "give an error above 0, as a fraction below 1");
    return false;
  }
  target = read;
  return true;
}

int read_word(Findings& findings, const Json& json, const std::string& pointer, const std::vector<PlainWord>& words) {
  std::vector<std::string> available;
  for (const PlainWord& word : words) {
    if (!word.later) available.push_back(word.text);
  }
  const std::string hint = fmt::format("give one of {}", fmt::join(available, ", "));
  if (!json.is_string()) {
    refuse_type(findings, json, pointer, "a word", hint);
    return -1;
  }
  const std::string text = json.get<std::string>();
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i].text != text) continue;
    if (!words[i].later) return static_cast<int>(i);
    findings.problem(pointer, fmt::format("\"{}\" is not available yet", text), hint);
    return -1;
  }
  findings.problem(pointer, fmt::format("\"{}\" is not a word known here", text), suggest(text, available));
  return -1;
}

}  // namespace detail
}  // namespace obscura
