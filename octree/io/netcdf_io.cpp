// Variables over three axes from NetCDF files that follow the CF conventions.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <netcdf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>

#include "octree/base/error.h"
#include "octree/io/netcdf_axes.h"
#include "octree/io/reading.h"
#include "octree/source/slabs.h"

namespace obscura::detail {
namespace {

/// An open file; every failed call is an InputError that names the file.
class NetcdfFile {
 public:
  explicit NetcdfFile(const std::filesystem::path& path) : path_(path.string()) {
    require(nc_open(path_.c_str(), NC_NOWRITE, &id_), "opening");
  }
  ~NetcdfFile() { nc_close(id_); }
  NetcdfFile(const NetcdfFile&) = delete;
  NetcdfFile& operator=(const NetcdfFile&) = delete;

  int id() const noexcept { return id_; }
  const std::string& path() const noexcept { return path_; }
  void require(int status, const std::string& what) const {
    if (status != NC_NOERR)
      throw InputError(path_, fmt::format("{} failed: {}", what, nc_strerror(status)),
                       "the file may be truncated or of another kind; ncdump -h shows what it holds");
  }

  std::string text_attribute(int variable, const char* name) const {
    std::size_t length = 0;
    nc_type type = NC_NAT;
    if (nc_inq_att(id_, variable, name, &type, &length) != NC_NOERR) return {};
    if (type == NC_CHAR) {
      std::string text(length, '\0');
      require(nc_get_att_text(id_, variable, name, text.data()), "reading an attribute");
      while (!text.empty() && text.back() == '\0') text.pop_back();
      return text;
    }
    if (type == NC_STRING && length == 1) {
      char* text = nullptr;
      require(nc_get_att_string(id_, variable, name, &text), "reading an attribute");
      std::string result = text ? text : "";
      nc_free_string(1, &text);
      return result;
    }
    return {};
  }
  std::vector<double> number_attribute(int variable, const char* name) const {
    std::size_t length = 0;
    nc_type type = NC_NAT;
    if (nc_inq_att(id_, variable, name, &type, &length) != NC_NOERR || type == NC_CHAR || type == NC_STRING) return {};
    std::vector<double> values(length);
    require(nc_get_att_double(id_, variable, name, values.data()), "reading an attribute");
    return values;
  }

