#include "octree/build/compress.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <unordered_map>

namespace obscura::detail {
namespace {

constexpr std::size_t kChunk = 64;  // blocks that one task compresses

// One brick's values, decoded, and what becomes of them.
class Brick {
 public:
  Brick(const TreeData& tree, const ErrorMeasure& measure)
      : tree_(tree), measure_(measure), channels_(tree.channels.size()), values_(512 * channels_) {
    for (const double w : measure.optical_weight) attenuates_ = attenuates_ || w > 0;
  }

  void load(std::uint32_t word) {
    for (std::size_t c = 0; c < channels_; ++c) {
      unpack_brick(tree_.record(word), tree_.header(word, static_cast<int>(c)),
                   std::span<float, 512>(&values_[512 * c], 512));
    }
    if (!attenuates_ || !measure_.source) return;
    // What neither attenuates nor emits needs no other property either.
    std::vector<float> at(channels_);
    for (std::size_t i = 0; i < 512; ++i) {
      if (extinction(i) != 0) continue;
      bool any = false;
      for (std::size_t c = 0; c < channels_; ++c) any = any || (at[c] = values_[512 * c + i]) != 0;
      if (!any || measure_.source(at) != 0) continue;
      for (std::size_t c = 0; c < channels_; ++c) values_[512 * c + i] = 0;
    }
  }

  float value(std::size_t channel, std::size_t i) const { return values_[512 * channel + i]; }
  double extinction(std::size_t i) const {
    double sum = 0;
    for (std::size_t c = 0; c < channels_; ++c) {
      sum += measure_.optical_weight[c] * static_cast<double>(values_[512 * c + i]);
    }
    return sum;
  }
  double source(std::span<const float> values) const { return measure_.source ? measure_.source(values) : 0.0; }

  // Voxels of cell number `cell` of a level, all of them in the brick.
  template <class F>
  void for_each_voxel(int level, std::size_t cell, F&& f) const {
    const std::size_t bits = static_cast<std::size_t>(3 - level), mask = (std::size_t{1} << bits) - 1;
    const std::size_t side = std::size_t{1} << level;
    const std::size_t x0 = (cell & mask) << level, y0 = ((cell >> bits) & mask) << level,
                      z0 = (cell >> (2 * bits)) << level;
    for (std::size_t z = z0; z < z0 + side; ++z) {
      for (std::size_t y = y0; y < y0 + side; ++y) {
        for (std::size_t x = x0; x < x0 + side; ++x) f(x + 8 * y + 64 * z);
      }
    }
  }

  // What the voxels of a cell become when they are merged: means; of what does not attenuate, weighted by what does.
  void merged(int level, std::size_t cell, std::span<float> result) const {
    double weight = 0;
    if (level == 0) {
      for (std::size_t c = 0; c < channels_; ++c) result[c] = values_[512 * c + cell];
      return;
    }
    for_each_voxel(level, cell, [&](std::size_t i) { weight += extinction(i); });
    for (std::size_t c = 0; c < channels_; ++c) {
      double sum = 0;
      const bool weighted = measure_.optical_weight[c] == 0 && weight > 0;
      for_each_voxel(level, cell, [&](std::size_t i) {
        sum += static_cast<double>(value(c, i)) * (weighted ? extinction(i) : 1.0);
      });
      result[c] = static_cast<float>(sum / (weighted ? weight : std::ldexp(1.0, 3 * level)));
    }
  }

  // Largest deviations over a cell from the given values: extinction, source, and, where no source tells what it
  // matters, the relative one of what does not attenuate.
  struct Deviation {
    double extinction = 0, source = 0, relative = 0;
  };
  Deviation deviation(int level, std::size_t cell, std::span<const float> from, std::span<const double> sources) const {
    Deviation largest;
    const double source_from = sources.empty() ? 0.0 : source(from);
    for_each_voxel(level, cell, [&](std::size_t i) {
      double sum = 0;
      for (std::size_t c = 0; c < channels_; ++c) {
        const double v = static_cast<double>(value(c, i)), d = std::abs(v - static_cast<double>(from[c]));
        sum += measure_.optical_weight[c] * d;
        if (measure_.optical_weight[c] == 0 && sources.empty() && d > 0) {
          largest.relative =
              std::max(largest.relative, d / std::max(std::abs(v), std::abs(static_cast<double>(from[c]))));
        }
      }
      largest.extinction = std::max(largest.extinction, sum);
      if (!sources.empty()) largest.source = std::max(largest.source, std::abs(sources[i] - source_from));
    });
    return largest;
  }

  // Source of every voxel; nothing where there is none.
  void sources(std::vector<double>& result) const {
    result.clear();
    if (!measure_.source) return;
    result.resize(512);
    std::vector<float> at(channels_);
    for (std::size_t i = 0; i < 512; ++i) {
      for (std::size_t c = 0; c < channels_; ++c) at[c] = value(c, i);
      result[i] = source(at);
    }
  }

