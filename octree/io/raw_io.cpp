// Raw voxels: a .json that describes one plain array per grid, and those arrays.
#include <ImathConfig.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <half.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "octree/base/error.h"
#include "octree/io/reading.h"
#include "octree/source/slabs.h"

namespace obscura::detail {
namespace {

static_assert(std::endian::native == std::endian::little, "raw voxels are little-endian");

using Convert = void (*)(const char* bytes, std::size_t count, float* values);

template <class T>
void convert(const char* bytes, std::size_t count, float* values) {
  for (std::size_t i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, bytes + i * sizeof(T), sizeof(T));
    values[i] = static_cast<float>(value);
  }
}

struct RawType {
  const char* name;
  std::size_t bytes;
  Convert convert;
};

constexpr RawType kTypes[] = {
    {"float32", 4, convert<float>},        {"float64", 8, convert<double>},       {"float16", 2, convert<Imath::half>},
    {"uint8", 1, convert<std::uint8_t>},   {"int8", 1, convert<std::int8_t>},     {"uint16", 2, convert<std::uint16_t>},
    {"int16", 2, convert<std::int16_t>},   {"uint32", 4, convert<std::uint32_t>}, {"int32", 4, convert<std::int32_t>},
    {"uint64", 8, convert<std::uint64_t>}, {"int64", 8, convert<std::int64_t>},
};

struct RawGrid {
  std::string name;
  std::filesystem::path file;
  const RawType* type = nullptr;
  Vec3i resolution{0, 0, 0};
  bool x_fastest = true;
  Affine index_to_local;
};

/// Reads the keys of one grid's description; every mistake is a problem of its own.
class Reader {
 public:
  Reader(const std::filesystem::path& path, std::string pointer, const nlohmann::json& object)
      : path_(path), pointer_(std::move(pointer)), object_(&object) {}

  RawGrid read(std::vector<Problem>& problems) {
    problems_ = &problems;
    RawGrid grid;
    if (!object_->is_object()) {
      problem("", "must be an object", "see the raw voxels of the scene format");
      return grid;
    }
    for (const auto& [key, value] : object_->items())
      if (std::find(std::begin(kKeys), std::end(kKeys), key) == std::end(kKeys))
        problem("/" + key, "is not a key of raw voxels", fmt::format("the keys are {}", fmt::join(kKeys, ", ")));

    grid.name = text("grid", "density");
    grid.file = path_.parent_path() / text("raw", "");
    const std::string type = text("type", "float32");
    for (const RawType& known : kTypes)
      if (type == known.name) grid.type = &known;
    if (!grid.type) {
      std::vector<std::string> names;
      for (const RawType& known : kTypes) names.emplace_back(known.name);
      problem("/type", fmt::format("'{}' is not a type", type), fmt::format("one of {}", fmt::join(names, ", ")));
    }
    const std::string order = text("order", "x-fastest");
    if (order != "x-fastest" && order != "z-fastest")
      problem("/order", fmt::format("'{}' is not an order", order), "x-fastest or z-fastest");
    grid.x_fastest = order == "x-fastest";

    const Vec3d resolution = triple("resolution", nullptr);
    const Vec3d unit(1), zero(0);
    const Vec3d voxel = triple("voxel_m", &unit);
    const Vec3d origin = triple("origin_m", &zero);
    for (int axis = 0; axis < 3; ++axis) {
      if (!(resolution[axis] >= 1 && resolution[axis] <= 1 << 20) || resolution[axis] != std::floor(resolution[axis])) {
        if (object_->contains("resolution"))
          problem("/resolution", fmt::format("has {}", resolution[axis]), "whole numbers from 1 to 1048576");
        break;
      }
      grid.resolution[axis] = static_cast<int>(resolution[axis]);
    }
    for (int axis = 0; axis < 3; ++axis)
      if (!(voxel[axis] > 0)) {
        problem("/voxel_m", fmt::format("has {}", voxel[axis]), "must be positive");
        break;
      }
    grid.index_to_local.setScale(voxel);
    for (int axis = 0; axis < 3; ++axis) grid.index_to_local[3][axis] = origin[axis];
    if (!problems.empty()) return grid;

    // The description tells the size of the array to the byte.
    std::error_code error;
    const std::uint64_t size = std::filesystem::file_size(grid.file, error);
    const std::uint64_t expected = std::uint64_t(grid.resolution.x) * std::uint64_t(grid.resolution.y) *
                                   std::uint64_t(grid.resolution.z) * grid.type->bytes;
    if (error)
      problem("/raw", fmt::format("'{}' can't be read", grid.file.string()), "it is looked for beside the .json");
    else if (size != expected)
      problem("/raw", fmt::format("'{}' has {} bytes", grid.file.string(), size),
              fmt::format("{} x {} x {} {} voxels take {}", grid.resolution.x, grid.resolution.y, grid.resolution.z,
                          grid.type->name, expected));
    return grid;
  }

