// What the lanes of the batched walk hold: vectors of one target's width, and what is loaded only where a lane
// changes blocks. For batch_walk.cpp, which Highway compiles once per target.
#if defined(OBSCURA_BATCH_LANES_TOGGLE) == defined(HWY_TARGET_TOGGLE)  // once per target
#ifdef OBSCURA_BATCH_LANES_TOGGLE
#undef OBSCURA_BATCH_LANES_TOGGLE
#else
#define OBSCURA_BATCH_LANES_TOGGLE
#endif

#include <cstddef>
#include <cstdint>

#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace obscura::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<DF>;
using DU = hn::RebindToUnsigned<DF>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;
using VU = hn::Vec<DU>;
using MF = hn::Mask<DF>;
constexpr std::size_t kMaxLanes = 16;

HWY_INLINE VI as_int(VU v) { return hn::BitCast(DI(), v); }
HWY_INLINE VU as_bits(VI v) { return hn::BitCast(DU(), v); }
HWY_INLINE MF float_mask(hn::Mask<DI> m) { return hn::RebindMask(DF(), m); }
HWY_INLINE hn::Mask<DI> int_mask(MF m) { return hn::RebindMask(DI(), m); }

// What a lane needs only where it enters and leaves a block.
struct Lanes {
  alignas(64) std::int32_t voxel[3][kMaxLanes];
  alignas(64) std::int32_t limit[3][kMaxLanes];
  alignas(64) std::int32_t mirror[3][kMaxLanes];
  alignas(64) std::int32_t word[kMaxLanes];  // of the block that is entered next
  alignas(64) std::int32_t block_end[3][kMaxLanes];
  alignas(64) float fraction[3][kMaxLanes];
  alignas(64) float direction[3][kMaxLanes];
  alignas(64) float inverse[3][kMaxLanes];
  alignas(64) float exit[3][kMaxLanes];  // time from the entry to the block's planes
  // Sums as unevaluated pairs of floats (Knuth's two-sum): length so far and depth so far.
  alignas(64) float length_left[2][kMaxLanes];
  alignas(64) float length_done[2][kMaxLanes];
  alignas(64) float depth[2][kMaxLanes];
  alignas(64) float target[kMaxLanes];  // depth left in this block, flights only
  alignas(64) std::int32_t collided[kMaxLanes];
  double t_enter[kMaxLanes], t_leave[kMaxLanes], per_t[kMaxLanes], target_depth[kMaxLanes];
  std::size_t number[kMaxLanes];  // of the ray
  bool cut[kMaxLanes];
};

// (high, low) += value, exactly but for the last rounding of low.
HWY_INLINE void add(DF d, float* high, float* low, VF value) {
  const VF a = hn::Load(d, high);
  const VF sum = hn::Add(a, value);
  const VF b = hn::Sub(sum, a);
  const VF error = hn::Add(hn::Sub(a, hn::Sub(sum, b)), hn::Sub(value, b));
  hn::Store(sum, d, high);
  hn::Store(hn::Add(hn::Load(d, low), error), d, low);
}

// What changes at every step, in registers meanwhile.
struct Moving {
  VF t, acc;               // time now; depth since the entry
  VF next0, next1, next2;  // times of the next planes
  VI index;                // the leaf's number (in bits, with one channel)
};

// What a lane needs at every step.
template <int kChannels>
struct Hot {
  VF t, end, limit, acc;  // time of the block's end, and a little before it
  VF next[3], delta[3];   // time from plane to plane
  VI stride[3], index;    // change of the leaf's number over a plane
  VI base[kChannels], bits[kChannels], mask[kChannels];
  VF offset[kChannels], scale[kChannels];
};

#define OBSCURA_UNROLL _Pragma("GCC unroll 3")

}  // namespace obscura::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // once per target
