#include "octree/source/octree_stream.h"

#include <tbb/parallel_for.h>

#include <array>

namespace obscura {
namespace {

/// Pours a cube of one value as cubes that are aligned as VoxelSink::tile() asks.
void pour_cube(VoxelSink& sink, const Vec3i& corner, int level, std::span<const float> values) {
  const int mask = (1 << level) - 1;
  if (((corner.x | corner.y | corner.z) & mask) == 0) return sink.tile(corner, level, values);
  for (int child = 0; child < 8; ++child)
    pour_cube(sink, corner + Vec3i(child & 1, (child >> 1) & 1, child >> 2) * (1 << (level - 1)), level - 1, values);
}

}  // namespace

VoxelStream octree_stream(std::shared_ptr<const Octree> octree) {
  VoxelStream stream;
  stream.name = "octree";
  stream.channels = octree->channels();
  stream.index_to_local = octree->index_to_local();
  stream.bounds = octree->domain();
  stream.pour = [octree](VoxelSink& sink) {
    const auto channels = static_cast<std::size_t>(octree->channel_count());
    tbb::parallel_for(std::uint32_t{0}, octree->block_count(), [&](std::uint32_t i) {
      const Block block = octree->block(i);
      std::vector<float> values(512 * channels);
      std::vector<const float*> pointers;
      for (std::size_t c = 0; c < channels; ++c) {
        float* const to = values.data() + 512 * c;
        octree->decode(i, static_cast<int>(c), std::span<float, 512>(to, 512));
        pointers.push_back(to);
      }
      if (!block.uniform) return sink.brick(block.cell.corner, pointers.data());
      std::vector<float> one;
      for (std::size_t c = 0; c < channels; ++c) one.push_back(pointers[c][0]);
      pour_cube(sink, block.cell.corner, block.cell.level, one);
    });
  };
  return stream;
}

}  // namespace obscura
