#include "scene/plan/unit_words.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <string_view>
#include <utility>

namespace obscura::detail {
namespace {

/// One spelling for all: "Kg m**-3" and "kg m⁻³" become "kgm-3", "degrees_Celsius" becomes "celsius".
std::string plain(std::string words) {
  std::transform(words.begin(), words.end(), words.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  // Powers and letters in UTF-8; of "degrees" and "degree" the longer first.
  constexpr std::array<std::pair<std::string_view, std::string_view>, 16> kSpellings{{{"\xc2\xb3", "3"},
                                                                                      {"\xe2\x81\xbb", "-"},
                                                                                      {"\xc2\xb9", "1"},
                                                                                      {"\xc2\xb7", ""},
                                                                                      {"\xc2\xb0", ""},
                                                                                      {"\xc2\xb5", "u"},
                                                                                      {"\xce\xbc", "u"},
                                                                                      {"degrees", ""},
                                                                                      {"degree", ""},
                                                                                      {"deg", ""},
                                                                                      {" ", ""},
                                                                                      {"_", ""},
                                                                                      {".", ""},
                                                                                      {"*", ""},
                                                                                      {"^", ""},
                                                                                      {"micro", "u"}}};
  for (const auto& [from, to] : kSpellings) {
    for (std::size_t at = words.find(from); at != std::string::npos; at = words.find(from, at + to.size()))
      words.replace(at, from.size(), to);
  }
  return words;
}

}  // namespace

std::optional<AmountUnit> amount_unit(const std::string& words) {
  static const std::map<std::string, AmountUnit> known = {
      {"kg/m3", {1e3}},       {"kgm-3", {1e3}},        {"g/m3", {1}},       {"gm-3", {1}},       {"mg/m3", {1e-3}},
      {"mgm-3", {1e-3}},      {"ug/m3", {1e-6}},       {"ugm-3", {1e-6}},   {"g/cm3", {1e6}},    {"gcm-3", {1e6}},
      {"kg/kg", {1e3, true}}, {"kgkg-1", {1e3, true}}, {"g/kg", {1, true}}, {"gkg-1", {1, true}}};
  const auto found = known.find(plain(words));
  return found == known.end() ? std::nullopt : std::optional(found->second);
}

std::optional<KelvinScale> kelvin_scale(const std::string& words) {
  static const std::map<std::string, KelvinScale> known = {{"k", {}},
                                                           {"kelvin", {}},
                                                           {"kelvins", {}},
                                                           {"c", {1, 273.15}},
                                                           {"celsius", {1, 273.15}},
                                                           {"centigrade", {1, 273.15}},
                                                           {"f", {5.0 / 9, 255.372}},
                                                           {"fahrenheit", {5.0 / 9, 255.372}}};
  const auto found = known.find(plain(words));
  return found == known.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace obscura::detail
