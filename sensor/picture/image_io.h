// Image files: OpenEXR for numbers, PNG for eyes, PNG or TIFF for counts. Written under a temporary name and renamed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "sensor/picture/image.h"
#include "sensor/picture/raster.h"

namespace obscura {

/// Writes one part, all channels float32 under their own names, with the metadata. An existing file
/// is replaced, in one step and only by a whole one.
/// @throws ResourceError where it cannot be written
void write_image(const std::filesystem::path& path, const Image& image);

/// Reads the first part of any image that OpenImageIO knows, as float32 (EXR: names and metadata as
/// written; channels in the file's order, which OpenEXR sorts).
/// @throws InputError where the file is missing, broken or deep
Image read_image(const std::filesystem::path& path);

/// 8 bits per colour.
/// @throws ResourceError where it cannot be written
void write_png(const std::filesystem::path& path, const Raster& raster);

/// The same file in memory.
std::vector<std::uint8_t> png_bytes(const Raster& raster);

/// A channel of whole numbers from 0 to 65535 as one channel of 16 bits, the values as they are: PNG where the name
/// ends in .png, else TIFF. @throws InputError where there is no such channel, ResourceError where it cannot be written
void write_counts(const std::filesystem::path& path, const Image& image, const std::string& channel);

}  // namespace obscura
