// Reads and inspects OpenVDB files. Voxel centres of OpenVDB lie at integer index coordinates, ours
// at half-integer ones; every value counts as it is stored, that of active tiles and of the background too.
#include <fmt/format.h>
#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <mutex>

#include "octree/base/error.h"
#include "octree/io/reading.h"
#include "octree/source/sparse_grid.h"

namespace obscura::detail {
namespace {

constexpr std::uint32_t kOldestVersion = 220;
constexpr std::uint32_t kNewestVersion = 225;
constexpr std::uintmax_t kSmallFile = std::uintmax_t{256} << 20;

using ScalarGrids = openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid, openvdb::Int64Grid,
                                      openvdb::BoolGrid, openvdb::MaskGrid>;
using VectorGrids = openvdb::TypeList<openvdb::Vec3SGrid, openvdb::Vec3DGrid, openvdb::Vec3IGrid>;

/// Checks the first bytes of the file. OpenVDB itself reads files of another kind until something fails.
void check_header(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::int64_t magic = 0;
  std::uint32_t version = 0;
  file.read(reinterpret_cast<char*>(&magic), sizeof magic);
  if (!file || magic != 0x56444220)
    throw InputError(path.string(), file.gcount() == 0 ? "the file is empty" : "is not an OpenVDB file",
                     "name a file written by OpenVDB");
  file.read(reinterpret_cast<char*>(&version), sizeof version);
  if (!file) throw InputError(path.string(), "the file ends in its header", "copy the file again");
  if (version < kOldestVersion || version > kNewestVersion)
    throw InputError(path.string(), fmt::format("file version {} is not supported", version),
                     fmt::format("write it with a version from {} to {}", kOldestVersion, kNewestVersion));
}

/// Refuses files that end before their grids do: OpenVDB takes what is missing for zeros or for sizes, so
/// that a short file can look like an empty grid. Files written as a stream don't say where grids end.
class LengthCheck : openvdb::io::Archive {
 public:
  void check(const std::filesystem::path& path) {
    const auto size = static_cast<std::int64_t>(std::filesystem::file_size(path));
    std::ifstream file(path, std::ios::binary);
    file.exceptions(std::ios::failbit | std::ios::badbit);
    bool whole = true;
    try {
      readHeader(file);
      if (!inputHasGridOffsets()) return;
      setFormatVersion(file);
      setLibraryVersion(file);
      openvdb::MetaMap().readMeta(file);
      for (std::int32_t left = readGridCount(file); left > 0 && whole; --left) {
        openvdb::io::GridDescriptor grid;
        grid.read(file);
        whole = grid.getEndPos() <= size;
        if (whole) grid.seekToEnd(file);
      }
    } catch (const std::ios_base::failure&) {
      whole = false;
    }
    if (!whole) throw InputError(path.string(), "the file ends before its grids do", "copy it again");
  }
};

/// An open file whose failures read as InputErrors.
class VdbFile {
 public:
  explicit VdbFile(const std::filesystem::path& path) : path_(path.string()), file_(path.string()) {
    static std::once_flag once;
    std::call_once(once, [] { openvdb::initialize(); });
    check_header(path);
    guard([&] {
      LengthCheck().check(path);
      file_.open(/*delayLoad=*/false);
    });
  }

  std::vector<std::string> names() {
    std::vector<std::string> result;
    guard([&] {
      for (auto name = file_.beginName(); name != file_.endName(); ++name) result.push_back(name.gridName());
    });
    return result;
  }
  openvdb::GridBase::Ptr read(const std::string& name) {
    openvdb::GridBase::Ptr grid;
    guard([&] { grid = file_.readGrid(name); });
    return grid;
  }
  const std::string& path() const noexcept { return path_; }

 private:
  template <class F>
  void guard(F&& f) {
    try {
      f();
    } catch (const InputError&) {
      throw;
    } catch (const std::bad_alloc&) {
      // A damaged file may ask for absurd sizes. A small file that is whole does not need much memory.
      std::error_code ignored;
      if (std::filesystem::file_size(path_, ignored) < kSmallFile)
        throw InputError(path_, "can't be read: it holds impossible sizes",
                         "the file may be truncated; copy or write it again");
      throw ResourceError(path_, "not enough memory to read the file");
    } catch (const std::exception& e) {
      throw InputError(path_, fmt::format("can't be read: {}", e.what()),
                       "the file may be truncated; copy or write it again");
    }
  }

