// Where an adaptive picture has spent its rays, and on what, in false colours.
#pragma once

#include "sensor/picture/image.h"
#include "sensor/picture/raster.h"

namespace obscura {

/// Rays per pixel beside the criterion that asked for most of them, each criterion in a colour of its own with its
/// share of the pixels.
/// @throws InputError where the image has no channel rays.criterion: it was sampled alike everywhere
Raster rays_picture(const Image& image);

}  // namespace obscura
