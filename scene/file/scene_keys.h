// The keys of the scene file, each written once, by part of the scene in scene_keys_*.h: reader and schema are both
// visitors of these functions. A line is a key: what it may hold, what it means, and what messages say of it.
//   v.required / v.optional(key, member, limits, what it is): the member's value is the default
//   v.later(key, default, what): not available yet, refused unless it holds its default
//   v.form(key[, word]): the keys that follow belong to the form that has this key (with this word) ...
//   v.every_form(): ... until here; v.sets(member, value): what the form means
//   v.exactly_one(keys): one of these keys has to be given
// What several keys mean together is a function of the visitor's own (v.periods, v.phase_function ...), in
// scene_meaning.cpp.
#pragma once

#include <optional>
#include <string>

#include "scene/file/scene_keys_clouds.h"
#include "scene/file/scene_keys_environment.h"
#include "scene/file/scene_keys_objects.h"
#include "scene/file/scene_keys_render.h"
#include "scene/file/scene_keys_sensor.h"
#include "scene/file/scene_limits.h"

namespace obscura::detail {

template <class V>
void keys(V& v, Description& d) {
  int version = 1;
  std::string schema;
  v.required("obscura", version, between(1, 1), "version of the format");
  v.optional("$schema", schema, any(), "for editors; not read");
  v.optional("name", d.name, any(), "what the scene shows");
  v.optional("time_s", d.time_s, any(), "the picture's time");
  v.required("bands", d.bands, items(1), "what the sensor tells apart");
  v.optional("clouds", d.clouds, any(), "volumes that emit, absorb and scatter");
  v.optional("objects", d.objects, any(), "surfaces");
  v.optional("materials", d.materials, any(), "materials of surfaces, by name");
  v.optional("sources", d.hot_spheres, any(), "hot spheres");
  std::optional<ParticlesDescription> particles;
  v.optional("particles", particles, any(), "hot particles over time");
  if (particles) v.particles(*particles, d.particles);
  EnvironmentDescription environment;
  v.optional("environment", environment, any(), "sky, sun, moon and air");
  d.sky = environment.sky;
  d.sun = environment.sun;
  d.moon = environment.moon;
  d.atmosphere = environment.atmosphere;
  v.required("sensor", d.sensor, any(), "the camera");
  v.optional("probes", d.probes, any(), "points whose fluence goes to the report");
  v.optional("flux", d.flux, any(), "rectangles whose power goes to the report");
  v.optional("beams", d.beams, any(), "collimated light");
  v.optional("render", d.render, any(), "how to compute");
}

}  // namespace obscura::detail
