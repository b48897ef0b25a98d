#include "scene/run/origin.h"

namespace obscura {

ImageOrigin origin_of(Session& session, const Method& method, std::uint64_t seed, double time_s) {
  const Plan& plan = session.plan();
  ImageOrigin origin;
  origin.camera = plan.camera;
  origin.seed = seed;
  origin.scene_name = session.scene().name;
  origin.scene_hash = session.scene().hash;
  origin.method = method.type->word;
  origin.time_s = time_s;
  origin.has_bias = method.type->photons || method.type->cells;
  origin.has_criterion = plan.sampling.adaptive.has_value();
  origin.has_atmosphere = session.has_atmosphere();
  origin.dropped_bound = plan.budget.dropped;
  return origin;
}

}  // namespace obscura