 private:
  const TreeData& tree_;
  const ErrorMeasure& measure_;
  std::size_t channels_;
  bool attenuates_ = false;
  std::vector<float> values_;
};

double longest_diagonal(const Affine& map) {
  double longest = 0;
  for (int k = 0; k < 4; ++k) {
    longest = std::max(longest, transform_direction(map, Vec3d(1, k & 1 ? 1 : -1, k & 2 ? 1 : -1)).length());
  }
  return longest;
}

// A chunk's records, before they have a place in the tree.
struct Chunk {
  std::vector<std::byte> records;
  std::vector<std::size_t> start;           // of each block's record; npos: uniform or empty
  std::vector<std::vector<float>> uniform;  // values of those that became uniform; empty where they vanished
  std::vector<double> deviation;            // of the extinction, 1/m
};
constexpr std::size_t kNowhere = ~std::size_t{0};

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

}  // namespace

Analysis analyse(const TreeData& lossless, const ErrorMeasure& measure) {
  assert(measure.optical_weight.size() == lossless.channels.size());
  Analysis analysis;
  analysis.tree = &lossless;
  analysis.measure = &measure;
  analysis.voxel_chord_m = longest_diagonal(lossless.index_to_local);
  analysis.bricks.resize(lossless.blocks.size());
  const std::size_t chunks = (lossless.blocks.size() + kChunk - 1) / kChunk;
  std::vector<double> largest(chunks, 0);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    Brick brick(lossless, measure);
    std::vector<double> sources;
    std::vector<float> merged(lossless.channels.size());
    for (std::size_t b = chunk * kChunk; b < std::min(lossless.blocks.size(), (chunk + 1) * kChunk); ++b) {
      const std::uint32_t word = lossless.table[lossless.blocks[b]];
      brick.load(word);
      const int level = lossless.header(word, 0).cell_level();
      for (std::size_t i = 0; i < (level >= 3 ? 1u : 512u); ++i)
        largest[chunk] = std::max(largest[chunk], brick.extinction(i));
      if (level >= 3) continue;
      brick.sources(sources);
      BrickAnalysis& result = analysis.bricks[b];
      const int at = static_cast<int>(lossless.blocks[b]);
      const Vec3i& size = lossless.size;
      const Vec3i corner = lossless.origin + 8 * Vec3i(at % size.x, at / size.x % size.y, at / (size.x * size.y));
      const bool overhangs = domain_volume(lossless.domain, {corner, 3}) != 512;
      for (int l = 1; l <= 3; ++l) {
        const std::size_t i = static_cast<std::size_t>(l - 1);
        const double chord = analysis.voxel_chord_m * (1 << l);
        double cost = l <= level ? 0 : overhangs ? kInfinity : 0;
        for (std::size_t cell = 0; cell < (std::size_t{512} >> (3 * l)) && cost < kInfinity && l > level; ++cell) {
          brick.merged(l, cell, merged);
          const Brick::Deviation d = brick.deviation(l, cell, merged, sources);
          cost = std::max(cost, std::max(std::max(d.extinction, d.source) * chord, d.relative));
          result.merge_deviation[i] =
              std::max(result.merge_deviation[i], static_cast<float>(d.extinction * (1 + 1e-6)));
          if (l == 3) result.source_deviation = static_cast<float>(d.source * (1 + 1e-6));
        }
        result.cost[i] = static_cast<float>(cost);
      }
    }
  });
  for (const double l : largest) analysis.largest_extinction = std::max(analysis.largest_extinction, l);
  return analysis;
}

