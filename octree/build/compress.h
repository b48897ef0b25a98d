// Makes a smaller tree of a lossless one: cells whose voxels hardly differ become one leaf, values are
// quantised to as few bits as a step needs. How far to go is build.cpp's decision.
#pragma once

#include <array>
#include <vector>

#include "octree/build/build.h"
#include "octree/build/collect.h"
#include "octree/tree/layout.h"

namespace obscura::detail {

/// Where in the tree's table a word is: its place along x, y and z, in words.
inline Vec3i table_place(const TreeData& tree, std::uint32_t index) noexcept {
  const int at = static_cast<int>(index);
  return {at % tree.size.x, at / tree.size.x % tree.size.y, at / (tree.size.x * tree.size.y)};
}

/// What merging a brick's cells would cost, per level 1, 2, 3: the largest over its cells of deviation from
/// the mean times the cell's longest chord, in optical depth or in emitted radiance.
struct BrickAnalysis {
  std::array<float, 3> cost{};
  float merge_deviation[3] = {0, 0, 0};  ///< largest deviation of the extinction, 1/m, after merging at that level
  float emission_deviation = 0;          ///< largest deviation of the emission after merging the whole brick
};

/// The lossless tree with what merging would cost everywhere. Made once, compressed several times.
struct Analysis {
  const TreeData* tree = nullptr;
  const ErrorMeasure* measure = nullptr;
  std::vector<BrickAnalysis> bricks;  ///< per block
  double voxel_chord_m = 0;           ///< longest diagonal of a voxel
  double largest_extinction = 0;      ///< 1/m, summed over channels

  bool emits() const noexcept { return static_cast<bool>(measure->emission); }
};
/// @pre `measure` has one weight per channel; both outlive the analysis
Analysis analyse(const TreeData& lossless, const ErrorMeasure& measure);

struct Compression {
  double merge_threshold = 0;  ///< largest cost of a merged cell
  double step = 0;             ///< of the quantised extinction, 1/m; > 0
};

struct Compressed {
  TreeData tree;
  double depth_bound = 0;  ///< no ray's optical depth differs by more
};
Compressed compress(const Analysis& analysis, const Compression& how);

/// Packs the values of a brick's leaves: as few bits as keep every value within half a step, zero exactly
/// zero where there is one, and the mean to 1e-6.
/// @param values (8 >> cell_level)^3 of them
/// @param step > 0; the largest distance of neighbouring quantised values
/// @param out receives packed_bytes() bytes at its end
ChannelHeader pack(std::span<const float> values, int cell_level, double step, std::vector<std::byte>& out,
                   std::size_t record_start);

}  // namespace obscura::detail
