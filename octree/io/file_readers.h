// What each file format hands to open_volume() and inspect_volume(). Internal to the importers.
#pragma once

#include "octree/io/import.h"
#include "octree/source/sparse_grid.h"

namespace obscura::detail {

std::vector<GridInfo> inspect_vdb(const std::filesystem::path& path);
std::vector<SparseGrid> read_vdb(const std::filesystem::path& path, const std::vector<GridRequest>& requests);

std::vector<GridInfo> inspect_nvdb(const std::filesystem::path& path);
std::vector<SparseGrid> read_nvdb(const std::filesystem::path& path, const std::vector<GridRequest>& requests);

std::vector<GridInfo> inspect_les(const std::filesystem::path& path);
std::vector<SparseGrid> read_les(const std::filesystem::path& path, const std::vector<GridRequest>& requests);

std::vector<GridInfo> inspect_netcdf(const std::filesystem::path& path);
std::vector<VoxelStream> open_netcdf(const std::filesystem::path& path, const std::vector<GridRequest>& requests);

std::vector<GridInfo> inspect_raw(const std::filesystem::path& path);
std::vector<VoxelStream> open_raw(const std::filesystem::path& path, const std::vector<GridRequest>& requests);

/// "file: grid 'name'", as messages name a place.
std::string where_of(const std::filesystem::path& path, const std::string& grid);

/// Every requested name is there, and asked for once.
/// @throws InputError that lists what the file holds.
void check_names(const std::filesystem::path& path, const std::vector<std::string>& present,
                 const std::vector<GridRequest>& requests);

}  // namespace obscura::detail
