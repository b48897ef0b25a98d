// Finds a file's format in the table and lets it read; what all formats have in common.
#include "octree/io/import.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

#include "octree/base/error.h"
#include "octree/io/reading.h"
#include "octree/io/volume_formats.h"

namespace obscura {
namespace detail {

std::string where_of(const std::filesystem::path& file, const std::string& grid) {
  return fmt::format("{}: grid '{}'", file.string(), grid);
}

void check_names(const std::filesystem::path& file, const std::vector<std::string>& present,
                 const std::vector<GridRequest>& requests) {
  std::vector<Problem> problems;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const std::string& name = requests[i].name;
    if (std::find(present.begin(), present.end(), name) == present.end())
      problems.push_back({file.string(), fmt::format("has no grid '{}'", name),
                          present.empty() ? std::string("the file holds no grid")
                                          : fmt::format("it holds: {}", fmt::join(present, ", "))});
    for (std::size_t j = 0; j < i; ++j)
      if (requests[j].name == name)
        problems.push_back({file.string(), fmt::format("grid '{}' is asked for twice", name), "name it once"});
  }
  if (!problems.empty()) throw InputError(problems);
}

std::vector<VoxelStream> open_sparse(const std::filesystem::path& file, const std::vector<GridRequest>& requests,
                                     ReadSparse read) {
  return make_streams(file.string(), read(file, requests),
                      [file, read](const std::vector<GridRequest>& again) { return read(file, again); });
}

namespace {

std::string lower_extension_of(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

// The format of a file that is there. @throws InputError where it is not, or where its kind is not known
const VolumeFormat& format_of(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) throw InputError(file.string(), "the file doesn't exist", "check its name");
  if (std::filesystem::is_directory(status)) throw InputError(file.string(), "is a folder", "name a file");
  if (const VolumeFormat* format = volume_format_of(file)) return *format;
  throw InputError(file.string(), fmt::format("volumes of kind '{}' are not known", lower_extension_of(file)),
                   "use " + volume_format_list());
}

}  // namespace
}  // namespace detail

const VolumeFormat* volume_format_of(const std::filesystem::path& file) {
  const std::string extension = detail::lower_extension_of(file);
  for (const VolumeFormat& format : volume_formats())
    if (std::find(format.extensions.begin(), format.extensions.end(), extension) != format.extensions.end())
      return &format;
  return nullptr;
}

std::vector<std::string> volume_extensions() {
  std::vector<std::string> all;
  for (const VolumeFormat& format : volume_formats())
    all.insert(all.end(), format.extensions.begin(), format.extensions.end());
  return all;
}

std::string volume_format_list() {
  const std::vector<VolumeFormat>& formats = volume_formats();
  std::string list;
  for (std::size_t i = 0; i < formats.size(); ++i) {
    const char* const separator = i == 0 ? "" : i + 1 < formats.size() ? ", " : " or ";
    list += fmt::format("{}{} ({})", separator, formats[i].name, fmt::join(formats[i].extensions, ", "));
  }
  return list;
}

std::vector<GridInfo> inspect_volume(const std::filesystem::path& file) {
  return detail::format_of(file).inspect(file);
}

std::vector<VoxelStream> open_volume(const std::filesystem::path& file, const std::vector<GridRequest>& grids) {
  if (grids.empty()) throw InputError(file.string(), "no grid is asked for", "name at least one");
  return detail::format_of(file).open(file, grids);
}

std::vector<VoxelStream> open_volume(const std::filesystem::path& file, const std::vector<std::string>& grids) {
  std::vector<GridRequest> requests;
  for (const std::string& name : grids)
    requests.push_back({.name = name, .require_non_negative = true, .fills_space = true});
  return open_volume(file, requests);
}

}  // namespace obscura
