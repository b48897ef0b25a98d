// The kinds of volume files that can be read, each written once: in the table below. Reading, messages, the keys of a
// scene and the help of the program follow from it. To add a kind: a <kind>_io.cpp that has its two functions, a line
// here, and a test.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "octree/source/grid_request.h"
#include "octree/source/voxels.h"

namespace obscura {

/// One kind of volume file.
struct VolumeFormat {
  std::string name;                     ///< as users call it, to stand in a sentence
  std::vector<std::string> extensions;  ///< lower case, with the dot, the usual one first
  /// Whether the file says where its lattice ends. Without that a cloud of it repeats only with a period that the
  /// scene gives: the box of its voxels is as large as what they hold.
  bool tells_lattice_size;
  /// What inspect_volume() and open_volume() (import.h) return and throw. The file is there and is no folder, and the
  /// request is not empty; whether the file is whole and holds the grids is for these to say.
  std::vector<GridInfo> (*inspect)(const std::filesystem::path& file);
  std::vector<VoxelStream> (*open)(const std::filesystem::path& file, const std::vector<GridRequest>& grids);
};

namespace detail {

std::vector<GridInfo> inspect_vdb(const std::filesystem::path& file);
std::vector<VoxelStream> open_vdb(const std::filesystem::path& file, const std::vector<GridRequest>& grids);

std::vector<GridInfo> inspect_nvdb(const std::filesystem::path& file);
std::vector<VoxelStream> open_nvdb(const std::filesystem::path& file, const std::vector<GridRequest>& grids);

std::vector<GridInfo> inspect_netcdf(const std::filesystem::path& file);
std::vector<VoxelStream> open_netcdf(const std::filesystem::path& file, const std::vector<GridRequest>& grids);

std::vector<GridInfo> inspect_les(const std::filesystem::path& file);
std::vector<VoxelStream> open_les(const std::filesystem::path& file, const std::vector<GridRequest>& grids);

std::vector<GridInfo> inspect_raw(const std::filesystem::path& file);
std::vector<VoxelStream> open_raw(const std::filesystem::path& file, const std::vector<GridRequest>& grids);

}  // namespace detail

/// The table. No two formats share an extension.
inline const std::vector<VolumeFormat>& volume_formats() {
  static const std::vector<VolumeFormat> formats = {
      {"OpenVDB", {".vdb"}, false, detail::inspect_vdb, detail::open_vdb},
      {"NanoVDB", {".nvdb"}, false, detail::inspect_nvdb, detail::open_nvdb},
      {"NetCDF", {".nc"}, true, detail::inspect_netcdf, detail::open_netcdf},
      {"LES text", {".txt"}, true, detail::inspect_les, detail::open_les},
      {"raw voxels", {".json"}, true, detail::inspect_raw, detail::open_raw},
  };
  return formats;
}

/// The format of a file, by the extension of its name in upper or lower case; null where no format has it. Opens
/// nothing.
const VolumeFormat* volume_format_of(const std::filesystem::path& file);

/// The extensions of all formats, in the table's order.
std::vector<std::string> volume_extensions();

/// "OpenVDB (.vdb), NanoVDB (.nvdb), ... or raw voxels (.json)", for messages and help.
std::string volume_format_list();

}  // namespace obscura
