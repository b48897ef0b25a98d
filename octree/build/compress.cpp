// Compresses a tree in four steps: every brick by itself, then places for what has become of them, then uniform leaves
// are merged further, then a bound of what a ray can lose by all this.
#include "octree/build/compress.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <unordered_map>

#include "octree/build/brick_values.h"

namespace obscura::detail {
namespace {

constexpr std::size_t kChunk = 64;  // blocks that one task compresses
constexpr std::size_t kNowhere = ~std::size_t{0};

// A chunk's records, before they have a place in the tree.
struct Chunk {
  std::vector<std::byte> records;
  std::vector<std::size_t> start;           // of each block's record; kNowhere: uniform or empty
  std::vector<std::vector<float>> uniform;  // values of those that became uniform; empty where they vanished
  std::vector<double> deviation;            // of the extinction, 1/m
};

// How far the values of a leaf lie from those of the lossless tree, at most.
struct Spread {
  double extinction = 0;  // 1/m
  double emission = 0;    // as ErrorMeasure has it
};

// The uniform leaves of the tree to be.
struct UniformLeaves {
  RecordStore& store;
  UniformRecords records;
  std::unordered_map<std::uint32_t, Spread> spread;  // by word, over all leaves that share it

  std::uint32_t add(int level, std::span<const float> values, const Spread& of_leaf) {
    const std::uint32_t word = records.word(store, level, values);
    Spread& all = spread[word];
    all.extinction = std::max(all.extinction, of_leaf.extinction);
    all.emission = std::max(all.emission, of_leaf.emission);
    return word;
  }
};

// Quantising step of a channel that does not attenuate: its values in 16 bits, zeros apart.
double sixteen_bit_step(std::span<const float> values) {
  float min = kFloatMax, max = -kFloatMax;
  for (const float v : values) {
    if (v == 0) continue;
    min = std::min(min, v);
    max = std::max(max, v);
  }
  if (!(max > min)) return std::max(1e-30, std::abs(static_cast<double>(max)));
  return (static_cast<double>(max) - static_cast<double>(min)) / 65535;
}

// Step 1: every block by itself.

// The level of a block's leaves after merging, and how far merging moves the extinction (1/m).
struct Merging {
  int level;
  double deviation = 0;
};
Merging merge_brick(const BrickAnalysis& costs, int leaf_level, double threshold) {
  Merging result{leaf_level};
  for (int level = leaf_level + 1; level <= 3; ++level) {
    const std::size_t i = static_cast<std::size_t>(level - 1);
    if (!(static_cast<double>(costs.cost[i]) <= threshold)) break;
    result = {level, static_cast<double>(costs.merge_deviation[i])};
  }
  return result;
}

// Appends a brick's record: headers and packed values of all channels.
// @param leaves  512 places per channel, `count` of them in use
// @returns `deviation` and how far quantising moves the extinction at most, 1/m
double append_record(const TreeData& from, std::uint32_t word, const ErrorMeasure& measure, double step, int level,
                     std::span<const float> leaves, std::size_t count, double deviation,
                     std::vector<std::byte>& records) {
  const std::size_t channels = from.channels.size();
  const std::size_t start = records.size();
  records.resize(start + channels * sizeof(ChannelHeader));
  for (std::size_t c = 0; c < channels; ++c) {
    const std::span<const float> values = leaves.subspan(512 * c, count);
    const double weight = measure.optical_weight[c];
    ChannelHeader header = pack(values, level, weight > 0 ? step / weight : sixteen_bit_step(values), records, start);
    if (header.bits() == 0) header.meta = ChannelHeader::make_meta(0, level, c * sizeof(ChannelHeader));
    std::byte* const place = records.data() + start + c * sizeof(ChannelHeader);
    std::memcpy(place, &header, sizeof(ChannelHeader));
    if (weight == 0) continue;

    // What quantising moved at most, as the values will be read. unpack() reads 4 bytes at a time: some to spare.
    records.resize(records.size() + 4);
    double moved = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const float read = unpack(records.data() + start, header, static_cast<unsigned>(i));
      moved = std::max(moved, std::abs(static_cast<double>(read) - static_cast<double>(values[i])));
    }
    records.resize(records.size() - 4);
    deviation += weight * moved;

    // The mean is over the part in the domain, not over the record.
    const float mean = from.header(word, static_cast<int>(c)).mean;
    std::memcpy(records.data() + start + c * sizeof(ChannelHeader) + offsetof(ChannelHeader, mean), &mean, sizeof mean);
  }
  records.resize((records.size() + kRecordUnit - 1) / kRecordUnit * kRecordUnit);
  return deviation;
}

Chunk compress_chunk(const Analysis& analysis, const Compression& how, std::size_t first, std::size_t end) {
  const TreeData& from = *analysis.tree;
  const std::size_t channels = from.channels.size();
  Chunk chunk;
  BrickValues brick(from, *analysis.measure);
  std::vector<float> leaf(channels), leaves(512 * channels);
  for (std::size_t b = first; b < end; ++b) {
    const std::uint32_t word = from.table[from.blocks[b]];
    brick.load(word);
    const auto [level, deviation] =
        merge_brick(analysis.bricks[b], from.header(word, 0).cell_level(), how.merge_threshold);
    chunk.uniform.emplace_back();
    chunk.start.push_back(kNowhere);
    chunk.deviation.push_back(deviation);

    // Its leaves; none where nothing is left in it.
    const std::size_t count = level >= 3 ? 1 : std::size_t{512} >> (3 * level);
    bool any = false;
    for (std::size_t i = 0; i < count; ++i) {
      brick.merged(std::min(level, 3), i, leaf);
      for (std::size_t c = 0; c < channels; ++c) {
        leaves[512 * c + i] = leaf[c];
        any = any || leaf[c] != 0;
      }
    }
    if (!any) continue;
    if (level >= 3) {
      chunk.uniform.back() = leaf;
      continue;
    }
    chunk.start.back() = chunk.records.size();
    chunk.deviation.back() =
        append_record(from, word, *analysis.measure, how.step, level, leaves, count, deviation, chunk.records);
  }
  return chunk;
}

// Step 2: their places in the tree.

// A tree over the same lattice with nothing in it.
TreeData empty_tree_like(const TreeData& from) {
  TreeData tree;
  tree.channels = from.channels;
  tree.index_to_local = from.index_to_local;
  tree.local_to_index = from.local_to_index;
  tree.domain = from.domain;
  tree.origin = from.origin;
  tree.size = from.size;
  tree.lossless = false;
  tree.table.assign(from.table.size(), Word::empty(3));
  return tree;
}

// Calls f(x, y, z) for the places in the table that a block of a level takes, as far as the table goes.
template <class F>
void for_each_place(const TreeData& tree, std::uint32_t block, int level, F&& f) {
  const int side = 1 << (level - 3);
  const Vec3i first = table_place(tree, block);
  for (int z = first.z; z < std::min(first.z + side, tree.size.z); ++z) {
    for (int y = first.y; y < std::min(first.y + side, tree.size.y); ++y) {
      for (int x = first.x; x < std::min(first.x + side, tree.size.x); ++x) f(x, y, z);
    }
  }
}

// Bytes of a block's record in its chunk: up to the next one's.
std::size_t record_bytes(const Chunk& chunk, std::size_t i) {
  std::size_t end = chunk.records.size();
  for (std::size_t k = i + 1; k < chunk.start.size(); ++k) {
    if (chunk.start[k] != kNowhere) {
      end = chunk.start[k];
      break;
    }
  }
  return end - chunk.start[i];
}

// Puts records and uniform leaves into the store in the blocks' order, and their words into the table. The chunks'
// records are given up.
void place_blocks(const Analysis& analysis, std::vector<Chunk>& chunks, UniformLeaves& uniform, TreeData& tree) {
  const TreeData& from = *analysis.tree;
  std::size_t bytes = 0;
  for (const Chunk& chunk : chunks) bytes += chunk.records.size();
  uniform.store.reserve(bytes + (std::size_t{1} << 12));
  for (std::size_t b = 0; b < from.blocks.size(); ++b) {
    Chunk& chunk = chunks[b / kChunk];
    const std::size_t i = b % kChunk;
    const std::uint32_t block = from.blocks[b];
    if (chunk.start[i] != kNowhere) {
      const std::size_t size = record_bytes(chunk, i);
      const std::uint32_t word = uniform.store.add(size);
      std::memcpy(uniform.store.at(word), chunk.records.data() + chunk.start[i], size);
      tree.table[block] = word;
    } else if (!chunk.uniform[i].empty()) {
      const std::uint32_t word = uniform.add(
          3, chunk.uniform[i], {chunk.deviation[i], static_cast<double>(analysis.bricks[b].emission_deviation)});
      for_each_place(tree, block, from.block_level(from.table[block]), [&](int x, int y, int z) {
        tree.table[(static_cast<std::size_t>(z) * static_cast<std::size_t>(tree.size.y) + static_cast<std::size_t>(y)) *
                       static_cast<std::size_t>(tree.size.x) +
                   static_cast<std::size_t>(x)] = word;
      });
    }
    if (i + 1 == chunk.start.size()) std::vector<std::byte>().swap(chunk.records);
  }
}

// Step 3: uniform leaves merge further where their parent is as good as they are.

// The word of a cell whose eight children become one leaf, or kNotMerged where that would cost too much.
std::uint32_t merge_children(const Analysis& analysis, double threshold, int level,
                             std::span<const std::uint32_t, 8> children, UniformLeaves& uniform) {
  const ErrorMeasure& measure = *analysis.measure;
  const std::size_t channels = analysis.tree->channels.size();
  const auto value = [&](std::size_t child, std::size_t c) {
    return Word::is_empty(children[child])
               ? 0.0f
               : reinterpret_cast<const ChannelHeader*>(uniform.store.at(children[child]))[c].offset;
  };

  // The parent's values, as BrickValues::merged() has them.
  bool equal = true;
  double weights[8], weight = 0;
  std::vector<float> at(channels), merged(channels);
  for (std::size_t k = 0; k < 8; ++k) {
    equal = equal && children[k] == children[0];
    weights[k] = 0;
    for (std::size_t c = 0; c < channels; ++c)
      weights[k] += measure.optical_weight[c] * static_cast<double>(value(k, c));
    weight += weights[k];
  }
  for (std::size_t c = 0; c < channels; ++c) {
    const bool weighted = measure.optical_weight[c] == 0 && weight > 0;
    double sum = 0;
    for (std::size_t k = 0; k < 8; ++k) sum += static_cast<double>(value(k, c)) * (weighted ? weights[k] : 1.0);
    merged[c] = equal ? value(0, c) : static_cast<float>(sum / (weighted ? weight : 8.0));
  }

  // What the children stand for already, and how far they lie from the parent.
  Spread all;
  double relative = 0;
  const double emission = analysis.emits() ? measure.emission(merged) : 0;
  for (std::size_t k = 0; k < 8; ++k) {
    const Spread child = Word::is_empty(children[k]) ? Spread{} : uniform.spread[children[k]];
    double difference = 0;
    for (std::size_t c = 0; c < channels; ++c) {
      at[c] = value(k, c);
      const double d = std::abs(static_cast<double>(at[c]) - static_cast<double>(merged[c]));
      difference += measure.optical_weight[c] * d;
      if (measure.optical_weight[c] == 0 && !analysis.emits() && d > 0) {
        relative = std::max(
            relative, d / std::max(std::abs(static_cast<double>(at[c])), std::abs(static_cast<double>(merged[c]))));
      }
    }
    all.extinction = std::max(all.extinction, child.extinction + difference);
    if (analysis.emits())
      all.emission = std::max(all.emission, child.emission + std::abs(measure.emission(at) - emission));
  }
  const double chord = analysis.voxel_chord_m * std::ldexp(1.0, level);
  const double cost = std::max(std::max(all.extinction, all.emission) * chord, relative);
  if (!equal && !(cost <= threshold)) return kNotMerged;
  return uniform.add(level, merged, all);
}

void merge_uniform_leaves(const Analysis& analysis, double threshold, UniformLeaves& uniform, TreeData& tree) {
  std::mutex mutex;  // over `uniform`
  merge_leaves(
      tree,
      [&](std::uint32_t word) {
        const std::lock_guard lock(mutex);
        return reinterpret_cast<const ChannelHeader*>(uniform.store.at(word))[0].cell_level() >= 3;
      },
      [&](int level, std::span<const std::uint32_t, 8> children) {
        const std::lock_guard lock(mutex);
        return merge_children(analysis, threshold, level, children, uniform);
      });
}

// Step 4: the bound. A ray that moves mostly along one axis crosses each layer of words across it once, on at most 8
// voxel diagonals: no ray's optical depth differs by more than the layers' largest deviations add up to.
class Layers {
 public:
  explicit Layers(const Vec3i& size) : size_(size) {
    for (int axis = 0; axis < 3; ++axis)
      deviation_[static_cast<std::size_t>(axis)].assign(static_cast<std::size_t>(size[axis]), 0);
  }
  // A block whose extinction deviates so much, 1/m. @param side  in words
  void add(const Vec3i& first, int side, double deviation) {
    for (int axis = 0; axis < 3; ++axis) {
      for (int k = first[axis]; k < std::min(first[axis] + side, size_[axis]); ++k) {
        double& layer = deviation_[static_cast<std::size_t>(axis)][static_cast<std::size_t>(k)];
        layer = std::max(layer, deviation);
      }
    }
  }
  double largest_depth(double voxel_chord_m) const {
    double largest = 0;
    for (const std::vector<double>& axis : deviation_) {
      double sum = 0;
      for (const double layer : axis) sum += layer;
      largest = std::max(largest, sum * 8 * voxel_chord_m);
    }
    return largest;
  }

