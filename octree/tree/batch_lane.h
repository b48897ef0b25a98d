// What the SIMD kernels of the batched walk are given: the job, and a ray prepared for a lane. A
// lane's axes are mirrored so that every ray goes up on all three.
#pragma once

#include <array>
#include <cstdint>

#include "octree/tree/batch_walk.h"

namespace obscura::detail {

inline constexpr int kMaxBatchChannels = 2;

/// A call of optical_depths() or free_paths(), as the kernels take it.
struct BatchJob {
  const Octree* octree = nullptr;
  const TreeData* tree = nullptr;
  std::span<const double> all_weights;
  int channel_count = 0;  ///< with a weight that is not 0, at most kMaxBatchChannels
  std::array<int, kMaxBatchChannels> channels{};
  std::array<double, kMaxBatchChannels> weights{};
  std::size_t count = 0;
  const Ray* rays = nullptr;  ///< optical_depths()
  double* depths = nullptr;
  const Flight* flights = nullptr;  ///< free_paths()
  FreePath* ends = nullptr;

  const Ray& ray(std::size_t i) const noexcept { return flights ? flights[i].ray : rays[i]; }
};

/// A ray clipped to the domain, in mirrored voxel coordinates relative to the table: v + f is where it enters, all
/// directions are >= 0 and of unit length together; lengths are in voxels.
struct LaneRay {
  std::int32_t voxel[3];   ///< of entry
  std::int32_t limit[3];   ///< the domain ends before this voxel
  std::int32_t mirror[3];  ///< -1 where the axis is mirrored, else 0
  float fraction[3];       ///< in [0, 1)
  float direction[3];
  float inverse[3];   ///< of the direction; kParallel where it is 0
  double length = 0;  ///< from entry to exit
  double per_t = 1;   ///< length of the direction that was given, in voxels per t
  double t_enter = 0;
  bool cut = false;  ///< ends by t_max, inside the domain
};

/// The time of a plane that is never reached.
inline constexpr float kParallel = 1e30f;
/// The largest float below 1.
inline constexpr float kBelowOne = 0x1.fffffep-1f;

/// Directions below this cross planes so slowly that a float's position is too coarse to say when.
inline constexpr double kShallow = 1e-3;

enum class Prepared {
  misses,  ///< the domain
  lane,
  shallow,  ///< crosses planes at less than kShallow: for the scalar walk
};
Prepared prepare_lane(const TreeData& tree, const Ray& ray, LaneRay& lane) noexcept;

}  // namespace obscura::detail
