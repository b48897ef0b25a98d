// What a camera sees as a value that knows no pixels: for decisions about effects.
#pragma once

#include "photon/limits/media_summary.h"
#include "sensor/capture/camera.h"

namespace obscura {

/// At most 12 x 9 pixels all over the image with 2 x 2 rays each, and the planes that bound the image with a pixel's
/// margin: ray spots reach beyond the border by half of one. A fisheye has no such planes.
CameraView view_of(const Camera& camera);

}  // namespace obscura
