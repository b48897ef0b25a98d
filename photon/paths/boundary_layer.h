// Light near the face of a thick cloud, where a photon map's ball reaches deeper than the layer in which it falls off.
#pragma once

#include "photon/map/density.h"
#include "photon/world/spectral_world.h"

namespace obscura::detail {

/// Takes off an estimate of in-scattered radiance what its ball has brought from behind the layer, and adds what may be
/// wrong with that to its bias. Nothing changes where the ball is smaller than the layer, or where no face is near.
/// Formulas: photon/METHODS.md, "The photon map".
/// @param point of the estimate, in the World
void resolve_boundary_layer(SpectralWorld world, const Vec3d& point, Estimate& estimate) noexcept;

}  // namespace obscura::detail