 private:
  static constexpr const char* kKeys[] = {"raw", "type", "resolution", "order", "voxel_m", "origin_m", "grid"};

  void problem(const std::string& key, std::string what, std::string hint) {
    problems_->push_back({path_.string() + ": " + pointer_ + key, std::move(what), std::move(hint)});
  }
  std::string text(const char* key, const std::string& fallback) {
    if (!object_->contains(key)) {
      if (fallback.empty()) problem(std::string("/") + key, "is missing", "name the file of the array");
      return fallback;
    }
    if ((*object_)[key].is_string()) return (*object_)[key].get<std::string>();
    problem(std::string("/") + key, "must be a string", "");
    return fallback;
  }
  Vec3d triple(const char* key, const Vec3d* fallback) {
    if (!object_->contains(key)) {
      if (!fallback) problem(std::string("/") + key, "is missing", "three numbers");
      return fallback ? *fallback : Vec3d(0);
    }
    const auto& value = (*object_)[key];
    if (value.is_number() && std::string(key) == "voxel_m") return Vec3d(value.get<double>());
    if (value.is_array() && value.size() == 3 && value[0].is_number() && value[1].is_number() && value[2].is_number())
      return {value[0].get<double>(), value[1].get<double>(), value[2].get<double>()};
    problem(std::string("/") + key, "must be three numbers", "[x, y, z]");
    return Vec3d(1);
  }

