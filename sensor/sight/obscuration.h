// What a cloud does to the sight of an object: the transmission of its lines of sight, its contrast against what is
// around it with and without the cloud, and shares of its area, each with its 95 % interval. Knows no scene.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "photon/optics/band.h"

namespace obscura {

/// A number and the interval that holds its true value in 95 of 100 cases.
struct Confident {
  double value = 0, low = 0, high = 0;
};

/// Where an object is in a picture, and what is around it.
struct ObjectMask {
  int columns = 1, rows = 1;
  /// Of each pixel, row by row from the top left: how much of it shows the object, 0 to 1.
  std::vector<float> share;
  /// 1: the pixel belongs to the surroundings.
  std::vector<std::uint8_t> ring;
  /// Of the ring, pixels.
  int width = 0;

  /// Visible area in pixels.
  double area() const noexcept;
  /// Pixels that show nothing but the object, and pixels of the ring.
  std::size_t interior() const noexcept;
  std::size_t ring_size() const noexcept;
  /// Some of it lies in the picture's outermost pixels: there may be more of it beyond.
  bool at_border() const noexcept;
};

/// Surroundings: pixels without any of the object, at most `width` columns and rows away from one that has some.
/// @param width 0: half the side of a square of the object's area, at least 2 (a window of twice the target's
/// size; sensor/METHODS.md, "Obscuration")
ObjectMask mask_of(int columns, int rows, std::vector<float> share, int width = 0);

/// What lines of sight have found in one band, of equal solid angle each.
struct Look {
  /// Per pixel of the object, in one order for all looks: lines that end on it, and the sum of their radiances.
  std::vector<double> lines, radiance;
  /// The same, of all lines through the ring that do not end on the object.
  double surround_lines = 0, surround_radiance = 0;
  /// Sums of the estimated biases of those radiances, over the object's lines and over the ring's.
  double bias = 0, surround_bias = 0;
};

/// One of several independent repetitions with random numbers of their own: rays, photons and paths. Only the rays
/// are common to the two looks.
struct SightReplica {
  /// Of the clouds, along every line of sight that ends on the object.
  std::vector<float> transmission;
  Look with, without;
};

struct ObscurationSettings {
  /// A line of sight that transmits no more is obscured.
  double transmission = 0.1;
  /// A part of the object whose relative contrast is smaller is lost. 0.02: Koschmieder's observer.
  double contrast = 0.02;
  /// Likewise the difference of apparent temperature, K; none: not asked for.
  std::optional<double> difference_K;
  std::vector<double> percentiles{5, 25, 50, 75, 95};
};

/// An object before its surroundings. What has no value has no meaning: temperatures of grey bands or without light,
/// relative contrast against darkness.
struct SightContrast {
  std::optional<Confident> object, surroundings;      ///< mean radiances
  std::optional<Confident> difference, relative;      ///< L_o - L_s; (L_o - L_s) / L_s
  std::optional<Confident> object_K, surroundings_K;  ///< apparent temperatures of the mean radiances
  std::optional<Confident> difference_K;
  /// Shares of the object's visible area that differ from the surroundings' mean by less than the thresholds.
  std::optional<Confident> lost_contrast, lost_K;
  /// Standard error of one pixel of the object, RMS over them, in units of the radiance: noise that a share below a
  /// threshold must not be made of.
  double pixel_error = 0;
  /// How far the photon map's own bias may have carried the difference: no interval knows of it.
  double difference_bias = 0;
};

struct BandObscuration {
  std::string band;
  bool grey = false;
  std::optional<Confident> transmission;                  ///< mean over the visible area
  double transmission_min = 0, transmission_max = 0;      ///< of the lines that were sent: no interval
  std::vector<std::pair<double, Confident>> percentiles;  ///< of the transmission
  std::optional<Confident> obscured;                      ///< share of the visible area
  SightContrast with, without;
  /// With the cloud over without it; none where the object does not stand out without it.
  std::optional<Confident> difference_ratio, relative_ratio, difference_K_ratio;
  std::vector<std::string> notes;
};

/// @pre two replicas or more, with the same pixels; lines of sight on the object and around it in every one
BandObscuration find_obscuration(const Band& band, std::span<const SightReplica> replicas,
                                 const ObscurationSettings& settings);

}  // namespace obscura
