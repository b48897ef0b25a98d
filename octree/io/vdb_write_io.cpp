// Writes streams of voxels as OpenVDB files, and measures them as OpenVDB and NanoVDB grids.
#include <fmt/format.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <openvdb/openvdb.h>

#include <chrono>
#include <mutex>

#include "octree/base/error.h"
#include "octree/io/export.h"
#include "octree/source/octree_stream.h"

namespace obscura {
namespace {

using Tree = openvdb::FloatTree;
using Leaf = Tree::LeafNodeType;

openvdb::Coord coord_of(const Vec3i& v) { return {v.x, v.y, v.z}; }

/// OpenVDB's voxel centres are at integers, ours at half-integers.
openvdb::math::Transform::Ptr transform_of(const Affine& index_to_local) {
  Affine shift;
  shift.setTranslation(Vec3d(0.5));
  const Affine map = shift * index_to_local;
  openvdb::Mat4d m;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) m(i, j) = map[i][j];
  return openvdb::math::Transform::createLinearTransform(m);
}

openvdb::FloatGrid::Ptr empty_grid(const std::string& name, const Affine& index_to_local) {
  static std::once_flag once;
  std::call_once(once, [] { openvdb::initialize(); });
  auto grid = openvdb::FloatGrid::create(0.0f);
  grid->setName(name);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->setTransform(transform_of(index_to_local));
  return grid;
}

/// A leaf of the brick's values, active where they aren't 0; null where all are.
Leaf* make_leaf(const Vec3i& corner, const float* values) {
  auto leaf = std::make_unique<Leaf>(coord_of(corner), 0.0f);
  bool any = false;
  for (int z = 0; z < 8; ++z)
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        const float value = values[x + 8 * y + 64 * z];
        if (value == 0) continue;
        leaf->setValueOn(static_cast<openvdb::Index>(64 * x + 8 * y + z), value);
        any = true;
      }
  return any ? leaf.release() : nullptr;
}

/// One grid per channel.
std::vector<openvdb::FloatGrid::Ptr> make_grids(const VoxelStream& stream) {
  std::vector<openvdb::FloatGrid::Ptr> grids;
  for (const std::string& channel : stream.channels) grids.push_back(empty_grid(channel, stream.index_to_local));
  std::mutex mutex;
  VoxelSink sink(
      [&](const Vec3i& corner, const float* const* values) {
        std::vector<Leaf*> leaves;
        for (std::size_t c = 0; c < grids.size(); ++c) leaves.push_back(make_leaf(corner, values[c]));
        const std::lock_guard lock(mutex);
        for (std::size_t c = 0; c < grids.size(); ++c)
          if (leaves[c]) grids[c]->tree().addLeaf(leaves[c]);
      },
      [&](const Vec3i& corner, int level, std::span<const float> values) {
        const openvdb::CoordBBox box =
            openvdb::CoordBBox::createCube(coord_of(corner), static_cast<openvdb::Coord::ValueType>(1 << level));
        const std::lock_guard lock(mutex);
        for (std::size_t c = 0; c < grids.size(); ++c)
          if (values[c] != 0) grids[c]->tree().sparseFill(box, values[c], true);
      });
  stream.pour(sink);
  return grids;
}

}  // namespace

void write_vdb(const std::filesystem::path& path, const VoxelStream& stream, const VdbOptions& options) {
  openvdb::GridCPtrVec grids;
  for (const auto& grid : make_grids(stream)) {
    grid->setSaveFloatAsHalf(options.half);
    grids.push_back(grid);
  }
  openvdb::MetaMap metadata;
  metadata.insertMeta("creator", openvdb::StringMetadata("Obscura"));
  metadata.insertMeta("length_unit", openvdb::StringMetadata("m"));
  for (const auto& [key, value] : options.metadata) {
    metadata.removeMeta(key);
    metadata.insertMeta(key, openvdb::StringMetadata(value));
  }

  const std::filesystem::path partial = path.string() + ".partial";
  std::error_code ignored;
  try {
    openvdb::io::File file(partial.string());
    file.write(grids, metadata);
    file.close();
    std::filesystem::rename(partial, path);
  } catch (const std::exception& e) {
    std::filesystem::remove(partial, ignored);
    throw ResourceError(path.string(), fmt::format("can't be written: {}", e.what()),
                        "check the folder, its permissions and the space left");
  }
}

void write_vdb(const std::filesystem::path& path, const Octree& octree, const VdbOptions& options) {
  // The stream lives only in this call: it borrows the octree.
  write_vdb(path, octree_stream(std::shared_ptr<const Octree>(std::shared_ptr<void>(), &octree)), options);
}

OtherForms measure_other_forms(const VoxelStream& stream) {
  OtherForms result;
  for (const auto& grid : make_grids(stream)) {
    result.bytes_openvdb += grid->memUsage();
    const auto start = std::chrono::steady_clock::now();
    result.bytes_nanovdb += nanovdb::openToNanoVDB(*grid).size();
    result.seconds_nanovdb += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    result.bytes_nanovdb_fp8 +=
        nanovdb::openToNanoVDB<nanovdb::HostBuffer, openvdb::FloatTree, nanovdb::Fp8>(*grid).size();
  }
  return result;
}

}  // namespace obscura
