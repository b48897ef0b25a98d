// Text fields of large-eddy simulations, as the 3D radiative transfer community passes them on:
// sizes, spacings and levels in km, then one line per cloudy point. Grid points are cell centres.
//
//   # comment                    # comment
//   nx,ny,nz                     nx ny nz
//   dx,dy                        dx dy z1 ... znz
//   z1,...,znz                   i j k lwc reff
//   x,y,z,lwc,reff               ...
//   i,j,k,lwc,reff
//   ...
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <tuple>

#include "octree/base/error.h"
#include "octree/io/reading.h"
#include "octree/source/slabs.h"
#include "octree/source/sparse_grid.h"

namespace obscura::detail {
namespace {

constexpr double kMetres = 1000;  // in a km of the file

struct CornerOrder {
  bool operator()(const Vec3i& a, const Vec3i& b) const noexcept {
    return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x);
  }
};

struct LesField {
  std::vector<std::string> names;  // of the value columns
  Vec3i resolution{0, 0, 0};
  Affine index_to_local;
  std::uint64_t points = 0;
  /// Corner to 512 values per column; what isn't listed is 0.
  std::map<Vec3i, std::vector<float>, CornerOrder> bricks;
};

class LesReader {
 public:
  explicit LesReader(const std::filesystem::path& path) : path_(path.string()), file_(path) {
    if (!file_) throw InputError(path_, "can't be opened", "check its permissions");
  }

  LesField read() {
    LesField field;
    for (int axis = 0; axis < 3; ++axis) {
      const double n = header_number("the sizes nx, ny, nz");
      if (!(n >= 1 && n <= 1 << 20) || n != std::floor(n))
        fail(fmt::format("{} is not a size", n), "whole numbers from 1 on");
      field.resolution[axis] = static_cast<int>(n);
    }
    Vec3d voxel;
    for (int axis = 0; axis < 2; ++axis) {
      voxel[axis] = header_number("the spacings dx, dy") * kMetres;
      if (!(voxel[axis] > 0)) fail("a spacing is not positive", "spacings in km");
    }
    std::vector<double> levels;
    for (int k = 0; k < field.resolution.z; ++k) levels.push_back(header_number("one level for each of nz") * kMetres);
    voxel.z = level_spacing(levels);
    if (token_ < tokens_.size()) fail(fmt::format("more levels than nz = {}", field.resolution.z), "give nz levels");

    field.index_to_local.setScale(voxel);
    const Vec3d origin(-0.5 * voxel.x, -0.5 * voxel.y, levels.front() - 0.5 * voxel.z);
    for (int axis = 0; axis < 3; ++axis) field.index_to_local[3][axis] = origin[axis];

    // A line of names, or the two columns that are usual.
    field.names = {"lwc", "reff"};
    bool more = next_line();
    if (more && !is_number(tokens_.front())) {
      if (tokens_.size() < 4) fail("the line of names has no value column", "x,y,z and the values' names");
      field.names.assign(tokens_.begin() + 3, tokens_.end());
      more = next_line();
    }
    for (; more; more = next_line()) read_point(field);
    if (field.points == 0) fail("the file lists no point", "one line i,j,k and values per cloudy point");
    return field;
  }

 private:
  [[noreturn]] void fail(const std::string& problem, const std::string& hint) const {
    throw InputError(fmt::format("{}: line {}", path_, line_), problem, hint);
  }

  /// The next line that holds tokens; '#' begins a comment, commas and blanks separate.
  bool next_line() {
    std::string text;
    while (std::getline(file_, text)) {
      ++line_;
      text.erase(std::find(text.begin(), text.end(), '#'), text.end());
      tokens_.clear();
      token_ = 0;
      std::size_t begin = 0;
      const auto separates = [](char c) { return c == ',' || c == ' ' || c == '\t' || c == '\r'; };
      while (begin < text.size()) {
        if (separates(text[begin])) {
          ++begin;
          continue;
        }
        std::size_t end = begin;
        while (end < text.size() && !separates(text[end])) ++end;
        tokens_.push_back(text.substr(begin, end - begin));
        begin = end;
      }
      if (!tokens_.empty()) return true;
    }
    if (file_.bad()) throw ResourceError(path_, "reading failed");
    return false;
  }

  static bool is_number(const std::string& text) {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc{} && end == text.data() + text.size();
  }
  double number(const std::string& text) const {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size())
      fail(fmt::format("'{}' is not a number", text), "see the LES text format");
    return value;
  }
  double header_number(const char* what) {
    if (token_ == tokens_.size() && !next_line())
      throw InputError(path_, line_ == 0 ? "the file is empty" : fmt::format("the file ends before {}", what),
                       "an LES text begins with nx,ny,nz; dx,dy; levels");
    if (!is_number(tokens_[token_]))
      fail(fmt::format("'{}' stands where {} belong", tokens_[token_], what), "give numbers");
    return number(tokens_[token_++]);
  }

