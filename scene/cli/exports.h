// The outputs of an image, as options of the commands: render has all of them, export those for other programs.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "commands.h"
#include "console.h"
#include "sensor/picture/image_outputs.h"

namespace obscura::cli {

/// What the command line asks for.
struct Exports {
  std::map<std::string, std::string> files;  ///< by option, "--envi"; empty: not asked for
  std::string quantity = "radiance";
  std::vector<int> region, line;  ///< empty, or four numbers

  /// Whether an output is asked for that obeys --quantity.
  bool takes_quantity() const;
};

/// The options of the table's outputs that are of this use. @pre `exports` outlives the parsing
void add_output_options(CLI::App& app, Exports& exports, OutputUse use);

/// The same for OutputUse::other, and what they may be told: quantity and pixels.
void add_export_options(CLI::App& app, Exports& exports);

/// What is known of an image before there is one.
struct ExportSource {
  std::vector<std::string> bands;
  std::array<int, 2> resolution{1, 1};
  std::vector<std::string> quantities;  ///< that every band has: "radiance", "counts" ...
  std::string no_counts;                ///< what to do where an output needs counts and there are none
};

/// The files of all outputs of this use that are asked for, for check_outputs(); and what cannot be, as problems.
std::vector<Output> export_outputs(const Exports& exports, OutputUse use, const ExportSource& source,
                                   std::vector<Problem>& problems);

/// Writes all outputs of this use that are asked for.
/// @throws InputError where the image lacks what is asked for, ResourceError where a file cannot be written
void write_exports(const Exports& exports, OutputUse use, const Image& image);

}  // namespace obscura::cli
