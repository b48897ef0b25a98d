// The keys of light from outside the scene's elements: sky, sun, moon, air, and beams. scene_keys.h says how they are
// read.
#pragma once

#include <cmath>
#include <optional>

#include "scene/file/scene_json.h"
#include "scene/file/scene_limits.h"

namespace obscura::detail {

template <class V>
void keys(V& v, SkyDescription& s) {
  v.optional("radiance", s.radiance, at_least(0), "radiance over the full sphere");
  if (v.later("elevation_deg", nullptr, "sky by elevation")) {
    v.skip("K");  // a list then
  } else {
    v.optional("K", s.K, at_least(0), "temperature of a black sky; not in a grey band");
  }
  v.later("file", nullptr, "sky from an image");
}

/// Unit vector: x is east, y is north.
inline Vec3d toward_sky(double zenith_deg, double azimuth_deg) noexcept {
  const double z = zenith_deg * kPi / 180, a = azimuth_deg * kPi / 180;
  return {std::sin(z) * std::sin(a), std::sin(z) * std::cos(a), std::cos(z)};
}
template <class V>
void keys(V& v, SunDescription& s) {
  bool angles = false;
  double zenith_deg = 0, azimuth_deg = 0;
  v.form("toward");
  v.required("toward", s.toward, any(), "direction from the scene to the sun");
  v.form("zenith_deg");
  v.sets(angles, true);
  v.required("zenith_deg", zenith_deg, between(0, 180), "angle between the sun and straight up");
  v.optional("azimuth_deg", azimuth_deg, between(-360, 360), "from north (y), clockwise");
  v.every_form();
  if (angles) s.toward = toward_sky(zenith_deg, azimuth_deg);
  v.optional("irradiance", s.irradiance, at_least(0), "normal to the beam");
  v.optional("diameter_deg", s.diameter_deg, from_below(0, 180), "apparent diameter");
}

template <class V>
void keys(V& v, AtmosphereDescription& a) {
  v.optional("extinction_per_m", a.extinction_per_m, at_least(0), "extinction of the air, which absorbs");
  v.optional("K", a.K, at_least(0), "temperature of the air, default 288; not in a grey band");
  v.optional("radiance", a.radiance, at_least(0), "in place of K: radiance of endless air");
}

struct EnvironmentDescription {
  std::optional<SkyDescription> sky;
  std::optional<SunDescription> sun, moon;
  std::optional<AtmosphereDescription> atmosphere;
};
template <class V>
void keys(V& v, EnvironmentDescription& e) {
  v.optional("sky", e.sky, any(), "light from everywhere");
  v.optional("sun", e.sun, any(), "a distant disc of light");
  v.optional("moon", e.moon, any(), "a second distant disc of light");
  v.optional("atmosphere", e.atmosphere, any(), "clear air between the scene's elements");
}

template <class V>
void keys(V& v, BeamDescription& b) {
  v.required("position_m", b.position_m, any(), "where the light starts");
  v.required("toward", b.toward, any(), "where the light goes");
  v.optional("radius_m", b.radius_m, at_least(0), "radius of the beam");
  v.optional("power", b.power, at_least(0), "power of the beam");
}

}  // namespace obscura::detail
