// How far an image is from a reference: the image error, and whether the claimed errors explain it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sensor/picture/image.h"

namespace obscura {

/// One channel that both images have, over the pixels that both have done (rays.N > 0, where given).
struct ChannelDifference {
  std::string channel;
  /// RMS over pixels of (L - L_ref) / max(|L_ref|, 0.05 max |L_ref|).
  double image_error = 0;
  double mean = 0;
  double mean_reference = 0;
  /// mean / mean_reference; 1 where both are 0, infinite where the reference alone is.
  double mean_ratio = 1;
  /// Largest |L - L_ref|.
  double max_difference = 0;
  std::uint64_t pixels = 0;
  /// Pixels that are infinite in one image only; those infinite in both agree.
  std::uint64_t mismatched = 0;
  /// Of radiances whose error is known in at least one image: z = (L - L_ref) / sqrt(err^2 +
  /// err_ref^2); near 1 where the errors explain the difference. Pixels whose errors are 0 are left
  /// out where the values are equal, and make it infinite where they are not.
  std::optional<double> z_rms;
  /// Mean of z: far from 0 against 1 / sqrt(pixels) where there is a bias (or shared noise).
  std::optional<double> z_mean;
};

struct Comparison {
  std::vector<ChannelDifference> channels;
  /// Channels of one image alone.
  std::vector<std::string> only_image;
  std::vector<std::string> only_reference;

  /// The largest image error over radiance channels; over all channels where there are none.
  double image_error() const;
  /// For people: one line per channel.
  std::string table() const;
};

/// Compares every common channel, in the reference's order, but for errors, biases and ray counts.
/// @throws InputError where sizes differ, no channel is common or no pixel is done in both
Comparison compare(const Image& image, const Image& reference);

}  // namespace obscura
