// The batched walk: many rays or flights at once, one per SIMD lane, lanes refilled as rays end.
// Float in the lanes with double sums; it is tested against the scalar walk of walk.h.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "octree/tree/octree.h"
#include "octree/tree/walk.h"

namespace obscura {

/// Optical depth along each ray in index space, clipped to its [t_min, t_max]: the integral over t of
/// sum_c weights[c] * value_c. Right to 1e-5 relative or 1e-6 absolute. A ray's result does not depend on the
/// others in its batch. Runs on the calling thread.
/// @param weights one per channel, not negative, in optical depth per (unit of value x unit of t).
void optical_depths(const Octree& tree, std::span<const Ray> index_rays, std::span<const double> weights,
                    std::span<double> depths) noexcept;

/// One flight: where it goes, and the optical depth after which it collides.
struct Flight {
  Ray ray;  ///< in index space
  double target_depth = 0;
};

/// free_path() (walk.h) of every flight, with the error of optical_depths(). Runs on the calling thread.
void free_paths(const Octree& tree, std::span<const Flight> flights, std::span<const double> weights,
                std::span<FreePath> ends) noexcept;

/// Name of the SIMD instruction set that runs ("AVX2", "SSE4", "NEON" ...).
std::string_view batch_target();

/// Names of those that this program holds and this machine can run, best first.
std::vector<std::string_view> batch_targets();

/// For tests: run this one from now on, in all threads; empty: the best again.
/// @returns whether this machine has it; if not, nothing changes.
bool force_batch_target(std::string_view name);

}  // namespace obscura