  /// The one spacing of all levels. A level may be off by 1 % of it and by the rounding of its print.
  double level_spacing(const std::vector<double>& levels) const {
    if (levels.size() == 1) fail("one level doesn't say how thick it is", "give at least two levels");
    const double spacing = (levels.back() - levels.front()) / static_cast<double>(levels.size() - 1);
    if (!(spacing > 0)) fail("the levels don't increase", "list them from the ground up");
    const double rounding = kMetres * 1e-3;
    for (std::size_t k = 0; k < levels.size(); ++k) {
      const double uniform = levels.front() + spacing * static_cast<double>(k);
      if (std::abs(levels[k] - uniform) > 0.01 * spacing + std::min(rounding, 0.05 * spacing))
        fail(fmt::format("level {} lies at {} m, not at {} m as even spacing would have it", k, levels[k], uniform),
             "LES text needs evenly spaced levels; resample it, or pass the field as NetCDF");
    }
    return spacing;
  }

  void read_point(LesField& field) {
    const std::size_t columns = field.names.size();
    if (tokens_.size() != 3 + columns)
      fail(fmt::format("{} numbers, not {}", tokens_.size(), 3 + columns),
           "i, j, k and a value per grid; the line may be cut off");
    Vec3i voxel;
    for (int axis = 0; axis < 3; ++axis) {
      const double index = number(tokens_[axis]);
      if (!(index >= 0 && index < field.resolution[axis]) || index != std::floor(index))
        fail(fmt::format("index {} lies outside 0 to {}", tokens_[axis], field.resolution[axis] - 1),
             "indices count from 0");
      voxel[axis] = static_cast<int>(index);
    }
    const Vec3i corner(voxel.x & ~7, voxel.y & ~7, voxel.z & ~7);
    auto& values = field.bricks[corner];
    values.resize(512 * columns, 0.0f);
    const Vec3i in = voxel - corner;
    const auto place = static_cast<std::size_t>(in.x + 8 * in.y + 64 * in.z);
    for (std::size_t c = 0; c < columns; ++c) {
      const double value = number(tokens_[3 + c]);
      if (!std::isfinite(value))
        throw InputError(fmt::format("{}: line {}: grid '{}'", path_, line_, field.names[c]),
                         fmt::format("voxel ({}, {}, {}) holds {}", voxel.x, voxel.y, voxel.z, tokens_[3 + c]),
                         "values must be finite");
      values[512 * c + place] = static_cast<float>(value);
    }
    ++field.points;
  }

  std::string path_;
  std::ifstream file_;
  std::vector<std::string> tokens_;
  std::size_t token_ = 0;
  std::size_t line_ = 0;
};

/// Of the columns that the format itself names.
std::string units_of(const std::string& column) { return column == "lwc" ? "g m-3" : column == "reff" ? "um" : ""; }

std::vector<SparseGrid> read_grids(const std::filesystem::path& path, const std::vector<GridRequest>& requests) {
  auto field = std::make_shared<const LesField>(LesReader(path).read());
  check_names(path, field->names, requests);
  std::vector<SparseGrid> result;
  for (const GridRequest& request : requests) {
    const auto column = static_cast<std::size_t>(std::find(field->names.begin(), field->names.end(), request.name) -
                                                 field->names.begin());
    SparseGrid grid;
    grid.request = request;
    grid.where = where_of(path, request.name);
    grid.units = units_of(request.name);
    grid.index_to_local = field->index_to_local;
    grid.extent = Box3i(Vec3i(0), field->resolution);
    auto bricks = std::make_shared<std::vector<const float*>>();
    for (const auto& [corner, values] : field->bricks) {
      grid.bricks.push_back(corner);
      bricks->push_back(values.data() + 512 * column);
    }
    grid.read = [field, bricks](std::size_t brick, std::span<float, 512> values) {
      std::copy_n((*bricks)[brick], 512, values.begin());
    };
    result.push_back(std::move(grid));
  }
  return result;
}

}  // namespace

std::vector<GridInfo> inspect_les(const std::filesystem::path& path) {
  const LesField field = LesReader(path).read();
  std::vector<GridInfo> result;
  for (std::size_t c = 0; c < field.names.size(); ++c) {
    GridInfo info = describe_lattice(field.names[c], field.index_to_local, field.resolution);
    info.type = "text";
    info.units = units_of(field.names[c]);
    info.active = field.points;
    info.min = kInfinity;
    info.max = -kInfinity;
    for (const auto& [corner, values] : field.bricks)
      for (std::size_t v = 512 * c; v < 512 * (c + 1); ++v) {
        info.min = std::min<double>(info.min, values[v]);
        info.max = std::max<double>(info.max, values[v]);
      }
    info.bytes_source = std::filesystem::file_size(path);
    result.push_back(info);
  }
  return result;
}

std::vector<VoxelStream> open_les(const std::filesystem::path& file, const std::vector<GridRequest>& grids) {
  return make_streams(file.string(), read_grids(file, grids));
}

}  // namespace obscura::detail
