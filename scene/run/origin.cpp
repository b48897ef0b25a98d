#include "scene/run/origin.h"

namespace obscura {

ImageOrigin origin_of(Session& session, const Method& method, const RadianceCounts& counts, std::uint64_t seed,
                      double time_s) {
  const Plan& plan = session.plan();
  ImageOrigin origin;
  origin.camera = plan.camera;
  origin.seed = seed;
  origin.scene_name = session.scene().name;
  origin.scene_hash = session.scene().hash;
  origin.method = method.type->word;
  origin.time_s = time_s;
  origin.has_bias = method.type->photons;
  origin.bias_is_error = method.type->cells;
  origin.has_criterion = plan.sampling.adaptive.has_value();
  origin.has_atmosphere = session.has_atmosphere();
  origin.dropped_bound = plan.budget.dropped;
  origin.left_out = plan.left_out;
  if (counts.footprint.error_bound > 0) {
    // Of coarse cells in the clouds that rays took whole: a share of the brightest source.
    for (const IntervalLimits& limits : session.summary().intervals) {
      const double bound = counts.footprint.error_bound * limits.source_max;
      origin.left_out[static_cast<std::size_t>(limits.band)].push_back({.radiance = bound, .clouds = true});
    }
  }
  return origin;
}

}  // namespace obscura
