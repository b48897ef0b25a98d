// Previews: a channel in colours with a scale beside it, for eyes; the numbers are in the image.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sensor/picture/image.h"
#include "sensor/picture/raster.h"

namespace obscura {

struct PreviewSettings {
  /// Nothing: grey for radiance and transmission below 2.5 um and without wavelength, inferno for
  /// the thermal infrared, viridis for errors.
  std::optional<ColourMap> colours;
  /// Ends of the colours; nothing: the percentiles that leave out `cut` of the pixels at each end.
  std::optional<double> low, high;
  double cut = 0.002;
  /// Title and scale.
  bool legend = true;
  /// Per pixel, row by row, or nothing: between two pixels of different marks a line is drawn, on the side of the
  /// smaller one, in blue around marks of 1 and in green around higher ones.
  std::vector<std::uint8_t> marks;
  /// Screen pixels per image pixel; 0: as many as make a small image visible.
  int magnify = 0;
};

/// One channel as a picture. Pixels never done and infinite depths are dark blue-grey.
/// @throws InputError where the image has no such channel
Raster preview(const Image& image, const std::string& channel, const PreviewSettings& settings = {});

/// What there is to see of a band, side by side: apparent temperature (grey: none), radiance,
/// transmission, and the error in per cent of the radiance.
Raster preview_sheet(const Image& image, const std::string& band);

/// As PNG files. @throws InputError as above, ResourceError where it cannot be written
void write_preview(const std::filesystem::path& path, const Image& image, const std::string& channel,
                   const PreviewSettings& settings = {});
void write_preview_sheet(const std::filesystem::path& path, const Image& image, const std::string& band);

}  // namespace obscura