  std::string path_;
  openvdb::io::File file_;
};

bool is_affine(const openvdb::GridBase& grid) { return grid.constTransform().isLinear(); }

/// OpenVDB's matrix has its translation in the last row, as ours; the shift puts corners at integers.
Affine index_to_local(const openvdb::GridBase& grid) {
  const openvdb::Mat4d m = grid.constTransform().baseMap()->getAffineMap()->getMat4();
  Affine map;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) map[i][j] = m(i, j);
  Affine shift;
  shift.setTranslation(Vec3d(-0.5));
  return shift * map;
}

Vec3i corner_of(const openvdb::Coord& c) { return {c.x(), c.y(), c.z()}; }

template <class Value>
float to_float(const Value& value) {
  return static_cast<float>(value);
}

template <class Leaf>
void copy_leaf(const Leaf& leaf, std::span<float, 512> values) {
  // OpenVDB has z fastest.
  for (int z = 0; z < 8; ++z)
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x)
        values[x + 8 * y + 64 * z] = to_float(leaf.getValue(static_cast<openvdb::Index>(64 * x + 8 * y + z)));
}

/// Values above the leaves: visit(corner, level, value, active).
template <class Tree, class F>
void for_each_tile(const Tree& tree, F&& visit) {
  static_assert(Tree::DEPTH == 4 && Tree::LeafNodeType::LOG2DIM == 3 && Tree::RootNodeType::ChildNodeType::TOTAL == 12);
  constexpr int levels[3] = {12, 7, 3};
  auto value = tree.cbeginValueAll();
  value.setMaxDepth(decltype(value)::LEAF_DEPTH - 1);
  for (; value; ++value) {
    openvdb::CoordBBox box;
    value.getBoundingBox(box);
    visit(corner_of(box.min()), levels[value.getDepth()], value.getValue(), value.isValueOn());
  }
}

template <class Grid>
SparseGrid sparse_grid(const typename Grid::Ptr& grid, const GridRequest& request, std::string where) {
  using Leaf = typename Grid::TreeType::LeafNodeType;
  SparseGrid result;
  result.request = request;
  result.where = std::move(where);
  result.index_to_local = index_to_local(*grid);
  result.background = to_float(grid->background());

  auto leaves = std::make_shared<std::vector<Leaf*>>();
  leaves->reserve(grid->tree().leafCount());
  for (auto leaf = grid->tree().beginLeaf(); leaf; ++leaf) {
    leaves->push_back(&*leaf);
    result.bricks.push_back(corner_of(leaf->origin()));
  }
  for_each_tile(grid->tree(), [&](const Vec3i& corner, int level, const auto& value, bool active) {
    if (active || value != grid->background()) result.tiles.push_back({corner, level, to_float(value)});
  });
  result.read = [grid, leaves](std::size_t brick, std::span<float, 512> values) {
    copy_leaf(*(*leaves)[brick], values);
  };
  if constexpr (std::is_floating_point_v<typename Grid::ValueType>) {
    result.release = [leaves](std::size_t brick) {
      typename Leaf::Buffer nothing(openvdb::PartialCreate(), 0);
      (*leaves)[brick]->swap(nothing);
    };
  }
  return result;
}

/// Calls f with the typed pointer if the grid is of one of the types.
template <class Types>
struct Dispatch;
template <class... Grids>
struct Dispatch<openvdb::TypeList<Grids...>> {
  template <class F>
  static bool call(const openvdb::GridBase::Ptr& grid, F&& f) {
    return (try_one<Grids>(grid, f) || ...);
  }
  template <class Grid, class F>
  static bool try_one(const openvdb::GridBase::Ptr& grid, F&& f) {
    auto typed = openvdb::gridPtrCast<Grid>(grid);
    if (!typed) return false;
    f(typed);
    return true;
  }
};

