// What made an image, for its metadata.
#pragma once

#include "scene/session/session.h"
#include "sensor/picture/image.h"

namespace obscura {

/// @param method that made it, with the plan's camera; counts of what its rays did
ImageOrigin origin_of(Session& session, const Method& method, const RadianceCounts& counts, std::uint64_t seed,
                      double time_s);

}  // namespace obscura