  const std::filesystem::path& path_;
  std::string pointer_;
  const nlohmann::json* object_;
  std::vector<Problem>* problems_ = nullptr;
};

std::vector<RawGrid> read_descriptions(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw InputError(path.string(), "can't be opened", "check its permissions");
  nlohmann::json json;
  try {
    json = nlohmann::json::parse(file, nullptr, true, /*ignore_comments=*/true);
  } catch (const nlohmann::json::exception& e) {
    throw InputError(path.string(), fmt::format("is not JSON: {}", e.what()), "correct it at that place");
  }
  std::vector<Problem> problems;
  std::vector<RawGrid> grids;
  if (json.is_array()) {
    for (std::size_t i = 0; i < json.size(); ++i)
      grids.push_back(Reader(path, fmt::format("/{}", i), json[i]).read(problems));
  } else {
    grids.push_back(Reader(path, "", json).read(problems));
  }
  if (json.is_array() && json.empty())
    problems.push_back({path.string(), "holds no grid", "describe at least one array"});
  for (std::size_t i = 0; i < grids.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (grids[i].name == grids[j].name)
        problems.push_back({fmt::format("{}: /{}/grid", path.string(), i),
                            fmt::format("'{}' is already the name of another grid", grids[i].name), "name it apart"});
  if (!problems.empty()) throw InputError(problems);
  return grids;
}

/// Reads a box of one array, run by run of its fastest axis.
void read_box(const RawGrid& grid, const Box3i& box, std::span<float> values) {
  std::ifstream file(grid.file, std::ios::binary);
  const int fast = grid.x_fastest ? 0 : 2, slow = grid.x_fastest ? 2 : 0;
  const Vec3i n = grid.resolution;
  const Vec3i size = box.max - box.min;
  const auto run = static_cast<std::size_t>(size[fast]);
  // Whole layers of the slowest axis come in one read.
  const bool whole = size[fast] == n[fast] && size.y == n.y;
  const std::size_t count = whole ? run * std::size_t(size.y) : run;
  std::vector<char> bytes(count * grid.type->bytes);
  std::vector<float> converted(count);
  for (int s = 0; s < size[slow]; ++s)
    for (int y = 0; y < (whole ? 1 : size.y); ++y) {
      const std::uint64_t first =
          (std::uint64_t(box.min[slow] + s) * std::uint64_t(n.y) + std::uint64_t(box.min.y + y)) *
              std::uint64_t(n[fast]) +
          std::uint64_t(box.min[fast]);
      file.seekg(static_cast<std::streamoff>(first * grid.type->bytes));
      file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
      if (!file)
        throw InputError(where_of(grid.file, grid.name), "the array ends early", "it was changed while being read");
      grid.type->convert(bytes.data(), count, converted.data());
      for (std::size_t i = 0; i < count; ++i) {
        Vec3i in;
        in[fast] = static_cast<int>(i % run);
        in.y = y + static_cast<int>(i / run);
        in[slow] = s;
        values[(std::size_t(in.z) * std::size_t(size.y) + std::size_t(in.y)) * std::size_t(size.x) +
               std::size_t(in.x)] = converted[i];
      }
    }
}

DenseGrids dense_grids(const std::filesystem::path& path, std::vector<RawGrid> grids,
                       const std::vector<GridRequest>& requests) {
  DenseGrids dense;
  dense.name = path.string();
  dense.grids = requests;
  for (const RawGrid& grid : grids) dense.where.push_back(where_of(path, grid.name));
  dense.index_to_local = grids.front().index_to_local;
  dense.resolution = grids.front().resolution;
  dense.slab_axis = grids.front().x_fastest ? 2 : 0;
  dense.read = [grids = std::move(grids)](std::size_t grid, const Box3i& box, std::span<float> values) {
    read_box(grids[grid], box, values);
  };
  return dense;
}

}  // namespace

std::vector<GridInfo> inspect_raw(const std::filesystem::path& path) {
  std::vector<GridInfo> result;
  for (const RawGrid& grid : read_descriptions(path)) {
    GridInfo info = describe_lattice(grid.name, grid.index_to_local, grid.resolution);
    info.type = grid.type->name;
    const SlabRange range = range_of(dense_grids(path, {grid}, {{.name = grid.name}}), 0);
    info.min = range.min;
    info.max = range.max;
    info.active = range.nonzero;
    info.bytes_source = info.bytes_dense / sizeof(float) * grid.type->bytes;
    result.push_back(info);
  }
  return result;
}

std::vector<VoxelStream> open_raw(const std::filesystem::path& path, const std::vector<GridRequest>& requests) {
  const std::vector<RawGrid> all = read_descriptions(path);
  std::vector<std::string> names;
  for (const RawGrid& grid : all) names.push_back(grid.name);
  check_names(path, names, requests);

  std::vector<std::pair<std::vector<RawGrid>, std::vector<GridRequest>>> groups;
  for (const GridRequest& request : requests) {
    const RawGrid& grid =
        *std::find_if(all.begin(), all.end(), [&](const RawGrid& g) { return g.name == request.name; });
    auto home = std::find_if(groups.begin(), groups.end(), [&](const auto& group) {
      const RawGrid& other = group.first.front();
      return other.resolution == grid.resolution &&
             same_lattice(other.index_to_local, grid.index_to_local, Box3i(Vec3i(0), grid.resolution));
    });
    if (home == groups.end()) home = groups.emplace(groups.end());
    home->first.push_back(grid);
    home->second.push_back(request);
  }
  std::vector<VoxelStream> streams;
  for (auto& [grids, wanted] : groups) streams.push_back(stream_slabs(dense_grids(path, std::move(grids), wanted)));
  return streams;
}

}  // namespace obscura::detail