 private:
  std::string path_;
  int id_ = -1;
};

/// A variable over x, y and z, and perhaps time and dimensions of length 1.
struct Variable {
  std::string name, units;
  int id = -1;
  nc_type type = NC_NAT;
  std::vector<FileAxis> dimensions;      // in the file's order
  std::array<int, 3> place{-1, -1, -1};  // of x, y and z among them
  int time_place = -1;
  std::size_t times = 1;
  double scale = 1, offset = 0;
  std::vector<double> fill;  // packed values that stand for "no value"
  bool nan_is_fill = false;
};

struct Lattice {
  std::array<LatticeAxis, 3> axes;
  Affine index_to_local;
  Vec3i resolution;
};

FileAxis file_axis(const NetcdfFile& file, int dimension) {
  FileAxis axis;
  char name[NC_MAX_NAME + 1] = {};
  file.require(nc_inq_dim(file.id(), dimension, name, &axis.length), "reading a dimension");
  axis.name = name;
  int variable = -1, count = 0, owner = -1;
  if (nc_inq_varid(file.id(), name, &variable) != NC_NOERR) return axis;
  nc_type type = NC_NAT;
  file.require(nc_inq_vartype(file.id(), variable, &type), "reading a coordinate");
  file.require(nc_inq_varndims(file.id(), variable, &count), "reading a coordinate");
  if (count != 1 || type == NC_CHAR || type > NC_UINT64) return axis;
  file.require(nc_inq_vardimid(file.id(), variable, &owner), "reading a coordinate");
  if (owner != dimension) return axis;
  axis.points.resize(axis.length);
  if (axis.length > 0) file.require(nc_get_var_double(file.id(), variable, axis.points.data()), "reading a coordinate");
  axis.units = file.text_attribute(variable, "units");
  axis.axis = file.text_attribute(variable, "axis");
  axis.standard_name = file.text_attribute(variable, "standard_name");
  return axis;
}

double default_fill(nc_type type) {
  // The library's fill value, of types that it fills where nothing was written; it does not fill bytes.
  switch (type) {
    case NC_FLOAT:
      return static_cast<double>(NC_FILL_FLOAT);
    case NC_DOUBLE:
      return NC_FILL_DOUBLE;
    case NC_SHORT:
      return NC_FILL_SHORT;
    case NC_USHORT:
      return NC_FILL_USHORT;
    case NC_INT:
      return NC_FILL_INT;
    case NC_UINT:
      return NC_FILL_UINT;
    default:
      return std::nan("");
  }
}

/// The variable's description if it spans three axes in space.
std::optional<Variable> describe(const NetcdfFile& file, int id) {
  Variable variable;
  variable.id = id;
  char name[NC_MAX_NAME + 1] = {};
  int count = 0;
  std::array<int, NC_MAX_VAR_DIMS> ids{};
  file.require(nc_inq_var(file.id(), id, name, &variable.type, &count, ids.data(), nullptr), "reading a variable");
  variable.name = name;
  if (count < 3 || variable.type == NC_CHAR || variable.type > NC_UINT64) return std::nullopt;

  // Axes that say what they are; the rest are x, y, z from the last dimension on, as CF recommends.
  std::vector<int> unknown;
  for (int d = 0; d < count; ++d) {
    variable.dimensions.push_back(file_axis(file, ids[d]));
    const AxisRole role = role_of(variable.dimensions.back());
    if (role == AxisRole::time && variable.time_place < 0) {
      variable.time_place = d;
      variable.times = variable.dimensions.back().length;
    } else if (role <= AxisRole::z && variable.place[static_cast<int>(role)] < 0) {
      variable.place[static_cast<int>(role)] = d;
    } else {
      unknown.push_back(d);
    }
  }
  for (auto d = unknown.rbegin(); d != unknown.rend(); ++d) {
    if (variable.dimensions[static_cast<std::size_t>(*d)].length == 1) continue;
    const auto free = std::find(variable.place.begin(), variable.place.end(), -1);
    if (free == variable.place.end()) return std::nullopt;
    *free = *d;
  }
  if (std::count(variable.place.begin(), variable.place.end(), -1) > 0) return std::nullopt;

  variable.units = file.text_attribute(id, "units");
  if (const auto scale = file.number_attribute(id, "scale_factor"); !scale.empty()) variable.scale = scale[0];
  if (const auto offset = file.number_attribute(id, "add_offset"); !offset.empty()) variable.offset = offset[0];
  variable.fill = file.number_attribute(id, "_FillValue");
  if (variable.fill.empty()) variable.fill.push_back(default_fill(variable.type));
  for (const double missing : file.number_attribute(id, "missing_value")) variable.fill.push_back(missing);
  const auto is_nan = [](double v) { return std::isnan(v); };
  variable.nan_is_fill = !file.number_attribute(id, "_FillValue").empty() &&
                         std::any_of(variable.fill.begin(), variable.fill.end(), is_nan);
  std::erase_if(variable.fill, is_nan);
  return variable;
}

std::vector<Variable> variables(const NetcdfFile& file) {
  int count = 0;
  file.require(nc_inq_nvars(file.id(), &count), "listing the variables");
  std::vector<Variable> result;
  for (int id = 0; id < count; ++id)
    if (auto variable = describe(file, id)) result.push_back(std::move(*variable));
  if (result.empty())
    throw InputError(file.path(), "holds no numeric variable over three axes",
                     "a cloud needs a variable like lwc(z, y, x); profiles and maps aren't clouds");
  return result;
}

Lattice lattice_of(const NetcdfFile& file, const Variable& variable) {
  const std::string where = where_of(file.path(), variable.name);
  Lattice lattice;
  Vec3d voxel, origin;
  for (int axis = 0; axis < 3; ++axis) {
    lattice.axes[axis] = lattice_axis(where, variable.dimensions[static_cast<std::size_t>(variable.place[axis])]);
    voxel[axis] = lattice.axes[axis].voxel_m;
    origin[axis] = lattice.axes[axis].origin_m;
    lattice.resolution[axis] = static_cast<int>(lattice.axes[axis].cells.size());
  }
  check_resolution(where, lattice.resolution);
  lattice.index_to_local.setScale(voxel);
  for (int axis = 0; axis < 3; ++axis) lattice.index_to_local[3][axis] = origin[axis];
  return lattice;
}

/// The values of a box of cells: reads the points that they cover, unpacks them and takes their means.
void read_box(const NetcdfFile& file, const Variable& variable, const Lattice& lattice, std::size_t time,
              const Box3i& box, std::span<float> values) {
  const std::size_t dimensions = variable.dimensions.size();
  std::vector<std::size_t> start(dimensions, 0), count(dimensions, 1), stride(dimensions);
  if (variable.time_place >= 0) start[static_cast<std::size_t>(variable.time_place)] = time;
  for (int axis = 0; axis < 3; ++axis) {
    int low = std::numeric_limits<int>::max(), high = -1;
    for (int cell = box.min[axis]; cell < box.max[axis]; ++cell)
      for (const auto& share : lattice.axes[axis].cells[static_cast<std::size_t>(cell)]) {
        low = std::min(low, share.point);
        high = std::max(high, share.point);
      }
    const auto place = static_cast<std::size_t>(variable.place[axis]);
    start[place] = static_cast<std::size_t>(low);
    count[place] = static_cast<std::size_t>(high - low + 1);
  }
  std::size_t total = 1;
  for (std::size_t d = dimensions; d-- > 0;) {
    stride[d] = total;
    total *= count[d];
  }
  std::vector<double> points(total);
  file.require(nc_get_vara_double(file.id(), variable.id, start.data(), count.data(), points.data()),
               fmt::format("reading '{}'", variable.name));
  for (double& value : points) {
    const bool fill = (variable.nan_is_fill && std::isnan(value)) ||
                      std::find(variable.fill.begin(), variable.fill.end(), value) != variable.fill.end();
    value = fill ? 0 : value * variable.scale + variable.offset;
  }

  const auto at = [&](int axis, int point) {
    const auto place = static_cast<std::size_t>(variable.place[axis]);
    return (static_cast<std::size_t>(point) - start[place]) * stride[place];
  };
  std::size_t out = 0;
  for (int z = box.min.z; z < box.max.z; ++z)
    for (int y = box.min.y; y < box.max.y; ++y)
      for (int x = box.min.x; x < box.max.x; ++x) {
        double sum = 0;
        for (const auto& c : lattice.axes[2].cells[static_cast<std::size_t>(z)])
          for (const auto& b : lattice.axes[1].cells[static_cast<std::size_t>(y)])
            for (const auto& a : lattice.axes[0].cells[static_cast<std::size_t>(x)])
              sum += a.weight * b.weight * c.weight * points[at(0, a.point) + at(1, b.point) + at(2, c.point)];
        values[out++] = static_cast<float>(sum);
      }
}

/// The axis that varies slowest in the file: slabs along it are read in order.
int slowest_axis(const Variable& variable) {
  return static_cast<int>(std::min_element(variable.place.begin(), variable.place.end()) - variable.place.begin());
}

DenseGrids dense_grids(const std::shared_ptr<NetcdfFile>& file, std::vector<Variable> group, Lattice lattice,
                       std::vector<GridRequest> requests) {
  DenseGrids dense;
  dense.name = file->path();
  for (const Variable& variable : group) {
    dense.where.push_back(where_of(file->path(), variable.name));
    dense.units.push_back(variable.units);
  }
  dense.grids = std::move(requests);
  dense.index_to_local = lattice.index_to_local;
  dense.resolution = lattice.resolution;
  dense.slab_axis = slowest_axis(group.front());
  std::vector<std::size_t> times;
  for (const GridRequest& request : dense.grids) times.push_back(request.time);
  dense.read = [file, group = std::move(group), lattice = std::move(lattice), times = std::move(times)](
                   std::size_t grid, const Box3i& box, std::span<float> values) {
    read_box(*file, group[grid], lattice, times[grid], box, values);
  };
  return dense;
}

std::string type_name(nc_type type) {
  switch (type) {
    case NC_BYTE:
      return "int8";
    case NC_UBYTE:
      return "uint8";
    case NC_SHORT:
      return "int16";
    case NC_USHORT:
      return "uint16";
    case NC_INT:
      return "int32";
    case NC_UINT:
      return "uint32";
    case NC_INT64:
      return "int64";
    case NC_UINT64:
      return "uint64";
    case NC_FLOAT:
      return "float32";
    default:
      return "float64";
  }
}

std::size_t bytes_of(nc_type type) {
  return type == NC_BYTE || type == NC_UBYTE                          ? 1
         : type == NC_SHORT || type == NC_USHORT                      ? 2
         : type == NC_DOUBLE || type == NC_INT64 || type == NC_UINT64 ? 8
                                                                      : 4;
}

}  // namespace

std::vector<GridInfo> inspect_netcdf(const std::filesystem::path& path) {
  const auto file = std::make_shared<NetcdfFile>(path);
  std::vector<GridInfo> result;
  for (const Variable& variable : variables(*file)) {
    const Lattice lattice = lattice_of(*file, variable);
    GridInfo info = describe_lattice(variable.name, lattice.index_to_local, lattice.resolution);
    info.type = type_name(variable.type);
    info.units = variable.units;
    info.times = variable.times;
    if (variable.times > 0) {
      const SlabRange range = range_of(dense_grids(file, {variable}, lattice, {{.name = variable.name}}), 0);
      info.min = range.min;
      info.max = range.max;
      info.active = range.nonzero;
    }
    info.bytes_source = info.bytes_dense / sizeof(float) * bytes_of(variable.type);
    result.push_back(info);
  }
  return result;
}

std::vector<VoxelStream> open_netcdf(const std::filesystem::path& path, const std::vector<GridRequest>& requests) {
  const auto file = std::make_shared<NetcdfFile>(path);
  const std::vector<Variable> all = variables(*file);
  std::vector<std::string> names;
  for (const Variable& variable : all) names.push_back(variable.name);
  check_names(path, names, requests);

  struct Group {
    std::vector<Variable> variables;
    std::vector<GridRequest> requests;
    Lattice lattice;
  };
  std::vector<Group> groups;
  for (const GridRequest& request : requests) {
    const Variable& variable =
        *std::find_if(all.begin(), all.end(), [&](const Variable& v) { return v.name == request.name; });
    if (request.time >= variable.times)
      throw InputError(where_of(path, request.name), fmt::format("has no step {}", request.time),
                       fmt::format("it has {} steps, counted from 0", variable.times));
    Lattice lattice = lattice_of(*file, variable);
    auto home = std::find_if(groups.begin(), groups.end(), [&](const Group& group) {
      return group.lattice.resolution == lattice.resolution && group.variables.front().place == variable.place &&
             same_lattice(group.lattice.index_to_local, lattice.index_to_local, Box3i(Vec3i(0), lattice.resolution));
    });
    if (home == groups.end()) {
      home = groups.emplace(groups.end());
      home->lattice = std::move(lattice);
    }
    home->variables.push_back(variable);
    home->requests.push_back(request);
  }
  std::vector<VoxelStream> streams;
  for (Group& group : groups)
    streams.push_back(stream_slabs(
        dense_grids(file, std::move(group.variables), std::move(group.lattice), std::move(group.requests))));
  return streams;
}

}  // namespace obscura::detail
