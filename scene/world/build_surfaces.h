// The surfaces of a scene's World: opens meshes and terrain, places objects, works out materials.
#pragma once

#include "photon/world/world.h"
#include "scene/file/description.h"

namespace obscura {

/// Fills `contents.materials` and `contents.objects` from the scene, whose bands `contents` has already.
/// Objects of the same mesh and temperature files share one Mesh. Material 0 is black.
/// @throws InputError with every mesh that is broken and every group that no mesh has
void build_surfaces(const Description& scene, WorldContents& contents);

}  // namespace obscura
