// Photons that clouds emit, voxel by voxel.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "photon/optics/sampling.h"
#include "photon/trace/emission.h"

namespace obscura {
namespace {

/// Least chance that escape_chance() gives. A smaller one would make the powers of photons from neighbouring blocks
/// differ so much that the noise which it saves in thick cores comes back at their borders.
constexpr double kLeastChance = 0.1;

/// A bounded estimate of the chance that light leaves a cube of side a: min(1, A / (4 k_a V)).
double escape_chance(double absorption, double side) noexcept {
  return std::clamp(1.5 / std::max(absorption * side, 1e-300), kLeastChance, 1.0);
}

}  // namespace

PhotonEmitter::Blocks PhotonEmitter::sum_blocks(int cloud) const {
  const Octree& octree = *world_->clouds()[static_cast<std::size_t>(cloud)].octree;
  const CloudOptics& optics = world_.optics(cloud);
  const Affine& placed = world_->clouds()[static_cast<std::size_t>(cloud)].local_to_world;
  const double voxel_volume = std::abs(linear_determinant(octree.index_to_local()) * linear_determinant(placed));
  const double voxel_side = std::cbrt(voxel_volume);
  const std::uint32_t count = octree.block_count();
  std::vector<double> power(count);
  Blocks blocks;
  blocks.chance.resize(count);

  // Power and mean absorption of every block, in parallel.
  tbb::parallel_for(std::uint32_t{0}, count, [&](std::uint32_t b) {
    const Block block = octree.block(b);
    std::vector<std::array<float, 512>> values(static_cast<std::size_t>(octree.channel_count()));
    for (int c = 0; c < octree.channel_count(); ++c) {
      octree.decode(b, c, std::span<float, 512>(values[static_cast<std::size_t>(c)]));
    }
    double emission = 0;
    double absorption = 0;
    const std::size_t voxels = block.uniform ? 1 : 512;
    for (std::size_t v = 0; v < voxels; ++v) {
      const LocalOptics local =
          optics.at([&](int channel) noexcept { return values[static_cast<std::size_t>(channel)][v]; });
      emission += local.emission;
      absorption += local.emission * (local.extinction - local.scattering);
    }
    const double volume = voxel_volume * (block.uniform ? std::pow(8.0, block.cell.level) : 1.0);
    power[b] = 4 * kPi * volume * emission;
    const double side = voxel_side * (block.uniform ? std::exp2(block.cell.level) : 1.0);
    blocks.chance[b] = static_cast<float>(escape_chance(emission > 0 ? absorption / emission : 0.0, side));
  });

  blocks.cumulative.resize(count);
  double sum = 0;
  for (std::uint32_t b = 0; b < count; ++b) {
    blocks.emitted += power[b];
    sum += power[b] * static_cast<double>(blocks.chance[b]);
    blocks.cumulative[b] = sum;
  }
  return blocks;
}

EmittedPhoton PhotonEmitter::from_cloud(int cloud, double u, const std::array<double, 8>& v,
                                        Cache& cache) const noexcept {
  const Octree& octree = *world_->clouds()[static_cast<std::size_t>(cloud)].octree;
  const CloudOptics& optics = world_.optics(cloud);
  const Blocks& blocks = blocks_[static_cast<std::size_t>(cloud)];
  const auto b = static_cast<std::uint32_t>(choose(blocks.cumulative, blocks.cumulative.size(), u));
  const Block block = octree.block(b);

  // A voxel of the block in proportion to its emission, then a place in it.
  Vec3d corner(block.cell.corner);
  double side = 1;
  if (block.uniform) {
    side = std::exp2(block.cell.level);
  } else {
    if (cache.cloud != cloud || cache.block != b) {
      std::array<std::array<float, 512>, Cloud::kMaxChannels> values;
      for (int c = 0; c < octree.channel_count(); ++c) {
        octree.decode(b, c, std::span<float, 512>(values[static_cast<std::size_t>(c)]));
      }
      double sum = 0;
      for (std::size_t i = 0; i < 512; ++i) {
        sum += optics.at([&](int channel) noexcept { return values[static_cast<std::size_t>(channel)][i]; }).emission;
        cache.cumulative[i] = static_cast<float>(sum);
      }
      cache.cloud = cloud;
      cache.block = b;
    }
    const std::size_t i = choose(cache.cumulative, 512, u);
    corner += Vec3d(static_cast<double>(i & 7), static_cast<double>((i >> 3) & 7), static_cast<double>(i >> 6));
  }
  const Vec3d index = corner + side * Vec3d(v[1], v[2], v[3]);
  const Affine& placed = world_->clouds()[static_cast<std::size_t>(cloud)].local_to_world;

  EmittedPhoton photon;
  photon.position = transform_point(placed, transform_point(octree.index_to_local(), index));
  photon.direction = uniform_direction(v[4], v[5]);
  photon.power = blocks.cumulative.back() / static_cast<double>(blocks.chance[b]);
  return photon;
}

}  // namespace obscura
