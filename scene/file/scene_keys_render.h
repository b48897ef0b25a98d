// The keys of how to compute. scene_keys.h says how they are read.
#pragma once

#include "photon/methods/method.h"
#include "scene/file/scene_json.h"
#include "scene/file/scene_limits.h"

namespace obscura::detail {

template <class V>
void keys(V& v, RenderDescription& r) {
  v.optional("method", r.method, names(method_words()), "how multiple scattering is found; null: the plan chooses");
  v.optional("photons", r.photons, between(0, 4294967295.0), "photons emitted, per band");
  v.optional("nearest", r.nearest, between(1, 100000), "photons of a density estimate");
  v.optional("kernel", r.kernel, any(), "weight over the distance in a density estimate");
  v.optional("photon_power_min", r.photon_power_min, at_least(0), "photons below this are not stored");
  v.optional("directions", r.directions, any(), "how photons leave their sources");
  v.optional("final_gather", r.final_gather, between(0, 1), "bounces of final gather; null: the plan decides");
  v.optional("samples", r.samples, between(1, 1e9), "paths per pixel of final gather and method path");
  v.optional("octree_tolerance", r.octree_tolerance, from_below(0, 1), "error of a ray's transmission");
  v.optional("target_error", r.target_error, any(),
             "error to reach: a fraction, \"3%\" or \"20mK\"; photons and samples are then chosen");
  v.optional("floor", r.floor, at_least(0), "grey bands: radiance below which nothing matters");
  v.optional("time_limit_s", r.time_limit_s, above(0), "for the whole run; photons and samples are then chosen");
  v.later("memory_MiB", nullptr, "memory to stay below");
  v.optional("seed", r.seed, at_least(0), "seed of all random numbers");
  v.optional("effects", r.effects, names(effect_names()),
             "effects to force on or off, e.g. {\"atmosphere\": true}; what is absent stays off");
}

}  // namespace obscura::detail
