// Files that a scene names: whether they can be read, and small tables of numbers.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace obscura::detail {

/// Why a file cannot be read ("there is no such file"); empty where it can.
std::string why_unreadable(const std::filesystem::path& file);

/// ".vdb" of "Smoke.VDB", ".asc.gz" of "hill.asc.gz".
std::string lower_extension(const std::filesystem::path& file);

/// Columns of a text table: a header line with exactly these names, then numbers between commas.
/// Empty lines and lines that begin with # are skipped.
struct Table {
  std::vector<std::vector<double>> columns;
  std::string problem;  ///< empty: none
  std::string hint;
};
Table read_table(const std::filesystem::path& file, const std::vector<std::string>& header);

/// The whole file. @throws InputError naming the file where it cannot be read
std::string read_text(const std::filesystem::path& file);

/// Files that a raw-voxel .json or a .gltf names and that cannot be read, as "file: why". Where the .json or .gltf
/// itself is broken, none: its reader tells that.
std::vector<std::string> unreadable_parts(const std::filesystem::path& file);

}  // namespace obscura::detail