Compressed compress(const Analysis& analysis, const Compression& how) {
  const TreeData& from = *analysis.tree;
  const ErrorMeasure& measure = *analysis.measure;
  const std::size_t channels = from.channels.size();
  const std::size_t blocks = from.blocks.size();

  // Every block by itself.
  std::vector<Chunk> chunks((blocks + kChunk - 1) / kChunk);
  tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t number) {
    Chunk& chunk = chunks[number];
    Brick brick(from, measure);
    std::vector<float> leaf(channels), leaves(512 * channels);
    std::vector<ChannelHeader> headers(channels);
    for (std::size_t b = number * kChunk; b < std::min(blocks, (number + 1) * kChunk); ++b) {
      const std::uint32_t word = from.table[from.blocks[b]];
      const BrickAnalysis& costs = analysis.bricks[b];
      brick.load(word);
      int level = from.header(word, 0).cell_level();
      chunk.uniform.emplace_back();
      chunk.start.push_back(kNowhere);
      chunk.deviation.push_back(0);
      double deviation = 0;
      for (int l = level + 1; l <= 3; ++l) {
        const std::size_t i = static_cast<std::size_t>(l - 1);
        if (!(static_cast<double>(costs.cost[i]) <= how.merge_threshold)) break;
        level = l;
        deviation = static_cast<double>(costs.merge_deviation[i]);
      }

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
      chunk.deviation.back() = deviation;
      if (!any) continue;
      if (level >= 3) {
        chunk.uniform.back() = leaf;
        continue;
      }
      const std::size_t start = chunk.records.size();
      chunk.start.back() = start;
      chunk.records.resize(start + channels * sizeof(ChannelHeader));
      for (std::size_t c = 0; c < channels; ++c) {
        const std::span<const float> values(&leaves[512 * c], count);
        const double weight = measure.optical_weight[c];
        headers[c] =
            pack(values, level, weight > 0 ? how.step / weight : sixteen_bit_step(values), chunk.records, start);
        if (headers[c].bits() == 0) {
          headers[c].meta = ChannelHeader::make_meta(0, level, c * sizeof(ChannelHeader));
        }
        // What quantising moved at most, as it will be read.
        std::memcpy(chunk.records.data() + start + c * sizeof(ChannelHeader), &headers[c], sizeof(ChannelHeader));
        if (weight == 0) continue;
        chunk.records.resize(chunk.records.size() + 4);
        double moved = 0;
        for (std::size_t i = 0; i < count; ++i) {
          const float read = unpack(chunk.records.data() + start, headers[c], static_cast<unsigned>(i));
          moved = std::max(moved, std::abs(static_cast<double>(read) - static_cast<double>(values[i])));
        }
        chunk.records.resize(chunk.records.size() - 4);
        chunk.deviation.back() += weight * moved;
        // The mean is over the part in the domain, not over the record.
        const float mean = from.header(word, static_cast<int>(c)).mean;
        std::memcpy(chunk.records.data() + start + c * sizeof(ChannelHeader) + offsetof(ChannelHeader, mean), &mean,
                    sizeof mean);
      }
      chunk.records.resize((chunk.records.size() + kRecordUnit - 1) / kRecordUnit * kRecordUnit);
    }
  });

  // Their places, in order.
  Compressed result;
  TreeData& tree = result.tree;
  tree.channels = from.channels;
  tree.index_to_local = from.index_to_local;
  tree.local_to_index = from.local_to_index;
  tree.domain = from.domain;
  tree.origin = from.origin;
  tree.size = from.size;
  tree.lossless = false;
  tree.table.assign(from.table.size(), Word::empty(3));
  RecordStore store;
  std::size_t bytes = 0;
  for (const Chunk& chunk : chunks) bytes += chunk.records.size();
  store.reserve(bytes + (std::size_t{1} << 12));
  UniformRecords uniform;
  struct Spread {
    double extinction = 0, source = 0;
  };
  std::unordered_map<std::uint32_t, Spread> spread;  // of a uniform record, over all that share it
  for (std::size_t b = 0; b < blocks; ++b) {
    Chunk& chunk = chunks[b / kChunk];
    const std::size_t i = b % kChunk;
    const int at = static_cast<int>(from.blocks[b]);
    if (chunk.start[i] != kNowhere) {
      std::size_t end = chunk.records.size();
      for (std::size_t k = i + 1; k < chunk.start.size(); ++k) {
        if (chunk.start[k] != kNowhere) {
          end = chunk.start[k];
          break;
        }
      }
      const std::uint32_t word = store.add(end - chunk.start[i]);
      std::memcpy(store.at(word), chunk.records.data() + chunk.start[i], end - chunk.start[i]);
      tree.table[static_cast<std::size_t>(at)] = word;
    } else if (!chunk.uniform[i].empty()) {
      const std::uint32_t word = uniform.word(store, 3, chunk.uniform[i]);
      Spread& s = spread[word];
      s.extinction = std::max(s.extinction, chunk.deviation[i]);
      s.source = std::max(s.source, static_cast<double>(analysis.bricks[b].source_deviation));
      const int side = 1 << (from.block_level(from.table[from.blocks[b]]) - 3);
      const Vec3i first(at % tree.size.x, at / tree.size.x % tree.size.y, at / (tree.size.x * tree.size.y));
      for (int z = first.z; z < std::min(first.z + side, tree.size.z); ++z) {
        for (int y = first.y; y < std::min(first.y + side, tree.size.y); ++y) {
          for (int x = first.x; x < std::min(first.x + side, tree.size.x); ++x) {
            tree.table[(static_cast<std::size_t>(z) * static_cast<std::size_t>(tree.size.y) +
                        static_cast<std::size_t>(y)) *
                           static_cast<std::size_t>(tree.size.x) +
                       static_cast<std::size_t>(x)] = word;
          }
        }
      }
    }
    if (i + 1 == chunk.start.size()) std::vector<std::byte>().swap(chunk.records);
  }

  // Uniform leaves merge further where their parent is as good as they are.
  std::mutex mutex;
  merge_leaves(
      tree,
      [&](std::uint32_t word) {
        const std::lock_guard lock(mutex);
        return reinterpret_cast<const ChannelHeader*>(store.at(word))[0].cell_level() >= 3;
      },
      [&](int level, std::span<const std::uint32_t, 8> children) {
        const std::lock_guard lock(mutex);
        const auto value = [&](std::size_t child, std::size_t c) {
          return Word::is_empty(children[child])
                     ? 0.0f
                     : reinterpret_cast<const ChannelHeader*>(store.at(children[child]))[c].offset;
        };
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
        Spread all;
        double relative = 0;
        const double source = analysis.emits() ? measure.source(merged) : 0;
        for (std::size_t k = 0; k < 8; ++k) {
          const Spread child = Word::is_empty(children[k]) ? Spread{} : spread[children[k]];
          double difference = 0;
          for (std::size_t c = 0; c < channels; ++c) {
            at[c] = value(k, c);
            const double d = std::abs(static_cast<double>(at[c]) - static_cast<double>(merged[c]));
            difference += measure.optical_weight[c] * d;
            if (measure.optical_weight[c] == 0 && !analysis.emits() && d > 0) {
              relative = std::max(relative, d / std::max(std::abs(static_cast<double>(at[c])),
                                                         std::abs(static_cast<double>(merged[c]))));
            }
          }
          all.extinction = std::max(all.extinction, child.extinction + difference);
          if (analysis.emits()) all.source = std::max(all.source, child.source + std::abs(measure.source(at) - source));
        }
        const double chord = analysis.voxel_chord_m * std::ldexp(1.0, level);
        if (!equal && !(std::max(std::max(all.extinction, all.source) * chord, relative) <= how.merge_threshold)) {
          return kNotMerged;
        }
        const std::uint32_t word = uniform.word(store, level, merged);
        Spread& s = spread[word];
        s.extinction = std::max(s.extinction, all.extinction);
        s.source = std::max(s.source, all.source);
        return word;
      });
  store.release_to(tree);
  finish(tree);

  // A ray that moves mostly along one axis crosses each layer of words across it once, on at most 8 voxel
  // diagonals: no ray's optical depth differs by more than the layers' largest deviations add up to.
  std::array<std::vector<double>, 3> layers;
  for (int axis = 0; axis < 3; ++axis)
    layers[static_cast<std::size_t>(axis)].assign(static_cast<std::size_t>(tree.size[axis]), 0);
  for (std::size_t b = 0; b < blocks; ++b) {
    const int at = static_cast<int>(from.blocks[b]);
    const Vec3i first(at % tree.size.x, at / tree.size.x % tree.size.y, at / (tree.size.x * tree.size.y));
    const int side = 1 << (from.block_level(from.table[from.blocks[b]]) - 3);
    double deviation = chunks[b / kChunk].deviation[b % kChunk];
    const std::uint32_t word = tree.table[static_cast<std::size_t>(at)];
    if (const auto found = spread.find(word); !Word::is_empty(word) && found != spread.end()) {
      deviation = std::max(deviation, found->second.extinction);
    }
    for (int axis = 0; axis < 3; ++axis) {
      for (int k = first[axis]; k < std::min(first[axis] + side, tree.size[axis]); ++k) {
        double& layer = layers[static_cast<std::size_t>(axis)][static_cast<std::size_t>(k)];
        layer = std::max(layer, deviation);
      }
    }
  }
  // Words that were empty and have been merged into a leaf.
  for (std::size_t b = 0; b < tree.blocks.size(); ++b) {
    const std::uint32_t word = tree.table[tree.blocks[b]];
    const auto found = spread.find(word);
    if (found == spread.end() || found->second.extinction == 0) continue;
    const int at = static_cast<int>(tree.blocks[b]);
    const Vec3i first(at % tree.size.x, at / tree.size.x % tree.size.y, at / (tree.size.x * tree.size.y));
    const int side = 1 << (tree.block_level(word) - 3);
    for (int axis = 0; axis < 3; ++axis) {
      for (int k = first[axis]; k < std::min(first[axis] + side, tree.size[axis]); ++k) {
        double& layer = layers[static_cast<std::size_t>(axis)][static_cast<std::size_t>(k)];
        layer = std::max(layer, found->second.extinction);
      }
    }
  }
  for (const std::vector<double>& axis : layers) {
    double sum = 0;
    for (const double layer : axis) sum += layer;
    result.depth_bound = std::max(result.depth_bound, sum * 8 * analysis.voxel_chord_m);
  }
  return result;
}

}  // namespace obscura::detail
