#include "quantities.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <utility>

#include "octree/base/error.h"

namespace obscura::cli {
namespace {

// The number at the text's start and what follows it, without spaces between.
bool split_number(const std::string& text, double& number, std::string& rest) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || !std::isfinite(number)) return false;
  rest.assign(end, text.data() + text.size());
  rest.erase(0, rest.find_first_not_of(' ') == std::string::npos ? rest.size() : rest.find_first_not_of(' '));
  return true;
}

}  // namespace

double parse_seconds(const std::string& text, const std::string& option) {
  static constexpr std::pair<const char*, double> units[] = {{"", 1},     {"s", 1},    {"ms", 1e-3},
                                                             {"min", 60}, {"h", 3600}, {"d", 86400}};
  double number = 0;
  std::string unit;
  if (split_number(text, number, unit)) {
    for (const auto& [name, factor] : units) {
      if (unit == name) return number * factor;
    }
  }
  throw InputError(option, fmt::format("\"{}\" is not a time", text),
                   "give seconds, or a number with ms, s, min, h or d, such as 30s or 5min");
}

double parse_fraction(const std::string& text, const std::string& option) {
  double number = 0;
  std::string unit;
  if (split_number(text, number, unit) && number >= 0 && (unit.empty() || unit == "%")) {
    return unit.empty() ? number : number / 100;
  }
  throw InputError(option, fmt::format("\"{}\" is not an error", text),
                   "give a fraction such as 0.03, or a per cent such as 3%");
}

double parse_tolerance(const std::string& text, const std::string& option) {
  const double tolerance = parse_fraction(text, option);
  if (tolerance < 1) return tolerance;
  throw InputError(option, "a transmission cannot be wrong by 1", "give less, such as 0.001");
}

std::string bytes_text(std::uint64_t bytes) {
  static constexpr const char* units[] = {"B", "KiB", "MiB", "GiB", "TiB"};
  double value = static_cast<double>(bytes);
  int unit = 0;
  while (value >= 1024 && unit < 4) {
    value /= 1024;
    ++unit;
  }
  return unit == 0 ? fmt::format("{} B", bytes) : fmt::format("{:.{}f} {}", value, value < 10 ? 2 : 1, units[unit]);
}

}  // namespace obscura::cli
