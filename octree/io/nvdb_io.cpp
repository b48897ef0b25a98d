// Reads and inspects NanoVDB files: floats of every width that NanoVDB stores, doubles, integers, masks.
#include "octree/base/error.h"
#include "octree/io/reading.h"
#include "octree/source/sparse_grid.h"

#define NANOVDB_USE_ZIP
#define NANOVDB_USE_BLOSC
#include <fmt/format.h>
#include <nanovdb/util/IO.h>

#include <algorithm>
#include <fstream>
#include <memory>

namespace obscura::detail {
namespace {

using Handle = nanovdb::GridHandle<nanovdb::HostBuffer>;

struct File {
  std::string path;
  std::vector<std::shared_ptr<const Handle>> grids;
};

[[noreturn]] void fail(const std::string& path, const std::string& problem) {
  throw InputError(path, problem, "the file may be truncated or of another version; write it again");
}

File read_file(const std::filesystem::path& path) {
  File result{path.string(), {}};
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw InputError(result.path, "can't be opened", "check its permissions");
  const std::uint64_t size = std::filesystem::file_size(path);
  if (size == 0) throw InputError(result.path, "the file is empty", "copy or write it again");
  try {
    // The headers first: a damaged one may announce more bytes than the file has, and memory would be asked for them.
    for (const auto& meta : nanovdb::io::readGridMetaData(stream)) {
      if (meta.fileSize > size || (meta.codec == nanovdb::io::Codec::NONE && meta.gridSize > size))
        fail(result.path, fmt::format("grid '{}' needs more bytes than the file has", meta.gridName));
    }
    stream.clear();
    stream.seekg(0);
    for (Handle& handle : nanovdb::io::readGrids(stream))
      result.grids.push_back(std::make_shared<const Handle>(std::move(handle)));
  } catch (const InputError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw ResourceError(result.path, "not enough memory to read the file");
  } catch (const std::exception& e) {
    fail(result.path, fmt::format("can't be read: {}", e.what()));
  }
  if (result.grids.empty()) fail(result.path, "holds no grid");
  for (const auto& grid : result.grids)
    if (!grid->gridMetaData() || !grid->gridMetaData()->isValid()) fail(result.path, "a grid's header is damaged");
  return result;
}

/// Calls f with a null pointer of the stored type's tag if it is a scalar that can be read.
template <class F>
bool dispatch(nanovdb::GridType type, F&& f) {
  const auto call = [&]<class T>(T*) {
    f(static_cast<T*>(nullptr));
    return true;
  };
  switch (type) {
    case nanovdb::GridType::Float:
      return call(static_cast<float*>(nullptr));
    case nanovdb::GridType::Double:
      return call(static_cast<double*>(nullptr));
    case nanovdb::GridType::Int16:
      return call(static_cast<std::int16_t*>(nullptr));
    case nanovdb::GridType::Int32:
      return call(static_cast<std::int32_t*>(nullptr));
    case nanovdb::GridType::Int64:
      return call(static_cast<std::int64_t*>(nullptr));
    case nanovdb::GridType::UInt32:
      return call(static_cast<std::uint32_t*>(nullptr));
    case nanovdb::GridType::Boolean:
      return call(static_cast<bool*>(nullptr));
    case nanovdb::GridType::Mask:
      return call(static_cast<nanovdb::ValueMask*>(nullptr));
    case nanovdb::GridType::Fp4:
      return call(static_cast<nanovdb::Fp4*>(nullptr));
    case nanovdb::GridType::Fp8:
      return call(static_cast<nanovdb::Fp8*>(nullptr));
    case nanovdb::GridType::Fp16:
      return call(static_cast<nanovdb::Fp16*>(nullptr));
    case nanovdb::GridType::FpN:
      return call(static_cast<nanovdb::FpN*>(nullptr));
    default:
      return false;
  }
}

/// NanoVDB maps columns, M x + v, with voxel centres at integers.
Affine index_to_local(const nanovdb::GridMetaData& meta) {
  const nanovdb::Map& map = meta.map();
  Affine result;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) result[i][j] = map.mMatD[3 * j + i];
  for (int j = 0; j < 3; ++j) result[3][j] = map.mVecD[j];
  Affine shift;
  shift.setTranslation(Vec3d(-0.5));
  return shift * result;
}

Vec3i corner_of(const nanovdb::Coord& c) { return {c[0], c[1], c[2]}; }

/// The leaves and tiles of a grid; every pointer is checked to lie in the buffer before it is followed.
template <class Build>
struct Nodes {
  using Tree = nanovdb::NanoTree<Build>;
  using Leaf = typename Tree::LeafNodeType;
  struct Tile {
    Vec3i corner;
    int level;
    float value;
    bool active;
  };
  std::vector<const Leaf*> leaves;
  std::vector<Tile> tiles;

  Nodes(const Handle& handle, const std::string& path) : handle_(&handle), path_(&path) {
    const auto* grid = handle.grid<Build>();
    if (!grid) fail(path, "a grid's header is damaged");
    const auto& tree = grid->tree();
    check(&tree, sizeof(Tree));
    const auto& root = tree.root();
    check(&root, sizeof(root));
    const auto* data = root.data();
    check(data, sizeof(*data) + std::size_t(data->mTableSize) * sizeof(*data->tile(0)));
    for (std::uint32_t t = 0; t < data->mTableSize; ++t) {
      const auto* tile = data->tile(t);
      if (tile->isChild()) {
        visit(data->getChild(tile), 7);
      } else {
        tiles.push_back({corner_of(tile->origin()), 12, static_cast<float>(tile->value), tile->isActive()});
      }
    }
  }

