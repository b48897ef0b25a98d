// Reads scene files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "octree/base/error.h"
#include "scene/file/description.h"

namespace obscura {

/// A change to a scene before it is read, as by `--set /render/photons=1000`.
struct SceneEdit {
  std::string pointer;      ///< JSON pointer; members that are missing are created
  std::string value;        ///< JSON, or else a text
  std::string option = {};  ///< the option that asked for it, for messages
};

/// @throws InputError with every problem of the scene: where is a JSON pointer, or the file's name with
/// line and column where it is not JSON. Files that the scene names are relative to the scene file.
Description read_scene(const std::filesystem::path& file, const std::vector<SceneEdit>& edits = {});

/// The same from a text. @param base_folder of the files that the scene names
Description parse_scene(const std::string& text, const std::filesystem::path& base_folder,
                        const std::vector<SceneEdit>& edits = {}, const std::string& name = "scene");

}  // namespace obscura
