// The batched walk's calls: each becomes a job for the kernel of the best SIMD target that the machine has.
// Rays that no kernel can take go to the scalar walk.
#include "octree/tree/batch_walk.h"

#include <cassert>
#include <cmath>

#include "octree/tree/batch_lane.h"

// Sizeless vectors cannot be members; NEON serves such machines too.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/tree/batch_walk.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "octree/tree/batch_kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace obscura::detail::HWY_NAMESPACE {

// Several groups of lanes take turns: while one walks, the memory that another needs next is on its way.
template <bool kFloats, bool kFlights, int kChannels>
void run_groups(const BatchJob& job) {
  std::size_t next_ray = 0;
  using Group = Kernel<kFloats, kFlights, kChannels>;
  Group a(job, next_ray), b(job, next_ray);
  while (a.alive() || b.alive()) {
    if (a.alive()) a.advance();
    if (b.alive()) b.advance();
  }
}

template <bool kFloats, bool kFlights>
void run_channels(const BatchJob& job) {
  if (job.channel_count == 1) {
    run_groups<kFloats, kFlights, 1>(job);
  } else {
    run_groups<kFloats, kFlights, 2>(job);
  }
}

void run_batch(const BatchJob& job) {
  if (job.tree->lossless) {
    job.flights ? run_channels<true, true>(job) : run_channels<true, false>(job);
  } else {
    job.flights ? run_channels<false, true>(job) : run_channels<false, false>(job);
  }
}

std::int64_t this_target() { return HWY_TARGET; }

}  // namespace obscura::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace obscura {
namespace detail {
namespace {

HWY_EXPORT(run_batch);
HWY_EXPORT(this_target);

void run_on_this_machine(const BatchJob& job) noexcept { HWY_DYNAMIC_DISPATCH(run_batch)(job); }
std::int64_t target_of_this_machine() noexcept { return HWY_DYNAMIC_DISPATCH(this_target)(); }

// Larger trees than 32-bit offsets reach, and larger domains than floats step over, are walked in double.
constexpr std::size_t kMaxPackedBytes = std::size_t{1} << 31, kMaxFloatBytes = std::size_t{1} << 33;
constexpr int kMaxBatchLevel = 12;

// False where the scalar walk has to serve.
bool make_job(const Octree& tree, std::span<const double> weights, BatchJob& job) noexcept {
  const TreeData& data = tree.data();
  assert(weights.size() == data.channels.size());
  job.octree = &tree;
  job.tree = &data;
  job.all_weights = weights;
  for (std::size_t c = 0; c < weights.size(); ++c) {
    assert(weights[c] >= 0 && std::isfinite(weights[c]));
    if (weights[c] == 0) continue;
    if (job.channel_count == kMaxBatchChannels) return false;
    job.channels[static_cast<std::size_t>(job.channel_count)] = static_cast<int>(c);
    job.weights[static_cast<std::size_t>(job.channel_count++)] = weights[c];
  }
  return job.channel_count > 0 && data.record_bytes > 0 && data.top_level <= kMaxBatchLevel &&
         data.record_bytes < (data.lossless ? kMaxFloatBytes : kMaxPackedBytes);
}

}  // namespace
}  // namespace detail

void optical_depths(const Octree& tree, std::span<const Ray> index_rays, std::span<const double> weights,
                    std::span<double> depths) noexcept {
  assert(index_rays.size() == depths.size());
  detail::BatchJob job;
  if (!detail::make_job(tree, weights, job)) {
    for (std::size_t i = 0; i < index_rays.size(); ++i) depths[i] = optical_depth(tree, index_rays[i], weights);
    return;
  }
  job.count = index_rays.size();
  job.rays = index_rays.data();
  job.depths = depths.data();
  detail::run_on_this_machine(job);
}

void free_paths(const Octree& tree, std::span<const Flight> flights, std::span<const double> weights,
                std::span<FreePath> ends) noexcept {
  assert(flights.size() == ends.size());
  detail::BatchJob job;
  if (!detail::make_job(tree, weights, job)) {
    for (std::size_t i = 0; i < flights.size(); ++i) {
      ends[i] = free_path(tree, flights[i].ray, weights, flights[i].target_depth);
    }
    return;
  }
  job.count = flights.size();
  job.flights = flights.data();
  job.ends = ends.data();
  detail::run_on_this_machine(job);
}

std::string_view batch_target() { return hwy::TargetName(detail::target_of_this_machine()); }

std::vector<std::string_view> batch_targets() {
  std::vector<std::string_view> names;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) names.push_back(hwy::TargetName(target));
  return names;
}

bool force_batch_target(std::string_view name) {
  hwy::SetSupportedTargetsForTest(0);
  bool found = name.empty();
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    if (name != hwy::TargetName(target)) continue;
    hwy::SetSupportedTargetsForTest(target);
    found = true;
  }
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  return found;
}

}  // namespace obscura

#endif  // HWY_ONCE
