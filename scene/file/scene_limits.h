// What a value of the scene file may be beyond its type; and the words of its enumerations.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "octree/base/math.h"
#include "scene/file/description.h"

namespace obscura::detail {

/// Bounds of a number, or of each number in a list, vector or spectral table.
struct Limits {
  double min = -kInfinity;
  double max = kInfinity;
  bool above_min = false;  ///< min itself is refused
  bool below_max = false;
  std::size_t min_items = 0;              ///< of a list
  bool increasing = false;                ///< of a list, strictly
  std::vector<std::string> extensions{};  ///< of a file, with the dot; empty: any
  std::vector<std::string> names{};       ///< of an object's keys; empty: any

  bool hold(double value) const noexcept {
    return (above_min ? value > min : value >= min) && (below_max ? value < max : value <= max);
  }
  /// "above 0", "from 0 to 1", ...; empty where everything is allowed.
  std::string text() const;
};

inline Limits any() { return {}; }
inline Limits at_least(double min) { return {.min = min}; }
inline Limits above(double min) { return {.min = min, .above_min = true}; }
inline Limits between(double min, double max) { return {.min = min, .max = max}; }
inline Limits inside(double min, double max) { return {.min = min, .max = max, .above_min = true, .below_max = true}; }
inline Limits above_to(double min, double max) { return {.min = min, .max = max, .above_min = true}; }
inline Limits from_below(double min, double max) { return {.min = min, .max = max, .below_max = true}; }
inline Limits items(std::size_t min_items) { return {.min_items = min_items}; }
inline Limits numbers(std::size_t min_items, Limits each, bool increasing = true) {
  each.min_items = min_items;
  each.increasing = increasing;
  return each;
}
inline Limits names(std::vector<std::string> names) { return {.names = std::move(names)}; }
inline Limits files(std::vector<std::string> extensions) { return {.extensions = std::move(extensions)}; }

/// One word of an enumeration; one that is not available yet is refused by name.
template <class E>
struct EnumWord {
  std::string_view text;
  E value;
  bool later = false;
};

template <class E>
struct Words;

enum class Axis { x, y };
template <>
struct Words<Axis> {
  static constexpr std::array<EnumWord<Axis>, 2> list{{{"x", Axis::x}, {"y", Axis::y}}};
};
template <>
struct Words<Projection> {
  static constexpr std::array<EnumWord<Projection>, 3> list{{{"perspective", Projection::perspective},
                                                             {"orthographic", Projection::orthographic},
                                                             {"fisheye", Projection::fisheye}}};
};
template <>
struct Words<Kernel> {
  static constexpr std::array<EnumWord<Kernel>, 4> list{{{"constant", Kernel::constant},
                                                         {"epanechnikov", Kernel::epanechnikov},
                                                         {"cone", Kernel::cone},
                                                         {"gaussian", Kernel::gaussian}}};
};
template <>
struct Words<Directions> {
  static constexpr std::array<EnumWord<Directions>, 3> list{
      {{"stratified", Directions::stratified}, {"regular", Directions::regular}, {"random", Directions::random}}};
};

}  // namespace obscura::detail
