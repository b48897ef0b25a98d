// What merging would cost, everywhere in a tree: one look at each brick, before any is compressed.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "octree/build/brick_values.h"
#include "octree/build/compress.h"

namespace obscura::detail {
namespace {

constexpr std::size_t kChunk = 64;  // blocks that one task analyses

double longest_diagonal(const Affine& map) {
  double longest = 0;
  for (int k = 0; k < 4; ++k) {
    longest = std::max(longest, transform_direction(map, Vec3d(1, k & 1 ? 1 : -1, k & 2 ? 1 : -1)).length());
  }
  return longest;
}

// Whether a part of the block lies outside the domain.
bool overhangs(const TreeData& tree, std::uint32_t block) {
  const Vec3i corner = tree.origin + 8 * table_place(tree, block);
  return domain_volume(tree.domain, {corner, 3}) != 512;
}

// What merging costs at each level above that of the brick's leaves. A brick that overhangs the domain is not merged:
// its leaf would spread over what is outside.
void analyse_brick(const BrickValues& brick, int leaf_level, bool overhangs, double voxel_chord_m,
                   const std::vector<double>& emissions, std::span<float> merged, BrickAnalysis& result) {
  for (int level = 1; level <= 3; ++level) {
    const std::size_t i = static_cast<std::size_t>(level - 1);
    const double chord = voxel_chord_m * (1 << level);
    double cost = level <= leaf_level ? 0 : overhangs ? kInfinity : 0;
    const std::size_t cells = std::size_t{512} >> (3 * level);
    for (std::size_t cell = 0; cell < cells && cost < kInfinity && level > leaf_level; ++cell) {
      brick.merged(level, cell, merged);
      const BrickValues::Deviation d = brick.deviation(level, cell, merged, emissions);
      cost = std::max(cost, std::max(std::max(d.extinction, d.emission) * chord, d.relative));
      // Rounded to float upwards: they are bounds.
      result.merge_deviation[i] = std::max(result.merge_deviation[i], static_cast<float>(d.extinction * (1 + 1e-6)));
      if (level == 3) result.emission_deviation = static_cast<float>(d.emission * (1 + 1e-6));
    }
    result.cost[i] = static_cast<float>(cost);
  }
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
    BrickValues brick(lossless, measure);
    std::vector<double> emissions;
    std::vector<float> merged(lossless.channels.size());
    for (std::size_t b = chunk * kChunk; b < std::min(lossless.blocks.size(), (chunk + 1) * kChunk); ++b) {
      const std::uint32_t word = lossless.table[lossless.blocks[b]];
      brick.load(word);
      const int level = lossless.header(word, 0).cell_level();
      for (std::size_t i = 0; i < (level >= 3 ? 1u : 512u); ++i)
        largest[chunk] = std::max(largest[chunk], brick.extinction(i));
      if (level >= 3) continue;
      brick.emissions(emissions);
      analyse_brick(brick, level, overhangs(lossless, lossless.blocks[b]), analysis.voxel_chord_m, emissions, merged,
                    analysis.bricks[b]);
    }
  });
  for (const double l : largest) analysis.largest_extinction = std::max(analysis.largest_extinction, l);
  return analysis;
}

}  // namespace obscura::detail