 private:
  Vec3i size_;
  std::array<std::vector<double>, 3> deviation_;  // per axis and layer, 1/m
};

double depth_bound(const Analysis& analysis, const std::vector<Chunk>& chunks, const UniformLeaves& uniform,
                   const TreeData& tree) {
  const TreeData& from = *analysis.tree;
  Layers layers(tree.size);
  for (std::size_t b = 0; b < from.blocks.size(); ++b) {
    const std::uint32_t block = from.blocks[b];
    const std::uint32_t word = tree.table[block];
    double deviation = chunks[b / kChunk].deviation[b % kChunk];
    if (const auto found = uniform.spread.find(word); !Word::is_empty(word) && found != uniform.spread.end()) {
      deviation = std::max(deviation, found->second.extinction);
    }
    layers.add(table_place(tree, block), 1 << (from.block_level(from.table[block]) - 3), deviation);
  }
  // Words that were empty and have been merged into a leaf.
  for (const std::uint32_t block : tree.blocks) {
    const std::uint32_t word = tree.table[block];
    const auto found = uniform.spread.find(word);
    if (found == uniform.spread.end() || found->second.extinction == 0) continue;
    layers.add(table_place(tree, block), 1 << (tree.block_level(word) - 3), found->second.extinction);
  }
  return layers.largest_depth(analysis.voxel_chord_m);
}

}  // namespace

Compressed compress(const Analysis& analysis, const Compression& how) {
  const std::size_t blocks = analysis.tree->blocks.size();
  std::vector<Chunk> chunks((blocks + kChunk - 1) / kChunk);
  tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t number) {
    chunks[number] = compress_chunk(analysis, how, number * kChunk, std::min(blocks, (number + 1) * kChunk));
  });

  Compressed result;
  result.tree = empty_tree_like(*analysis.tree);
  RecordStore store;
  UniformLeaves uniform{store, {}, {}};
  place_blocks(analysis, chunks, uniform, result.tree);
  merge_uniform_leaves(analysis, how.merge_threshold, uniform, result.tree);
  store.release_to(result.tree);
  finish(result.tree);
  result.depth_bound = depth_bound(analysis, chunks, uniform, result.tree);
  return result;
}

}  // namespace obscura::detail
