// The batched walk's kernel. A lane carries one ray through one block after the other: the top table and the
// record's header are gathered when it enters a block, then it steps from leaf to leaf by a DDA of its own whose
// times count from the entry, so that floats stay small. Lanes that left their block wait until enough have.
#if defined(OBSCURA_BATCH_KERNEL_TOGGLE) == defined(HWY_TARGET_TOGGLE)  // once per target
#ifdef OBSCURA_BATCH_KERNEL_TOGGLE
#undef OBSCURA_BATCH_KERNEL_TOGGLE
#else
#define OBSCURA_BATCH_KERNEL_TOGGLE
#endif

#include "hwy/cache_control.h"
#include "hwy/highway.h"
#include "octree/tree/batch_lane.h"
#include "octree/tree/batch_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace obscura::detail::HWY_NAMESPACE {

// kFloats: the tree is lossless, values are floats; else they are packed.
template <bool kFloats, bool kFlights, int kChannels>
class BatchKernel {
 public:
  BatchKernel(const BatchJob& job, std::size_t& next_ray)
      : job_(job),
        tree_(*job.tree),
        table_(reinterpret_cast<const std::int32_t*>(tree_.table.data())),
        records_(reinterpret_cast<const float*>(tree_.records())),
        next_ray_(next_ray) {
    const DF d;
    for (std::size_t lane = 0; lane < kMaxLanes; ++lane) kill(lane);
    hot_.t = hot_.end = hot_.limit = hot_.acc = hn::Zero(d);
    hot_.index = hn::Zero(DI());
    OBSCURA_UNROLL
    for (int a = 0; a < 3; ++a) {
      hot_.next[a] = hot_.delta[a] = hn::Set(d, kParallel);
      hot_.stride[a] = hn::Zero(DI());
    }
    for (int c = 0; c < kChannels; ++c) {
      hot_.base[c] = hot_.bits[c] = hot_.mask[c] = hn::Zero(DI());
      hot_.offset[c] = hot_.scale[c] = hn::Zero(d);
    }
    for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
      if (refill(lane)) alive_ |= std::uint32_t{1} << lane;
    }
    if (alive_) look_up(alive_);
  }

  bool alive() const { return alive_ != 0; }

  /// Enters the blocks that were looked up, walks until enough lanes have left theirs, looks up the next.
  void advance() {
    enter_blocks(entering_);
    Moving m{hot_.t, hot_.acc, hot_.next[0], hot_.next[1], hot_.next[2], hot_.index};
    for (;;) {
      const std::uint32_t waiting = waiting_bits(m) & alive_;
      if (hwy::PopCount(waiting) >= kPatience || waiting == alive_) {
        put_back(m);
        leave_blocks(waiting);
        return;
      }
      OBSCURA_UNROLL
      for (int k = 0; k < kSteps; ++k) step(m);
    }
  }

 private:
  // Lanes that wait before blocks are changed, and steps between the looks.
  static constexpr std::size_t kPatience = HWY_MAX(1, hn::MaxLanes(DF()) / 2);
  static constexpr int kSteps = 3;
  // Cache lines of a record that are fetched ahead.
  static constexpr std::size_t kPrefetch = kFloats ? 8 : 4;

  HWY_INLINE void put_back(const Moving& m) {
    hot_.t = m.t;
    hot_.acc = m.acc;
    hot_.next[0] = m.next0;
    hot_.next[1] = m.next1;
    hot_.next[2] = m.next2;
    hot_.index = m.index;
  }

  HWY_INLINE std::uint32_t waiting_bits(const Moving& m) const {
    std::uint8_t bits[8] = {0};
    hn::StoreMaskBits(DF(), hn::Ge(m.t, hot_.limit), bits);
    return bits[0] | static_cast<std::uint32_t>(bits[1]) << 8;
  }

  // The weighted value of each lane's leaf.
  HWY_INLINE VF leaf_value(VI index) const {
    const DF d;
    const DI di;
    VF value = hn::Zero(d);
    for (int c = 0; c < kChannels; ++c) {
      VF one;
      if (kFloats) {
        const VI at =
            kChannels == 1 ? hn::Add(hot_.base[c], index) : hn::Add(hot_.base[c], hn::And(index, hot_.mask[c]));
        one = hn::Mul(hn::GatherIndex(d, records_, at), hot_.scale[c]);
      } else {
        const VI bit = kChannels == 1 ? index : hn::Mul(index, hot_.bits[c]);
        const VI at = hn::Add(hot_.base[c], hn::ShiftRight<3>(bit));
        const VI word = hn::GatherOffset(di, reinterpret_cast<const std::int32_t*>(records_), at);
        const VI shift = hn::And(bit, hn::Set(di, 7));
        const VI q = hn::And(as_int(hn::Shr(as_bits(word), as_bits(shift))), hot_.mask[c]);
        one = hn::MulAdd(hot_.scale[c], hn::ConvertTo(d, q), hot_.offset[c]);
      }
      value = c == 0 ? one : hn::Add(value, one);
    }
    return value;
  }

  template <int kAxis>
  HWY_INLINE void cross(Moving& m, VF& next, VF crossed) const {
    const MF over = hn::Le(next, crossed);
    next = hn::Add(next, hn::IfThenElseZero(over, hot_.delta[kAxis]));
    m.index = hn::Add(m.index, hn::IfThenElseZero(int_mask(over), hot_.stride[kAxis]));
  }

  // Every lane goes on to the next leaf of its block; lanes at the block's end stay.
  HWY_INLINE void step(Moving& m) {
    const DF d;
    const VF nearest = hn::Min(hn::Min(m.next0, m.next1), m.next2);
    const MF at_end = hn::Ge(nearest, hot_.limit);
    const VF to = hn::IfThenElse(at_end, hot_.end, nearest);
    const VF value = leaf_value(m.index);
    const VF depth = hn::MulAdd(value, hn::Sub(to, m.t), m.acc);
    if (kFlights) {
      const VF target = hn::Load(d, lanes_.target);
      const MF hit = hn::And(hn::Ge(depth, target), hn::Lt(m.t, hot_.limit));
      if (HWY_UNLIKELY(!hn::AllFalse(d, hit))) {
        put_back(m);
        collide(hit, value, to, target);
        m = Moving{hot_.t, hot_.acc, hot_.next[0], hot_.next[1], hot_.next[2], hot_.index};
        return;
      }
    }
    m.acc = depth;
    const VF crossed = hn::IfThenElse(at_end, hn::Set(d, -1.0f), nearest);
    cross<0>(m, m.next0, crossed);
    cross<1>(m, m.next1, crossed);
    cross<2>(m, m.next2, crossed);
    m.t = to;
  }

  // Some lanes reach their target depth in this leaf; the others stay for the next step.
  HWY_NOINLINE void collide(MF hit, VF value, VF to, VF target) {
    const DF d;
    const VF width = hn::Sub(to, hot_.t);
    const VF inside = hn::Div(hn::Sub(target, hot_.acc), hn::IfThenElse(hit, value, hn::Set(d, 1.0f)));
    // Not so near to a plane that rounding puts it into the next leaf.
    const VF margin = hn::Mul(width, hn::Set(d, 2e-5f));
    const VF where = hn::Add(hot_.t, hn::Min(hn::Max(inside, margin), hn::Sub(width, margin)));
    end_at(hit, where);
    hot_.acc = hn::IfThenElse(hit, target, hot_.acc);
    const DI di;
    hn::Store(hn::IfThenElse(int_mask(hit), hn::Set(di, 1), hn::Load(di, lanes_.collided)), di, lanes_.collided);
  }

  // These lanes' blocks end here.
  HWY_INLINE void end_at(MF which, VF where) {
    hot_.t = hn::IfThenElse(which, where, hot_.t);
    hot_.end = hn::IfThenElse(which, where, hot_.end);
    hot_.limit = hn::IfThenElse(which, where, hot_.limit);
    OBSCURA_UNROLL
    for (int a = 0; a < 3; ++a) hot_.next[a] = hn::IfThenElse(which, hn::Set(DF(), kParallel), hot_.next[a]);
  }

  MF mask_of(std::uint32_t bits) const {
    const std::uint8_t bytes[8] = {static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8)};
    return hn::LoadMaskBits(DF(), bytes);
  }

  // Lanes at the end of their blocks: add up, move on, take new rays where the old ones end, enter the next blocks.
  HWY_NOINLINE void leave_blocks(std::uint32_t bits) {
    const DF d;
    const DI di;
    const MF which = mask_of(bits);
    add(d, lanes_.depth[0], lanes_.depth[1], hn::IfThenElseZero(which, hot_.acc));
    const VF width = hn::IfThenElseZero(which, hot_.end);
    add(d, lanes_.length_done[0], lanes_.length_done[1], width);
    add(d, lanes_.length_left[0], lanes_.length_left[1], hn::Neg(width));
    const VF left = hn::Add(hn::Load(d, lanes_.length_left[0]), hn::Load(d, lanes_.length_left[1]));
    MF done = hn::Le(left, hn::Zero(d));
    if (kFlights) done = hn::Or(done, float_mask(hn::Ne(hn::Load(di, lanes_.collided), hn::Zero(di))));

    // Across the planes that were reached; elsewhere the voxel follows from the way gone.
    OBSCURA_UNROLL
    for (int a = 0; a < 3; ++a) {
      const VF fraction = hn::Load(d, lanes_.fraction[a]);
      const VI voxel = hn::Load(di, lanes_.voxel[a]), block_end = hn::Load(di, lanes_.block_end[a]);
      const VF way = hn::MulAdd(hn::Load(d, lanes_.direction[a]), width, fraction);
      const VI whole = hn::ConvertTo(di, way);
      VI next_voxel = hn::Add(voxel, whole);
      VF next_fraction = hn::Sub(way, hn::ConvertTo(d, whole));
      const hn::Mask<DI> beyond = hn::Not(hn::Lt(next_voxel, block_end));
      next_voxel = hn::IfThenElse(beyond, hn::Sub(block_end, hn::Set(di, 1)), next_voxel);
      next_fraction = hn::IfThenElse(float_mask(beyond), hn::Set(d, kBelowOne), next_fraction);
      const MF through = hn::Le(hn::Load(d, lanes_.exit[a]), width);
      next_voxel = hn::IfThenElse(int_mask(through), block_end, next_voxel);
      next_fraction = hn::IfThenElseZero(hn::Not(through), next_fraction);
      next_voxel = hn::IfThenElse(int_mask(which), next_voxel, voxel);
      hn::Store(next_voxel, di, lanes_.voxel[a]);
      hn::Store(hn::IfThenElse(which, next_fraction, fraction), d, lanes_.fraction[a]);
      done = hn::Or(done, float_mask(hn::Not(hn::Lt(next_voxel, hn::Load(di, lanes_.limit[a])))));
    }

    std::uint8_t bytes[8] = {0};
    hn::StoreMaskBits(d, done, bytes);
    std::uint32_t finished = (bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8) & bits;
    while (finished) {
      const std::size_t lane = hwy::Num0BitsBelowLS1Bit_Nonzero32(finished);
      finished &= finished - 1;
      finish(lane);
      if (!refill(lane)) {
        kill(lane);
        bits &= ~(std::uint32_t{1} << lane);
      }
    }
    entering_ = 0;
    if (bits) look_up(bits);
  }

  // Finds the words of the blocks in which these lanes are, and has their records fetched meanwhile.
  HWY_INLINE void look_up(std::uint32_t bits) {
    const DI di;
    const std::int32_t strides[3] = {1, tree_.size.x, tree_.size.x * tree_.size.y};
    const VI whole = hn::Set(di, (1 << (tree_.top_level - 3)) - 1);
    VI at = hn::Zero(di);
    OBSCURA_UNROLL
    for (int a = 0; a < 3; ++a) {
      const VI voxel = hn::Load(di, lanes_.voxel[a]), mirror = hn::Load(di, lanes_.mirror[a]);
      const VI brick = hn::And(hn::Xor(hn::ShiftRight<3>(voxel), mirror), whole);
      at = a == 0 ? brick : hn::Add(at, hn::Mul(brick, hn::Set(di, strides[a])));
    }
    at = hn::IfThenElseZero(int_mask(mask_of(bits)), at);
    const VI word = hn::GatherIndex(di, table_, at);
    hn::Store(word, di, lanes_.word);
    entering_ = bits;
    for (; bits; bits &= bits - 1) {
      const std::int32_t w = lanes_.word[hwy::Num0BitsBelowLS1Bit_Nonzero32(bits)];
      if (w < 0) continue;
      const float* record = records_ + 4 * static_cast<std::size_t>(w);
      for (std::size_t line = 0; line < kPrefetch; ++line) hwy::Prefetch(record + 16 * line);
    }
  }

  // Sets these lanes up in the blocks that were looked up.
  HWY_INLINE void enter_blocks(std::uint32_t which_bits) {
    const DF d;
    const DI di;
    const MF which = mask_of(which_bits);
    const VI one = hn::Set(di, 1);
    VI voxel[3], mirror[3];
    OBSCURA_UNROLL
    for (int a = 0; a < 3; ++a) {
      voxel[a] = hn::Load(di, lanes_.voxel[a]);
      mirror[a] = hn::Load(di, lanes_.mirror[a]);
    }
    const VI word = hn::Load(di, lanes_.word);
    const hn::Mask<DI> empty = hn::Lt(word, hn::Zero(di));

    // Record 0 stands for an empty leaf's, which has none.
    const VI record = hn::IfThenZeroElse(empty, hn::ShiftLeft<2>(word));
    VI leaf_level = hn::Zero(di);
    VF uniform_value = hn::Zero(d);
    VI bits_of[kChannels];
    for (int c = 0; c < kChannels; ++c) {
      const VI header = hn::Add(record, hn::Set(di, 4 * job_.channels[static_cast<std::size_t>(c)]));
      const VF offset = hn::GatherIndex(d, records_, header);
      const VI meta = hn::GatherIndex(di, reinterpret_cast<const std::int32_t*>(records_) + 3, header);
      const VF weight = hn::Set(d, static_cast<float>(job_.weights[static_cast<std::size_t>(c)]));
      const VI data = hn::Add(record, as_int(hn::ShiftRight<11>(as_bits(meta))));
      const VI bits = hn::And(meta, hn::Set(di, 63));
      bits_of[c] = bits;
      if (c == 0) leaf_level = hn::And(as_int(hn::ShiftRight<6>(as_bits(meta))), hn::Set(di, 31));
      const VF weighted = hn::Mul(offset, weight);
      uniform_value = hn::Add(uniform_value, weighted);
      const hn::Mask<DI> w = int_mask(which);
      if (kFloats) {
        hot_.base[c] = hn::IfThenElse(w, data, hot_.base[c]);
        hot_.scale[c] = weight;
        if (kChannels > 1)
          hot_.mask[c] = hn::IfThenElse(w, hn::VecFromMask(di, hn::Ne(bits, hn::Zero(di))), hot_.mask[c]);
      } else {
        const VF scale = hn::Mul(hn::GatherIndex(d, records_ + 1, header), weight);
        hot_.base[c] = hn::IfThenElse(w, hn::ShiftLeft<2>(data), hot_.base[c]);
        hot_.bits[c] = hn::IfThenElse(w, bits, hot_.bits[c]);
        hot_.mask[c] = hn::IfThenElse(w, hn::Sub(hn::Shl(one, bits), one), hot_.mask[c]);
        hot_.offset[c] = hn::IfThenElse(which, weighted, hot_.offset[c]);
        hot_.scale[c] = hn::IfThenElse(which, scale, hot_.scale[c]);
      }
    }
    leaf_level = hn::IfThenElse(empty, hn::And(word, hn::Set(di, 31)), leaf_level);
    uniform_value = hn::IfThenElseZero(hn::Not(float_mask(empty)), uniform_value);
    const VI block_level = hn::Max(leaf_level, hn::Set(di, 3));

    // Times from here to the block's planes and to the leaf's; the leaf's number.
    const VI block_size = hn::Shl(one, block_level), leaf_size = hn::Shl(one, leaf_level);
    const VF leaf_width = hn::ConvertTo(d, leaf_size);
    // An empty leaf may be one of many: from this brick on, a cube as large as the distance tells is empty too.
    const VI seven = hn::Set(di, 7);
    const VI clear = hn::IfThenElseZero(
        empty, hn::And(as_int(hn::ShiftRight<2>(as_bits(word))), hn::Set(di, 8 * Word::kMaxDistance)));
    const hn::Mask<DI> is_clear = hn::And(empty, hn::Not(hn::Lt(clear, block_size)));
    VF block_time = hn::Set(d, kParallel);
    VF next[3];
    VI leaf[3];
    OBSCURA_UNROLL
    for (int a = 0; a < 3; ++a) {
      const VF fraction = hn::Load(d, lanes_.fraction[a]), inverse = hn::Load(d, lanes_.inverse[a]);
      const VI in_block = hn::And(voxel[a], hn::Sub(block_size, one));
      const VI to_end =
          hn::IfThenElse(is_clear, hn::Sub(clear, hn::And(voxel[a], seven)), hn::Sub(block_size, in_block));
      const VF exit = hn::Mul(hn::Sub(hn::ConvertTo(d, to_end), fraction), inverse);
      hn::Store(hn::IfThenElse(which, exit, hn::Load(d, lanes_.exit[a])), d, lanes_.exit[a]);
      hn::Store(hn::IfThenElse(int_mask(which), hn::Add(voxel[a], to_end), hn::Load(di, lanes_.block_end[a])), di,
                lanes_.block_end[a]);
      block_time = hn::Min(block_time, exit);
      const VI in_leaf = hn::And(in_block, hn::Sub(leaf_size, one));
      next[a] = hn::Mul(hn::Sub(hn::ConvertTo(d, hn::Sub(leaf_size, in_leaf)), fraction), inverse);
      hot_.delta[a] = hn::IfThenElse(which, hn::Mul(leaf_width, inverse), hot_.delta[a]);
      leaf[a] = as_int(hn::Shr(as_bits(in_block), as_bits(leaf_level)));
    }
    const VF left = hn::Add(hn::Load(d, lanes_.length_left[0]), hn::Load(d, lanes_.length_left[1]));
    block_time = hn::Min(block_time, left);

    // Leaves of a brick are numbered x fastest; a mirrored axis counts down.
    const hn::Mask<DI> in_brick = hn::Lt(leaf_level, hn::Set(di, 3));
    const VI side_bits = hn::Sub(hn::Set(di, 3), hn::Min(leaf_level, hn::Set(di, 3)));
    const VI side_mask = hn::Sub(hn::Shl(one, side_bits), one);
    VI number = hn::Zero(di), stride = one;
    if (kChannels == 1) stride = kFloats ? hn::IfThenElseZero(hn::Ne(bits_of[0], hn::Zero(di)), one) : bits_of[0];
    const VI unit = stride;
    OBSCURA_UNROLL
    for (int a = 0; a < 3; ++a) {
      const VI coordinate = hn::And(hn::Xor(leaf[a], mirror[a]), side_mask);
      number = hn::Add(number, hn::Shl(coordinate, a == 0   ? hn::Zero(di)
                                                   : a == 1 ? side_bits
                                                            : hn::Add(side_bits, side_bits)));
      const VI signed_stride = hn::Sub(hn::Xor(stride, mirror[a]), mirror[a]);
      hot_.stride[a] = hn::IfThenElse(int_mask(which), signed_stride, hot_.stride[a]);
      stride = hn::Shl(stride, side_bits);
    }
    if (kChannels == 1) number = hn::Mul(number, unit);
    number = hn::IfThenElseZero(in_brick, number);
    hot_.index = hn::IfThenElse(int_mask(which), number, hot_.index);

    // A uniform or empty leaf is crossed at once.
    const MF stepping = float_mask(in_brick);
    VF acc = hn::IfThenElseZero(hn::Not(stepping), hn::Mul(uniform_value, block_time));
    if (kFlights) {
      const VF target = hn::IfThenElse(which, targets(which_bits), hn::Load(d, lanes_.target));
      hn::Store(target, d, lanes_.target);
      const MF hit =
          hn::And(hn::And(which, hn::Not(stepping)), hn::And(hn::Ge(acc, target), hn::Gt(uniform_value, hn::Zero(d))));
      if (!hn::AllFalse(d, hit)) {
        const VF inside = hn::Div(target, hn::IfThenElse(hit, uniform_value, hn::Set(d, 1.0f)));
        const VF margin = hn::Mul(block_time, hn::Set(d, 2e-5f));
        block_time = hn::IfThenElse(hit, hn::Min(hn::Max(inside, margin), hn::Sub(block_time, margin)), block_time);
        acc = hn::IfThenElse(hit, target, acc);
        hn::Store(hn::IfThenElse(int_mask(hit), one, hn::Load(di, lanes_.collided)), di, lanes_.collided);
      }
    }
    hot_.acc = hn::IfThenElse(which, acc, hot_.acc);
    hot_.end = hn::IfThenElse(which, block_time, hot_.end);
    // Times of planes are sums of rounded ones: so near to its end a block is at its end.
    hot_.limit = hn::IfThenElse(which, hn::Mul(block_time, hn::Set(d, 1.0f - 3e-6f)), hot_.limit);
    hot_.t = hn::IfThenElse(which, hn::IfThenElseZero(hn::Not(stepping), block_time), hot_.t);
    OBSCURA_UNROLL
    for (int a = 0; a < 3; ++a) {
      hot_.next[a] = hn::IfThenElse(which, hn::IfThenElse(stepping, next[a], hn::Set(d, kParallel)), hot_.next[a]);
    }
  }

  // Depth that is left to these flights, in the lanes' precision.
  VF targets(std::uint32_t bits) {
    alignas(64) float left[kMaxLanes];
    for (std::size_t lane = 0; lane < kMaxLanes; ++lane) {
      left[lane] = 0;
      if (!(bits >> lane & 1u)) continue;
      const double depth = static_cast<double>(lanes_.depth[0][lane]) + static_cast<double>(lanes_.depth[1][lane]);
      left[lane] = static_cast<float>(lanes_.target_depth[lane] - depth);
    }
    return hn::Load(DF(), left);
  }

  void finish(std::size_t lane) {
    const double depth = static_cast<double>(lanes_.depth[0][lane]) + static_cast<double>(lanes_.depth[1][lane]);
    const std::size_t i = lanes_.number[lane];
    if (!kFlights) {
      job_.depths[i] = depth / lanes_.per_t[lane];
      return;
    }
    FreePath& end = job_.ends[i];
    end.collided = lanes_.collided[lane] != 0;
    const double length =
        static_cast<double>(lanes_.length_done[0][lane]) + static_cast<double>(lanes_.length_done[1][lane]);
    end.t = end.collided ? lanes_.t_enter[lane] + length / lanes_.per_t[lane] : lanes_.t_leave[lane];
    end.depth = end.collided ? job_.flights[i].target_depth : depth / lanes_.per_t[lane];
  }

  // The next ray that meets the domain; false when there is none.
  bool refill(std::size_t lane) {
    LaneRay ray;
    while (next_ray_ < job_.count) {
      const std::size_t i = next_ray_++;
      if (prepare_lane(tree_, job_.ray(i), ray) != Prepared::lane) {
        if (kFlights) {
          job_.ends[i] = free_path(*job_.octree, job_.ray(i), job_.all_weights, job_.flights[i].target_depth);
        } else {
          job_.depths[i] = optical_depth(*job_.octree, job_.ray(i), job_.all_weights);
        }
        continue;
      }
      OBSCURA_UNROLL
      for (int a = 0; a < 3; ++a) {
        lanes_.voxel[a][lane] = ray.voxel[a];
        lanes_.limit[a][lane] = ray.limit[a];
        lanes_.mirror[a][lane] = ray.mirror[a];
        lanes_.block_end[a][lane] = 0;
        lanes_.fraction[a][lane] = ray.fraction[a];
        lanes_.direction[a][lane] = ray.direction[a];
        lanes_.inverse[a][lane] = ray.inverse[a];
        lanes_.exit[a][lane] = kParallel;
      }
      // A ray that leaves the domain is ended by its faces, not by its length.
      const float length = ray.cut ? static_cast<float>(ray.length) : kParallel;
      lanes_.length_left[0][lane] = length;
      lanes_.length_left[1][lane] = ray.cut ? static_cast<float>(ray.length - static_cast<double>(length)) : 0.0f;
      for (int k = 0; k < 2; ++k) lanes_.length_done[k][lane] = lanes_.depth[k][lane] = 0;
      lanes_.target[lane] = 0;
      lanes_.collided[lane] = 0;
      lanes_.t_enter[lane] = ray.t_enter;
      lanes_.t_leave[lane] = ray.t_enter + ray.length / ray.per_t;
      lanes_.per_t[lane] = ray.per_t;
      lanes_.number[lane] = i;
      if (kFlights) lanes_.target_depth[lane] = job_.flights[i].target_depth * ray.per_t;
      return true;
    }
    return false;
  }

  // A lane without a ray stays at a voxel that exists and is at its end for ever.
  void kill(std::size_t lane) {
    alive_ &= ~(std::uint32_t{1} << lane);
    lanes_.word[lane] = static_cast<std::int32_t>(Word::empty(3));
    OBSCURA_UNROLL
    for (int a = 0; a < 3; ++a) {
      lanes_.voxel[a][lane] = lanes_.mirror[a][lane] = lanes_.block_end[a][lane] = 0;
      lanes_.limit[a][lane] = 1;
      lanes_.fraction[a][lane] = 0;
      lanes_.direction[a][lane] = 0;
      lanes_.inverse[a][lane] = lanes_.exit[a][lane] = kParallel;
    }
    for (int k = 0; k < 2; ++k) {
      lanes_.length_left[k][lane] = lanes_.length_done[k][lane] = lanes_.depth[k][lane] = 0;
    }
    lanes_.target[lane] = kParallel;
    lanes_.collided[lane] = 0;
  }

  const BatchJob& job_;
  const TreeData& tree_;
  const std::int32_t* table_;
  const float* records_;
  Lanes lanes_;
  std::size_t& next_ray_;
  std::uint32_t alive_ = 0;     // lanes that have a ray
  std::uint32_t entering_ = 0;  // lanes whose blocks were looked up

  Hot<kChannels> hot_;
};

}  // namespace obscura::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // once per target
