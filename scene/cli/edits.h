// Changes to a scene from the command line.
#pragma once

#include "scene/scene_io.h"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace obscura::cli {

/// What `--set /json/pointer=value` asks for; what is not of that form goes to `problems`.
std::vector<SceneEdit> set_edits(const std::vector<std::string>& texts, std::vector<Problem>& problems);

/// What `--effect NAME=on|off` asks for.
std::vector<SceneEdit> effect_edits(const std::vector<std::string>& texts, std::vector<Problem>& problems);

CLI::Option* add_effect_option(CLI::App& app, std::vector<std::string>& texts);

}  // namespace obscura::cli