std::string units_of(const openvdb::GridBase& grid) {
  const auto units = grid.getMetadata<openvdb::StringMetadata>("units");
  return units ? units->value() : std::string();
}

std::string type_name(const openvdb::GridBase& grid) {
  const std::string type = grid.valueType();
  return type == "float" && grid.saveFloatAsHalf() ? "half" : type;
}

double magnitude(double value) { return value; }
template <class T>
double magnitude(const openvdb::math::Vec3<T>& value) {
  return openvdb::Vec3d(value).length();
}

/// Range over active values, leaf by leaf and tile by tile; of a vector its length.
template <class Grid>
void fill_range(const Grid& grid, GridInfo& info) {
  double lowest = kInfinity, highest = -kInfinity;
  const auto add = [&](double value) {
    lowest = std::min(lowest, value);
    highest = std::max(highest, value);
  };
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
    for (auto value = leaf->cbeginValueOn(); value; ++value) add(magnitude(*value));
  for_each_tile(grid.tree(), [&](const Vec3i&, int, const auto& value, bool active) {
    if (active) add(magnitude(value));
  });
  info.min = lowest <= highest ? lowest : 0;
  info.max = lowest <= highest ? highest : 0;
  info.background = magnitude(grid.background());
}

GridInfo describe(const openvdb::GridBase::Ptr& grid) {
  GridInfo info;
  info.name = grid->getName();
  info.type = type_name(*grid);
  info.units = units_of(*grid);
  info.affine = is_affine(*grid);
  if (info.affine) {
    info.index_to_local = index_to_local(*grid);
    for (int axis = 0; axis < 3; ++axis) {
      const auto row = info.index_to_local[axis];
      info.voxel_m[axis] = Vec3d(row[0], row[1], row[2]).length();
    }
  }
  const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
  if (!box.empty()) {
    info.bounds = Box3i(corner_of(box.min()), corner_of(box.max()) + Vec3i(1));
    info.resolution = info.bounds.size();
  }
  info.active = grid->activeVoxelCount();
  info.bytes_source = grid->memUsage();
  info.bytes_dense = sizeof(float) * std::uint64_t(info.resolution.x) * std::uint64_t(info.resolution.y) *
                     std::uint64_t(info.resolution.z);
  const auto measure = [&](const auto& typed) {
    info.tiles = typed->tree().activeTileCount();
    info.leaves = typed->tree().leafCount();
    fill_range(*typed, info);
  };
  info.scalar = Dispatch<ScalarGrids>::call(grid, measure);
  if (!info.scalar) Dispatch<VectorGrids>::call(grid, measure);
  return info;
}

std::vector<SparseGrid> read_grids(const std::filesystem::path& path, const std::vector<GridRequest>& requests) {
  VdbFile file(path);
  check_names(path, file.names(), requests);
  std::vector<SparseGrid> result;
  for (const GridRequest& request : requests) {
    const std::string where = where_of(path, request.name);
    const openvdb::GridBase::Ptr grid = file.read(request.name);
    if (!is_affine(*grid))
      throw InputError(where, fmt::format("its transform ({}) is not affine", grid->constTransform().mapType()),
                       "resample the grid onto a box of voxels where it is written");
    const bool scalar = Dispatch<ScalarGrids>::call(grid, [&](const auto& typed) {
      using Grid = typename std::decay_t<decltype(typed)>::element_type;
      result.push_back(sparse_grid<Grid>(typed, request, where));
      result.back().units = units_of(*typed);
    });
    if (!scalar)
      throw InputError(where, fmt::format("holds {} values, not scalars", type_name(*grid)),
                       "name a grid of floats, doubles, halves, integers or booleans");
  }
  return result;
}

}  // namespace

std::vector<GridInfo> inspect_vdb(const std::filesystem::path& path) {
  VdbFile file(path);
  std::vector<GridInfo> result;
  for (const std::string& name : file.names()) {
    result.push_back(describe(file.read(name)));
    result.back().name = name;  // as open_volume() takes it, with its number where names repeat
  }
  return result;
}

std::vector<VoxelStream> open_vdb(const std::filesystem::path& file, const std::vector<GridRequest>& grids) {
  return open_sparse(file, grids, read_grids);
}

}  // namespace obscura::detail
