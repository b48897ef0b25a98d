// ENVI: a text header beside raw numbers, as remote-sensing tools read it.
#pragma once

#include <filesystem>
#include <string>

#include "sensor/picture/image.h"

namespace obscura {

/// Value of pixels that were never done, or that are not finite, in the data.
inline constexpr float kEnviIgnore = -9999;

/// The data's file beside a header: FILE.img of FILE.hdr.
std::filesystem::path envi_data_file(const std::filesystem::path& header);

/// Channels `<band>.<quantity>` of all bands as band-sequential float32, little-endian, and their header. Bands with
/// wavelengths (all or none) are told with centre and width of [um_min, um_max] in micrometres.
/// @param header ends in .hdr @param quantity "radiance", "detector", "temperature" ...
/// @throws InputError where a band has no such channel, ResourceError where it cannot be written
void write_envi(const std::filesystem::path& header, const Image& image, const std::string& quantity = "radiance");

}  // namespace obscura
