// The scene file's published JSON Schema, made from the same keys as the reader.
#pragma once

#include <string>

namespace obscura {

/// JSON Schema (2020-12) of scene files, as in scene/scene.schema.json. It says what each key holds; what
/// keys mean together (directions, grey bands, files that exist) only the reader can check.
std::string scene_schema();

}  // namespace obscura
