// What photon maps and paths have in common: the pass along rays, asked for radiance, and for fluence from all sides.
#pragma once

#include "photon/methods/method.h"

namespace obscura::detail {

/// The pass's settings by a method's and what is asked of it.
RadianceSettings radiance_settings(const Method& method, const EstimatorSettings& settings);

/// Radiance and fluence by incoming_radiance(). @param light with one map per interval; null or no maps: no map is
/// asked
void answer_by_rays(const World& world, const RadianceSettings& settings, std::shared_ptr<const Light> light,
                    Estimator& estimator);

}  // namespace obscura::detail
