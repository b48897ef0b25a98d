// What becomes of photons between their emission and their end. For trace.cpp.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octree/base/random.h"
#include "photon/trace/trace.h"

namespace obscura::detail {

/// A photon on its way.
struct History {
  Vec3d position;
  Vec3d direction;
  double power;
  bool in_direct_set;  // until it collides or is reflected
  bool from_beyond;    // likewise
  FaceId from;         // the face that it leaves
  int collisions = 0;
  int reflections = 0;
  std::uint32_t id = 0;  // its place among the emitted of its chunk
  Stream stream;
};

/// Follows a chunk of histories of one batch to their ends, all of them one flight at a time, and adds what becomes of
/// them to `result`, whose photons it sets.
/// @param result its flux has an entry for each rectangle
void follow_histories(const PhotonEmitter& emitter, const TraceSettings& settings,
                      std::span<const FluxRectangle> rectangles, std::size_t batch, std::vector<History> histories,
                      TraceResult& result);

}  // namespace obscura::detail
