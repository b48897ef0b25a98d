// Queries of the octree: values, bounds, leaves, blocks, statistics, against the voxels they came from.
#include "octree/tree/octree.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "octree/build/build.h"
#include "tests/support/voxel_fields.h"

using namespace obscura;
using namespace obscura::test;

namespace {

const Box3i kDomain(Vec3i(-13, -45, 5), Vec3i(61, 20, 76));

Octree patchwork_tree(double tolerance, const Box3i& domain = kDomain) {
  BuildSettings settings;
  settings.tolerance = tolerance;
  settings.measure.optical_weight = {0.02, 0.01};
  return build_octree(field_stream(domain, {"soot", "water"}, patchwork(21)), settings).first;
}

bool inside(const Box3i& box, const Vec3i& v) {
  for (int a = 0; a < 3; ++a) {
    if (v[a] < box.min[a] || v[a] >= box.max[a]) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("a lossless octree returns every voxel", "[octree][not_finite]") {
  const Octree tree = patchwork_tree(0);
  const Field field = patchwork(21);
  std::uint64_t wrong = 0;
  Box3i wider(kDomain.min - Vec3i(3), kDomain.max + Vec3i(3));
  for (int z = wider.min.z; z < wider.max.z; ++z) {
    for (int y = wider.min.y; y < wider.max.y; ++y) {
      for (int x = wider.min.x; x < wider.max.x; ++x) {
        const Vec3i v(x, y, z);
        for (int c = 0; c < 2; ++c) {
          const float expected = inside(kDomain, v) ? field(c, v) : 0.0f;
          wrong += tree.value(c, Vec3d(v)) != expected;  // the face below belongs to it
          wrong += tree.value(c, Vec3d(x + 0.999999, y + 0.5, z + 0.25)) != expected;
        }
      }
    }
  }
  CHECK(wrong == 0);
  CHECK(tree.value(0, Vec3d(std::nan(""), 0, 10)) == 0);
  CHECK(tree.value(0, Vec3d(kInfinity, 0, 10)) == 0);
}

TEST_CASE("bounds bound every voxel below and means are means, at every level", "[octree][bounds]") {
  const double tolerance = GENERATE(0.0, 3e-3);
  const Octree tree = patchwork_tree(tolerance);
  for (int level = 0; level <= tree.top_level(); ++level) {
    const int size = 1 << level;
    const Vec3i first = tree.top().corner;
    std::uint64_t wrong = 0, cells = 0;
    Stream random(5, static_cast<std::uint64_t>(level), 0);
    for (int z = first.z; z < kDomain.max.z; z += size) {
      for (int y = first.y; y < kDomain.max.y; y += size) {
        for (int x = first.x; x < kDomain.max.x; x += size) {
          if (level < 3 && random.uniform() > 0.02 * (1 << (2 * level))) continue;
          const Cell cell{{x, y, z}, level};
          for (int c = 0; c < 2; ++c) {
            const Bounds bounds = tree.bounds(c, cell);
            float min = 3e38f, max = -3e38f;
            double sum = 0, volume = 0;
            for (int k = z; k < z + size; ++k) {
              for (int j = y; j < y + size; ++j) {
                for (int i = x; i < x + size; ++i) {
                  if (!inside(kDomain, {i, j, k})) continue;
                  const float v = tree.value(c, Vec3d(i + 0.5, j + 0.5, k + 0.5));
                  min = std::min(min, v);
                  max = std::max(max, v);
                  sum += static_cast<double>(v);
                  volume += 1;
                }
              }
            }
            if (volume == 0) continue;
            ++cells;
            wrong += !(bounds.min <= min && bounds.max >= max);
            wrong += !(std::abs(static_cast<double>(bounds.mean) - sum / volume) <= 2e-6 * sum / volume);
            if (tolerance == 0 && volume == std::ldexp(1.0, 3 * level)) wrong += bounds.min != min || bounds.max != max;
            const float mean = tree.value(
                c, Vec3d(std::max(x, kDomain.min.x), std::max(y, kDomain.min.y), std::max(z, kDomain.min.z)), level);
            wrong += !(std::abs(static_cast<double>(mean) - static_cast<double>(bounds.mean)) <= 1e-6 * sum / volume);
          }
        }
      }
    }
    INFO("level " << level);
    CHECK(cells > 0);
    CHECK(wrong == 0);
  }
  CHECK(tree.bounds(0).max >= tree.bounds(0, {tree.top().corner, 3}).max);
  CHECK(tree.bounds(0, {tree.top().corner - Vec3i(512), 3}).max == 0);
}

TEST_CASE("the leaves hold all the mass once, in a fixed order", "[octree]") {
  const double tolerance = GENERATE(0.0, 3e-3);
  const Octree tree = patchwork_tree(tolerance);
  const Octree exact = patchwork_tree(0);
  double mass[2] = {0, 0}, expected[2] = {0, 0};
  std::vector<std::uint64_t> per_level(static_cast<std::size_t>(tree.top_level()) + 1);
  tree.for_each_leaf([&](const Cell& cell, std::span<const float> values) {
    ++per_level[static_cast<std::size_t>(cell.level)];
    for (std::size_t c = 0; c < 2; ++c) mass[c] += static_cast<double>(values[c]) * std::ldexp(1.0, 3 * cell.level);
  });
  const Field field = patchwork(21);
  for (int z = kDomain.min.z; z < kDomain.max.z; ++z) {
    for (int y = kDomain.min.y; y < kDomain.max.y; ++y) {
      for (int x = kDomain.min.x; x < kDomain.max.x; ++x) {
        for (int c = 0; c < 2; ++c) expected[c] += static_cast<double>(field(c, {x, y, z}));
      }
    }
  }
  for (int c = 0; c < 2; ++c) {
    CHECK(mass[c] == Approx(expected[c]).epsilon(tolerance == 0 ? 1e-12 : 1e-6));
    const Vec3i extent = kDomain.max - kDomain.min;
    CHECK(static_cast<double>(tree.bounds(c).mean) * extent.x * extent.y * extent.z ==
          Approx(expected[c]).epsilon(2e-6));
  }
  // The field has leaves of every level up to 4 and the statistics count them.
  const OctreeStatistics s = tree.statistics();
  std::uint64_t bricks = 0, uniform = 0;
  for (std::uint32_t i = 0; i < tree.block_count(); ++i) (tree.block(i).uniform ? uniform : bricks) += 1;
  CHECK(s.bricks == bricks);
  CHECK(s.uniform_blocks == uniform);
  for (std::size_t level = 0; level < per_level.size(); ++level) {
    INFO("level " << level);
    CHECK(per_level[level] <= s.leaves[level]);
    if (level >= 3) CHECK(per_level[level] == s.leaves[level]);
    if (level <= 4) CHECK(s.leaves[level] > 0);
  }
  CHECK(s.bytes >= s.bytes_table + s.bytes_headers + s.bytes_values + s.bytes_pyramid);
  // Leaves and empty leaves of all levels fill the table.
  double volume = 0;
  for (std::size_t level = 0; level < s.leaves.size(); ++level) {
    volume += static_cast<double>(s.leaves[level]) * std::ldexp(1.0, 3 * static_cast<int>(level));
    if (level == 3) volume += static_cast<double>(s.empty_leaves[level]) * 512;
  }
  CHECK(volume <= 80.0 * 72 * 80);
}

TEST_CASE("blocks decode to the voxels that point lookup finds", "[octree]") {
  const Octree tree = patchwork_tree(GENERATE(0.0, 3e-3));
  std::array<float, 512> values;
  std::uint64_t wrong = 0;
  for (std::uint32_t b = 0; b < tree.block_count(); ++b) {
    const Block block = tree.block(b);
    for (int c = 0; c < 2; ++c) {
      tree.decode(b, c, values);
      for (int i = 0; i < 512; ++i) {
        const Vec3i voxel = block.cell.corner + Vec3i(i & 7, (i >> 3) & 7, i >> 6);
        const float v = values[static_cast<std::size_t>(i)];
        if (inside(kDomain, voxel)) {
          wrong += v != tree.value(c, Vec3d(voxel) + Vec3d(0.5));
        } else {
          wrong += v != 0;
        }
      }
    }
  }
  CHECK(tree.block_count() > 50);
  CHECK(wrong == 0);
}

TEST_CASE("one voxel, one value and nothing make the trees they should", "[octree]") {
  BuildSettings lossless;
  lossless.tolerance = 0;
  const auto build = [&](const Box3i& box, float value) {
    return build_octree(field_stream(box, {"k"}, [value](int, const Vec3i&) { return value; }), lossless).first;
  };
  const Octree voxel = build(Box3i(Vec3i(3), Vec3i(4)), 2.5f);
  CHECK(voxel.block_count() == 1);
  CHECK(voxel.value(0, Vec3d(3.5)) == 2.5f);
  CHECK(voxel.value(0, Vec3d(4.0)) == 0);
  CHECK(voxel.bounds(0).max == 2.5f);
  CHECK(voxel.bounds(0).mean == 2.5f);
  const Octree cube = build(Box3i(Vec3i(-64), Vec3i(64)), 2.5f);
  CHECK(cube.block_count() == 1);  // 128^3 equal voxels are one leaf
  CHECK(cube.block(0).cell.level == 7);
  CHECK(cube.statistics().leaves[7] == 1);
  CHECK(cube.statistics().bytes < 30000);
  const Octree nothing = build(Box3i(Vec3i(-64), Vec3i(64)), 0);
  CHECK(nothing.block_count() == 0);
  CHECK(nothing.bounds(0).max == 0);
  CHECK(nothing.statistics().empty_leaves[7] == 1);
}
