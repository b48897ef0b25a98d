// Single values of the scene file: type and range, with the problem in words.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "scene/file/description.h"
#include "scene/file/scene_json.h"
#include "scene/file/scene_limits.h"

namespace obscura::detail {

class Findings;

// Each reads one value, or notes a problem and returns false.
bool read_value(Findings&, const Json&, const std::string& pointer, double&, const Limits&);
bool read_value(Findings&, const Json&, const std::string& pointer, bool&, const Limits&);
bool read_value(Findings&, const Json&, const std::string& pointer, std::string&, const Limits&);
bool read_value(Findings&, const Json&, const std::string& pointer, std::filesystem::path&, const Limits&);
bool read_value(Findings&, const Json&, const std::string& pointer, Vec3d&, const Limits&);
bool read_value(Findings&, const Json&, const std::string& pointer, std::vector<double>&, const Limits&);
bool read_value(Findings&, const Json&, const std::string& pointer, std::array<double, 2>&, const Limits&);
bool read_value(Findings&, const Json&, const std::string& pointer, std::array<int, 2>&, const Limits&);
bool read_value(Findings&, const Json&, const std::string& pointer, Spectrum&, const Limits&);
/// A number is a fraction; a text one too ("3%"), or a temperature ("20mK").
bool read_value(Findings&, const Json&, const std::string& pointer, ErrorTarget&, const Limits&);

/// A whole number, exact up to 2^64 - 1; 1e6 and 64.0 are whole too.
bool read_integer(Findings&, const Json&, const std::string& pointer, const Limits&, std::uint64_t most,
                  std::uint64_t& value);

template <class T>
std::enable_if_t<std::is_integral_v<T> && !std::is_same_v<T, bool>, bool> read_value(Findings& findings,
                                                                                     const Json& json,
                                                                                     const std::string& pointer,
                                                                                     T& value, const Limits& limits) {
  std::uint64_t read = 0;
  if (!read_integer(findings, json, pointer, limits, std::numeric_limits<T>::max(), read)) return false;
  value = static_cast<T>(read);
  return true;
}

/// A word; `later` ones are refused as not available yet.
struct PlainWord {
  std::string text;
  bool later;
};
/// @returns the word's index, or -1 with a problem noted
int read_word(Findings&, const Json&, const std::string& pointer, const std::vector<PlainWord>& words);

template <class E>
std::vector<PlainWord> plain_words() {
  std::vector<PlainWord> words;
  for (const auto& word : Words<E>::list) words.push_back({std::string(word.text), word.later});
  return words;
}

template <class E>
std::enable_if_t<std::is_enum_v<E>, bool> read_value(Findings& findings, const Json& json, const std::string& pointer,
                                                     E& value, const Limits&) {
  const int index = read_word(findings, json, pointer, plain_words<E>());
  if (index < 0) return false;
  value = Words<E>::list[static_cast<std::size_t>(index)].value;
  return true;
}

}  // namespace obscura::detail
