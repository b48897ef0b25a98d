// Reads the keys of scene_keys.h from JSON into a Description and notes every problem it meets.
#pragma once

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "scene/file/description.h"
#include "scene/file/scene_json.h"
#include "scene/file/scene_limits.h"
#include "scene/file/scene_values.h"
#include "scene/file/scene_words.h"

namespace obscura::detail {

struct PhaseDescription;
struct ParticlesDescription;

/// What reading has found so far. Pointers name places in the scene file.
class Findings {
 public:
  explicit Findings(std::filesystem::path base_folder) : base_folder_(std::move(base_folder)) {}

  /// Notes a problem; each place is told of once.
  void problem(const std::string& pointer, std::string problem, std::string hint);
  void warn(std::string sentence) { warnings.push_back(std::move(sentence)); }

  /// True where a value was given and read without a problem.
  bool good(const std::string& pointer) const { return good_.count(pointer) != 0; }
  /// True where there is a problem with the value, or with a part of it.
  bool bad(const std::string& pointer) const { return told_.count(pointer) != 0 || bad_.count(pointer) != 0; }
  void mark_good(const std::string& pointer) { good_.insert(pointer); }
  void mark_bad(const std::string& pointer) { bad_.insert(pointer); }

  /// A file named relative to the scene file, as the program can open it.
  std::filesystem::path resolve(const std::string& name) const;

  std::vector<Problem> problems;
  std::vector<std::string> warnings;
  std::vector<std::string> spectral_tables;  ///< pointers of spectral quantities that are tables

 private:
  std::filesystem::path base_folder_;
  std::set<std::string> good_, bad_;
  std::set<std::string> told_;  // pointers with a problem
};

/// A visitor of the keys of one JSON object.
class ObjectReader {
 public:
  ObjectReader(Findings& findings, const Json& object, std::string pointer)
      : findings_(findings), object_(object), pointer_(std::move(pointer)) {}

  template <class T>
  void required(const char* key, T& member, const Limits& limits, const char* what) {
    if (!wanted(key)) return;
    if (const Json* value = find(key)) {
      read_member(key, *value, member, limits);
    } else {
      missing_.push_back({key, what});
    }
  }

  template <class T>
  void optional(const char* key, T& member, const Limits& limits, const char*) {
    if (!wanted(key)) return;
    if (const Json* value = find(key)) read_member(key, *value, member, limits);
  }

  /// Refuses the key by name unless it holds its default, null, {} or []. @returns whether it refused.
  bool later(const char* key, const Json& default_value, const char* what);

  /// A key that a refused one gives another meaning.
  void skip(const char* key) { known_.emplace_back(key); }

  void form(const char* key);
  void form(const char* key, const char* word);
  void default_form(const char* key, const char* word);
  void every_form() { in_form_ = true; }
  template <class T>
  void sets(T& member, T value) {
    if (in_form_) member = value;
  }
  void exactly_one(std::initializer_list<const char*> keys);

  // What several keys mean together.
  void phase_function(const PhaseDescription& phase, PhaseFunction& function);
  void periods(const std::vector<Axis>& axes, const std::vector<double>& periods, CloudDescription& cloud);
  void angle_factor(const std::vector<double>& angle_deg, const std::vector<double>& factor,
                    MaterialDescription& material);
  void point_spread(const std::filesystem::path& file, DetectorSettings& detector);
  void particles(const ParticlesDescription& table, std::vector<ParticleDescription>& particles);

  /// Reports unknown keys with the nearest valid one, missing keys and forms that do not match.
  void finish();

 private:
  struct Missing {
    std::string key, what;
  };
  struct Form {
    std::string key, word;  // word empty: the key's presence decides
    bool matched;
  };

  const Json* find(std::string_view key) const;  // null where absent or null
  bool wanted(const char* key);
  void begin_form(Form form);
  void report_forms();

  template <class T>
  void read_member(const char* key, const Json& value, T& member, const Limits& limits);

  Findings& findings_;
  const Json& object_;
  std::string pointer_;
  std::vector<std::string> known_;      // keys of this object, or of the form that it has
  std::vector<std::string> elsewhere_;  // keys of its other forms
  std::vector<Missing> missing_;
  std::vector<Form> forms_;
  bool in_form_ = true;
};

/// An object with keys of its own.
template <class T>
std::enable_if_t<std::is_class_v<T>, bool> read_value(Findings& findings, const Json& json, const std::string& pointer,
                                                      T& value, const Limits&) {
  if (!json.is_object()) {
    findings.problem(pointer, "expected an object, found " + describe_value(json), "give {\"key\": value, ...}");
    return false;
  }
  const std::size_t before = findings.problems.size();
  ObjectReader reader(findings, json, pointer);
  keys(reader, value);
  reader.finish();
  return findings.problems.size() == before;
}

/// An empty object counts as absent.
template <class T>
bool read_value(Findings& findings, const Json& json, const std::string& pointer, std::optional<T>& value,
                const Limits& limits) {
  if constexpr (requires(ObjectReader & reader, T & object) { keys(reader, object); }) {
    if (json.is_object() && json.empty()) return true;
  }
  T read{};
  if (!read_value(findings, json, pointer, read, limits)) return false;
  value = std::move(read);
  return true;
}

template <class T>
bool read_value(Findings& findings, const Json& json, const std::string& pointer, std::vector<T>& value,
                const Limits& limits) {
  if (!json.is_array()) {
    findings.problem(pointer, "expected a list, found " + describe_value(json), "give [{...}, ...]");
    return false;
  }
  if (json.size() < limits.min_items) {
    findings.problem(pointer, "the list is empty", "give at least one");
    return false;
  }
  value.assign(json.size(), T{});
  bool good = true;
  for (std::size_t i = 0; i < json.size(); ++i) {
    good &= read_value(findings, json[i], pointer_to(pointer, i), value[i], Limits{});
  }
  return good;
}

/// Things by name; null is a thing with its defaults.
template <class T>
bool read_value(Findings& findings, const Json& json, const std::string& pointer, std::map<std::string, T>& value,
                const Limits& limits) {
  if (!json.is_object()) {
    findings.problem(pointer, "expected an object, found " + describe_value(json), "give {\"name\": {...}, ...}");
    return false;
  }
  bool good = true;
  for (const auto& [name, member] : json.items()) {
    if (!limits.names.empty() && std::find(limits.names.begin(), limits.names.end(), name) == limits.names.end()) {
      findings.problem(pointer_to(pointer, name), "there is no \"" + name + "\"", suggest(name, limits.names));
      good = false;
      continue;
    }
    // What is null is not given, where only certain names are known.
    if (!limits.names.empty() && member.is_null()) continue;
    T& thing = value[name];
    if (!member.is_null()) good &= read_value(findings, member, pointer_to(pointer, name), thing, Limits{});
  }
  return good;
}

template <class T>
void ObjectReader::read_member(const char* key, const Json& value, T& member, const Limits& limits) {
  const std::string pointer = pointer_to(pointer_, key);
  if (read_value(findings_, value, pointer, member, limits)) {
    findings_.mark_good(pointer);
  } else {
    findings_.mark_bad(pointer);
  }
}

/// Reads a whole scene; what the keys mean together is scene_check.h's.
void read_description(Findings& findings, const Json& document, Description& description);

}  // namespace obscura::detail
