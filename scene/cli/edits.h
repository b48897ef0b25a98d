// Scenes at the command line: changes to them, and the files that they name.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "octree/base/error.h"
#include "scene/file/scene_io.h"

namespace obscura::cli {

/// What `--set /json/pointer=value` asks for; what is not of that form goes to `problems`.
std::vector<SceneEdit> set_edits(const std::vector<std::string>& texts, std::vector<Problem>& problems);

/// What `--effect NAME=on|off` asks for.
std::vector<SceneEdit> effect_edits(const std::vector<std::string>& texts, std::vector<Problem>& problems);

/// The scene file and, where it could be read, what it names: no output may replace them.
std::vector<std::filesystem::path> input_files(const std::string& scene_file, const std::optional<Description>& scene);

CLI::Option* add_effect_option(CLI::App& app, std::vector<std::string>& texts);

/// Keeps the problems of bad input that `make` throws, so that all of a command's are told in one run.
template <class Make>
void collect(std::vector<Problem>& problems, const Make& make) {
  try {
    make();
  } catch (const InputError& error) {
    problems.insert(problems.end(), error.problems().begin(), error.problems().end());
  }
}

}  // namespace obscura::cli
