// What a scene's values have to be together: names, bands, directions, grey against kelvin.
#pragma once

#include "scene/file/scene_reader.h"

namespace obscura::detail {

/// Fills in names that were not given, makes directions unit vectors, notes problems and warnings.
void check_description(Findings& findings, Description& description);

}  // namespace obscura::detail
