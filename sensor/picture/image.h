// The image: named channels of float32 and what made them. Files are image_io.h's.
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "photon/optics/band.h"
#include "sensor/capture/camera.h"
#include "sensor/capture/film.h"

namespace obscura {

using MetadataValue = std::variant<int, double, std::string>;
using Metadata = std::map<std::string, MetadataValue>;

class Image {
 public:
  /// Without channels. @pre both sides >= 1
  Image(int columns, int rows);

  int columns() const noexcept { return columns_; }
  int rows() const noexcept { return rows_; }
  std::size_t pixel_count() const noexcept {
    return static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  }

  /// In the order in which they were added.
  const std::vector<std::string>& channels() const noexcept { return names_; }
  bool has(std::string_view name) const noexcept;

  /// A new channel of zeros, row by row from the top left. @pre no channel has this name
  std::span<float> add(std::string name);
  /// @throws InputError that lists the channels, where there is none of this name.
  std::span<const float> channel(std::string_view name) const;

  /// Keys are those of the file, "obscura:seed" for one.
  Metadata metadata;

 private:
  int columns_;
  int rows_;
  std::vector<std::string> names_;
  std::vector<std::vector<float>> values_;
};

/// What an effect that was left out may have changed at most, in pixels that show what it touches.
struct LeftOut {
  double radiance = 0;  ///< W/m2/sr
  double share = 0;     ///< and of the pixel's own
  bool clouds = false, surfaces = false, sky = false;
};

/// What the film cannot know and the image should tell.
struct ImageOrigin {
  CameraSettings camera;
  std::uint64_t seed = 1;
  std::string scene_name;
  /// Hash of the scene as it was read.
  std::string scene_hash;
  std::string method;
  double time_s = 0;
  /// Sum of the bounds of effects that were left out, as a share of a pixel.
  double dropped_bound = 0;
  /// The same of each band, for the errors of its pixels; empty: nothing was left out.
  std::vector<std::vector<LeftOut>> left_out;
  /// Channels `<band>.bias` and `<band>.transmission_atmosphere`: only where they have a meaning.
  bool has_bias = false;
  /// The film's bias is all that a method without chance knows of its error: it is the error.
  bool bias_is_error = false;
  bool has_atmosphere = false;
  /// Channel rays.criterion.
  bool has_criterion = false;
};

/// The film as an image, its channels as scene/FORMAT.md, "Image", lists them: per band radiance, error,
/// bias, transmission, transmission_atmosphere, temperature (not for grey); then depth.Z, object.id,
/// rays.N, rays.criterion (a number of Criterion; metadata names them). An error is the film's standard error + b
/// / 1.96 with b the sum of the bounds on what was left out at that pixel: 95 % intervals hold both.
/// @pre as many bands as the film has
Image develop(const Film& film, std::span<const Band> bands, const ImageOrigin& origin);

/// Kelvin of the blackbody with each radiance; 0 where that is <= 0. @pre as many, the band is not grey
void fill_temperature(const Band& band, std::span<const float> radiance, std::span<float> kelvin);

/// Names of the bands: all X of channels "X.radiance"; in the scene's order where the metadata tell it (a file sorts
/// its channels), else in the image's.
std::vector<std::string> band_names(const Image& image);

}  // namespace obscura
