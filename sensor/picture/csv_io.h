// Pixels of an image as a table: a region of interest, or a line.
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <vector>

#include "sensor/picture/image.h"

namespace obscura {

/// Column and row of a pixel, from 0 at the top left.
using PixelPlace = std::array<int, 2>;

/// Row by row. @throws InputError where it is empty or leaves the image
std::vector<PixelPlace> pixels_in_region(int columns, int rows, const std::array<int, 4>& x_y_columns_rows);

/// Both ends and the pixels nearest to the line between them, one for each step along its longer side.
/// @throws InputError where an end is outside the image
std::vector<PixelPlace> pixels_on_line(int columns, int rows, const std::array<int, 4>& x0_y0_x1_y1);

/// A header line and one for each pixel: x, y and all channels, with nine digits, so that each float32 comes back.
/// Infinite depth is inf. @throws ResourceError where it cannot be written
void write_csv(const std::filesystem::path& path, const Image& image, std::span<const PixelPlace> pixels);

}  // namespace obscura
