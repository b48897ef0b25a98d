// Units as volume files spell them, as far as a scene's keys stand beside them.
#pragma once

#include <optional>
#include <string>

namespace obscura::detail {

/// A unit of the amount of matter in air.
struct AmountUnit {
  double per_g_m3 = 1;            ///< how many g/m3 are one of it; of a share of the air's mass, per kg/m3 of air
  bool share_of_the_air = false;  ///< kg/kg
};

/// Nothing where the words are no such unit: none at all, or a unit of something else.
std::optional<AmountUnit> amount_unit(const std::string& words);

/// kelvin = scale * value + offset_K.
struct KelvinScale {
  double scale = 1, offset_K = 0;
  bool operator==(const KelvinScale&) const = default;
};

/// Of kelvin, degrees Celsius and degrees Fahrenheit; nothing for other words.
std::optional<KelvinScale> kelvin_scale(const std::string& words);

}  // namespace obscura::detail
