// The detector: from the radiance that arrives to what a camera would read. Each stage is off unless asked for;
// the channels that are there stay as they are. Spectral response is the band's own.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "photon/optics/band.h"
#include "sensor/picture/image.h"
#include "sensor/picture/point_spread.h"

namespace obscura {

/// What one band has in place of the others' settings.
struct DetectorBand {
  std::optional<double> psf_sigma_px, nedt_K, ner, gain, offset;
  std::optional<std::array<double, 2>> range;
};

/// In the order in which light and signal meet them. Radiances are W/m2/sr of the band (grey: the band's unit).
struct DetectorSettings {
  /// Standard deviation of a gaussian point spread, pixels; or any other one; 0 and empty: sharp.
  double psf_sigma_px = 0;
  PointSpread psf;

  /// Noise by its equivalent temperature difference at a scene of nedt_at_K (no grey bands), or by its equivalent
  /// radiance: standard deviations of one pixel in one frame.
  double nedt_K = 0;
  double nedt_at_K = 300;
  double ner = 0;
  /// Both or none: the noise is stated at the reference and falls with the root of the time.
  std::optional<double> integration_s, reference_integration_s;

  /// Share of pixels without response; standard deviations over pixels of the gain (relative) and of the offset
  /// (radiance). All of them belong to the device: they are the same in every frame.
  double dead_share = 0;
  double gain_nonuniformity = 0;
  double offset_nonuniformity = 0;

  /// signal = gain * radiance + offset
  double gain = 1;
  double offset = 0;

  /// counts = round((signal - range[0]) / (range[1] - range[0]) * (2^bits - 1)), cut at both ends; 0: none.
  int bits = 0;
  std::array<double, 2> range{0, 1};

  /// Of the device; none: the frame's.
  std::optional<std::uint64_t> seed;

  /// By the band's name.
  std::map<std::string, DetectorBand> bands;

  bool noisy() const noexcept { return nedt_K > 0 || ner > 0; }
  /// Whether anything is asked for, in any band.
  bool on() const noexcept;
  /// The settings of one band, without others. A band's own nedt_K replaces ner, and the other way round; its own
  /// gaussian replaces psf.
  DetectorSettings of_band(const std::string& name) const;
};

/// What makes the noise of one picture differ from that of the next.
struct DetectorFrame {
  std::uint64_t seed = 1;
  double time_s = 0;
};

/// What happened in a band.
struct DetectorTally {
  std::string band;
  std::uint64_t dead = 0;
  /// Pixels, dead ones aside, whose signal is above or below the range and was cut.
  std::uint64_t above = 0;
  std::uint64_t below = 0;
};

/// Standard deviation of the noise in radiance, with what the band has of its own.
/// @throws InputError for nedt_K in a grey band
double noise_radiance(const DetectorSettings& settings, const Band& band);

/// Adds to the image, where the settings ask for anything, `<band>.detector`, the signal before counts; for bands with
/// wavelengths `<band>.detector_temperature`, the kelvin of the signal less offset over gain; with bits
/// `<band>.counts`. Metadata hold each band's settings and tally. Pixels never done stay 0 and lend no light.
/// The same bits for any number of threads. @throws as noise_radiance(), Image::channel()
std::vector<DetectorTally> detect(Image& image, std::span<const Band> bands, const DetectorSettings& settings,
                                  const DetectorFrame& frame);

}  // namespace obscura
