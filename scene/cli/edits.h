// Changes to a scene from the command line.
#pragma once

#include "scene/scene_io.h"

#include <string>
#include <vector>

namespace obscura::cli {

/// What `--set /json/pointer=value` asks for; what is not of that form goes to `problems`.
std::vector<SceneEdit> set_edits(const std::vector<std::string>& texts, std::vector<Problem>& problems);

}  // namespace obscura::cli
