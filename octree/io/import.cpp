// Chooses the reader by the file's name.
#include "octree/io/import.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

#include "octree/base/error.h"
#include "octree/io/file_readers.h"

namespace obscura {
namespace detail {

std::string where_of(const std::filesystem::path& path, const std::string& grid) {
  return fmt::format("{}: grid '{}'", path.string(), grid);
}

void check_names(const std::filesystem::path& path, const std::vector<std::string>& present,
                 const std::vector<GridRequest>& requests) {
  std::vector<Problem> problems;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const std::string& name = requests[i].name;
    if (std::find(present.begin(), present.end(), name) == present.end())
      problems.push_back({path.string(), fmt::format("has no grid '{}'", name),
                          present.empty() ? std::string("the file holds no grid")
                                          : fmt::format("it holds: {}", fmt::join(present, ", "))});
    for (std::size_t j = 0; j < i; ++j)
      if (requests[j].name == name)
        problems.push_back({path.string(), fmt::format("grid '{}' is asked for twice", name), "name it once"});
  }
  if (!problems.empty()) throw InputError(problems);
}

namespace {

enum class Format { vdb, nvdb, netcdf, les, raw };

Format format_of(const std::filesystem::path& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw InputError(path.string(), "the file doesn't exist", "check its name");
  if (std::filesystem::is_directory(status)) throw InputError(path.string(), "is a folder", "name a file");
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".vdb") return Format::vdb;
  if (extension == ".nvdb") return Format::nvdb;
  if (extension == ".nc") return Format::netcdf;
  if (extension == ".txt") return Format::les;
  if (extension == ".json") return Format::raw;
  throw InputError(path.string(), fmt::format("volumes of kind '{}' are not known", extension),
                   "use .vdb, .nvdb, .nc, .txt (LES text) or .json (raw voxels)");
}

}  // namespace
}  // namespace detail

std::vector<GridInfo> inspect_volume(const std::filesystem::path& file) {
  switch (detail::format_of(file)) {
    case detail::Format::vdb:
      return detail::inspect_vdb(file);
    case detail::Format::nvdb:
      return detail::inspect_nvdb(file);
    case detail::Format::netcdf:
      return detail::inspect_netcdf(file);
    case detail::Format::les:
      return detail::inspect_les(file);
    case detail::Format::raw:
      break;
  }
  return detail::inspect_raw(file);
}

std::vector<VoxelStream> open_volume(const std::filesystem::path& file, const std::vector<GridRequest>& grids) {
  if (grids.empty()) throw InputError(file.string(), "no grid is asked for", "name at least one");
  // Trees are consumed while they pour, and read again should they pour again.
  const auto sparse = [&](auto* read) {
    return detail::make_streams(file.string(), read(file, grids),
                                [file, read](const std::vector<GridRequest>& again) { return read(file, again); });
  };
  switch (detail::format_of(file)) {
    case detail::Format::vdb:
      return sparse(detail::read_vdb);
    case detail::Format::nvdb:
      return sparse(detail::read_nvdb);
    case detail::Format::netcdf:
      return detail::open_netcdf(file, grids);
    case detail::Format::les:
      return detail::make_streams(file.string(), detail::read_les(file, grids));
    case detail::Format::raw:
      break;
  }
  return detail::open_raw(file, grids);
}

std::vector<VoxelStream> open_volume(const std::filesystem::path& file, const std::vector<std::string>& grids) {
  std::vector<GridRequest> requests;
  for (const std::string& name : grids)
    requests.push_back({.name = name, .require_non_negative = true, .fills_space = true});
  return open_volume(file, requests);
}

}  // namespace obscura
