// Other files of an image: ENVI, counts, tables of pixels. Shared by render and export.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "commands.h"
#include "console.h"
#include "sensor/picture/image.h"

namespace obscura::cli {

struct Exports {
  std::string envi, quantity = "radiance", counts, csv;
  std::vector<int> region, line;  ///< empty, or four numbers
};

void add_export_options(CLI::App& app, Exports& exports);

/// FILE.png for the first band, FILE.<band>.png for the others.
std::filesystem::path file_of_band(const std::string& file, const std::vector<std::string>& bands, std::size_t band);

/// What is known of an image before there is one.
struct ExportSource {
  std::vector<std::string> bands;
  std::array<int, 2> resolution{1, 1};
  bool has_counts = false;
  std::string no_counts;  ///< what to do about it
};

/// The files, for check_outputs(); and what cannot be, as problems.
std::vector<Output> export_outputs(const Exports& exports, const ExportSource& source, std::vector<Problem>& problems);

/// @throws InputError where the image lacks what is asked for, ResourceError
void write_exports(const Exports& exports, const Image& image);

}  // namespace obscura::cli