 private:
  void check(const void* node, std::size_t bytes) const {
    const auto* begin = handle_->data();
    const auto* at = static_cast<const std::uint8_t*>(node);
    if (at < begin || at + bytes > begin + handle_->size() || reinterpret_cast<std::uintptr_t>(at) % 8 != 0)
      fail(*path_, "a grid's tree is damaged");
  }
  template <class Node>
  void visit(const Node* node, int level) {
    check(node, sizeof(Node));
    const auto* data = reinterpret_cast<const typename Node::DataType*>(node);
    for (std::uint32_t n = 0; n < Node::SIZE; ++n) {
      if (data->isChild(n)) {
        if constexpr (Node::LEVEL == 1) {
          const Leaf* leaf = data->getChild(n);
          check(leaf, sizeof(typename Leaf::DataType));
          leaves.push_back(leaf);
        } else {
          visit(data->getChild(n), 3);
        }
      } else {
        tiles.push_back(
            {corner_of(node->offsetToGlobalCoord(n)), level, static_cast<float>(data->getValue(n)), data->isActive(n)});
      }
    }
  }

  const Handle* handle_;
  const std::string* path_;
};

template <class Build>
SparseGrid sparse_grid(const std::shared_ptr<const Handle>& handle, const std::string& path,
                       const GridRequest& request) {
  SparseGrid grid;
  grid.request = request;
  grid.where = where_of(path, request.name);
  grid.index_to_local = index_to_local(*handle->gridMetaData());
  auto nodes = std::make_shared<const Nodes<Build>>(*handle, path);
  grid.background = static_cast<float>(handle->template grid<Build>()->tree().background());
  for (const auto* leaf : nodes->leaves) grid.bricks.push_back(corner_of(leaf->origin()));
  for (const auto& tile : nodes->tiles)
    if (tile.active || tile.value != grid.background) grid.tiles.push_back({tile.corner, tile.level, tile.value});
  grid.read = [handle, nodes](std::size_t brick, std::span<float, 512> values) {
    const auto& leaf = *nodes->leaves[brick];
    for (int z = 0; z < 8; ++z)
      for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x)
          values[x + 8 * y + 64 * z] =
              static_cast<float>(leaf.getValue(static_cast<std::uint32_t>(64 * x + 8 * y + z)));
  };
  return grid;
}

GridInfo describe(const std::shared_ptr<const Handle>& handle, const std::string& path) {
  const nanovdb::GridMetaData& meta = *handle->gridMetaData();
  GridInfo info;
  info.name = meta.shortGridName();
  info.type = nanovdb::toStr(meta.gridType());
  info.index_to_local = index_to_local(meta);
  for (int axis = 0; axis < 3; ++axis) {
    const auto row = info.index_to_local[axis];
    info.voxel_m[axis] = Vec3d(row[0], row[1], row[2]).length();
  }
  info.active = meta.activeVoxelCount();
  const nanovdb::CoordBBox box = meta.indexBBox();
  if (info.active > 0) {
    info.bounds = Box3i(corner_of(box.min()), corner_of(box.max()) + Vec3i(1));
    info.resolution = info.bounds.size();
  }
  info.bytes_source = handle->size();
  info.bytes_dense = sizeof(float) * std::uint64_t(info.resolution.x) * std::uint64_t(info.resolution.y) *
                     std::uint64_t(info.resolution.z);
  info.scalar = dispatch(meta.gridType(), [&]<class Build>(Build*) {
    const Nodes<Build> nodes(*handle, path);
    info.leaves = nodes.leaves.size();
    double lowest = kInfinity, highest = -kInfinity;
    const auto add = [&](double value) {
      lowest = std::min(lowest, value);
      highest = std::max(highest, value);
    };
    for (const auto* leaf : nodes.leaves)
      for (std::uint32_t v = 0; v < 512; ++v)
        if (leaf->isActive(v)) add(static_cast<double>(leaf->getValue(v)));
    for (const auto& tile : nodes.tiles)
      if (tile.active) {
        add(tile.value);
        ++info.tiles;
      }
    if (lowest <= highest) {
      info.min = lowest;
      info.max = highest;
    }
    info.background = static_cast<double>(handle->template grid<Build>()->tree().background());
  });
  return info;
}

std::vector<SparseGrid> read_grids(const std::filesystem::path& path, const std::vector<GridRequest>& requests) {
  const File file = read_file(path);
  std::vector<std::string> names;
  for (const auto& grid : file.grids) names.emplace_back(grid->gridMetaData()->shortGridName());
  check_names(path, names, requests);
  std::vector<SparseGrid> result;
  for (const GridRequest& request : requests) {
    const auto& handle = file.grids[std::size_t(std::find(names.begin(), names.end(), request.name) - names.begin())];
    const nanovdb::GridType type = handle->gridMetaData()->gridType();
    const bool scalar =
        dispatch(type, [&]<class Build>(Build*) { result.push_back(sparse_grid<Build>(handle, file.path, request)); });
    if (!scalar)
      throw InputError(where_of(path, request.name), fmt::format("holds {} values, not scalars", nanovdb::toStr(type)),
                       "name a grid of floats, doubles, integers or booleans");
  }
  return result;
}

}  // namespace

std::vector<GridInfo> inspect_nvdb(const std::filesystem::path& path) {
  const File file = read_file(path);
  std::vector<GridInfo> result;
  for (const auto& grid : file.grids) result.push_back(describe(grid, file.path));
  return result;
}

std::vector<VoxelStream> open_nvdb(const std::filesystem::path& file, const std::vector<GridRequest>& grids) {
  return open_sparse(file, grids, read_grids);
}

}  // namespace obscura::detail
