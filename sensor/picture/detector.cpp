#include "sensor/picture/detector.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

#include "octree/base/math.h"
#include "photon/optics/purpose.h"

namespace obscura {
namespace {

// Two independent numbers of the standard normal law (Box and Muller, Ann. Math. Stat. 29, 1958).
std::array<double, 2> normal_pair(Stream& stream) noexcept {
  const double radius = std::sqrt(-2 * std::log(stream.uniform()));
  const double angle = 2 * kPi * stream.uniform();
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

// Frames of one seed at different times have different noise.
std::uint64_t noise_seed(const DetectorFrame& frame) noexcept {
  Stream stream =
      StreamName{frame.seed, std::bit_cast<std::uint64_t>(frame.time_s + 0.0), Purpose::detector_noise}.stream();
  const std::uint64_t high = stream.bits();
  return high << 32 | stream.bits();
}

// Values that float32 cannot hold are cut, so that the image has none that is not finite.
float stored(double value) noexcept {
  constexpr double most = std::numeric_limits<float>::max();
  return static_cast<float>(std::clamp(value, -most, most));
}

std::vector<bool> pixels_done(const Image& image) {
  std::vector<bool> done(image.pixel_count(), true);
  if (!image.has("rays.N")) return done;
  const auto rays = image.channel("rays.N");
  for (std::size_t i = 0; i < done.size(); ++i) done[i] = rays[i] > 0;
  return done;
}

std::vector<double> spread_by(const DetectorSettings& settings, std::vector<double> values, int columns, int rows) {
  if (settings.psf_sigma_px > 0) {
    const PointSpread row = gaussian_row(settings.psf_sigma_px);
    values = spread(values, columns, rows, row);
    values = spread(values, columns, rows, row.transposed());
  }
  if (!settings.psf.empty()) values = spread(values, columns, rows, settings.psf);
  return values;
}

// The radiance after the optics. Pixels that were never done lend no light: their weight goes to the others.
std::vector<double> arriving(const Image& image, const std::string& channel, const std::vector<bool>& done,
                             const DetectorSettings& settings) {
  const auto sharp = image.channel(channel);
  std::vector<double> values(sharp.begin(), sharp.end());
  if (!(settings.psf_sigma_px > 0) && settings.psf.empty()) return values;
  const bool whole = std::ranges::find(done, false) == done.end();
  std::vector<double> weights;
  if (!whole) {
    weights.resize(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      weights[i] = done[i] ? 1 : 0;
      values[i] *= weights[i];
    }
    weights = spread_by(settings, std::move(weights), image.columns(), image.rows());
  }
  values = spread_by(settings, std::move(values), image.columns(), image.rows());
  for (std::size_t i = 0; i < weights.size(); ++i) values[i] = done[i] && weights[i] > 0 ? values[i] / weights[i] : 0;
  return values;
}

// What one pixel of the device does to radiance.
struct PixelResponse {
  bool dead = false;
  double gain = 1;
  double offset = 0;
};

PixelResponse response_of(const DetectorSettings& settings, std::uint64_t seed, std::size_t pixel, int band) noexcept {
  PixelResponse response;
  Stream stream = StreamName{seed, pixel, Purpose::detector_pattern, band}.stream();
  response.dead = stream.uniform() < settings.dead_share;
  if (settings.gain_nonuniformity > 0 || settings.offset_nonuniformity > 0) {
    const auto [gain, offset] = normal_pair(stream);
    response.gain = std::max(0.0, 1 + settings.gain_nonuniformity * gain);
    response.offset = settings.offset_nonuniformity * offset;
  }
  return response;
}

struct Outputs {
  std::span<float> signal, calibrated, counts;  // counts empty: no quantisation
};

DetectorTally add(DetectorTally a, const DetectorTally& b) {
  a.dead += b.dead;
  a.above += b.above;
  a.below += b.below;
  return a;
}

// From radiance to signal and counts, pixel by pixel.
DetectorTally read_out(const std::vector<double>& radiance, const std::vector<bool>& done,
                       const DetectorSettings& settings, const DetectorFrame& frame, double sigma, int band,
                       const Outputs& out) {
  const std::uint64_t device = settings.seed.value_or(frame.seed);
  const std::uint64_t noise = noise_seed(frame);
  const double top = std::ldexp(1.0, settings.bits) - 1;
  const double low = settings.range[0], width = settings.range[1] - settings.range[0];
  const auto read = [&](const tbb::blocked_range<std::size_t>& range, DetectorTally tally) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      if (!done[i]) continue;
      const PixelResponse pixel = response_of(settings, device, i, band);
      double value = radiance[i];
      if (sigma > 0) {
        Stream stream = StreamName{noise, i, Purpose::detector_noise, band}.stream();
        value += sigma * normal_pair(stream)[0];
      }
      value = pixel.dead ? 0 : pixel.gain * value + pixel.offset;
      const double signal = settings.gain * value + settings.offset;
      out.signal[i] = stored(signal);
      out.calibrated[i] = stored(value);
      if (!out.counts.empty()) {
        const double level = (signal - low) / width * top;
        out.counts[i] = static_cast<float>(std::clamp(std::round(level), 0.0, top));
      }
      const bool live_counts = !pixel.dead && !out.counts.empty();
      tally.dead += pixel.dead ? 1 : 0;
      tally.above += live_counts && signal > settings.range[1] ? 1 : 0;
      tally.below += live_counts && signal < low ? 1 : 0;
    }
    return tally;
  };
  return tbb::parallel_reduce(tbb::blocked_range<std::size_t>(0, radiance.size(), 4096), DetectorTally{}, read, add);
}

std::string settings_text(const DetectorSettings& s, const DetectorFrame& frame) {
  std::string psf;
  if (!s.psf.empty()) psf = fmt::format(R"("psf_px": [{}, {}], )", s.psf.columns, s.psf.rows);
  std::string time;
  if (s.integration_s && s.reference_integration_s) {
    time = fmt::format(R"("integration_s": {}, "reference_integration_s": {}, )", *s.integration_s,
                       *s.reference_integration_s);
  }
  return fmt::format(R"({{"psf_sigma_px": {}, {}"nedt_K": {}, "nedt_at_K": {}, "ner": {}, {}"dead_share": {}, )"
                     R"("gain_nonuniformity": {}, "offset_nonuniformity": {}, "gain": {}, "offset": {}, "bits": {}, )"
                     R"("range": [{}, {}], "seed": {}}})",
                     s.psf_sigma_px, psf, s.nedt_K, s.nedt_at_K, s.ner, time, s.dead_share, s.gain_nonuniformity,
                     s.offset_nonuniformity, s.gain, s.offset, s.bits, s.range[0], s.range[1],
                     s.seed.value_or(frame.seed));
}

}  // namespace

bool DetectorSettings::on() const noexcept {
  return psf_sigma_px > 0 || !psf.empty() || noisy() || dead_share > 0 || gain_nonuniformity > 0 ||
         offset_nonuniformity > 0 || gain != 1 || offset != 0 || bits > 0 || !bands.empty();
}

DetectorSettings DetectorSettings::of_band(const std::string& name) const {
  DetectorSettings result = *this;
  result.bands.clear();
  const auto found = bands.find(name);
  if (found == bands.end()) return result;
  const DetectorBand& own = found->second;
  if (own.psf_sigma_px) result.psf = {};
  if (own.nedt_K) result.ner = 0;
  if (own.ner) result.nedt_K = 0;
  result.psf_sigma_px = own.psf_sigma_px.value_or(result.psf_sigma_px);
  result.nedt_K = own.nedt_K.value_or(result.nedt_K);
  result.ner = own.ner.value_or(result.ner);
  result.gain = own.gain.value_or(result.gain);
  result.offset = own.offset.value_or(result.offset);
  result.range = own.range.value_or(result.range);
  return result;
}

double noise_radiance(const DetectorSettings& detector, const Band& band) {
  const DetectorSettings settings = detector.of_band(band.name());
  double sigma = settings.ner;
  if (settings.nedt_K > 0) {
    if (band.grey()) {
      throw InputError("nedt_K", fmt::format("a temperature says nothing in the grey band \"{}\"", band.name()),
                       "give \"ner\" instead, or give the band \"um\"");
    }
    sigma = settings.nedt_K * band.planck_derivative(settings.nedt_at_K);
  }
  if (settings.integration_s && settings.reference_integration_s) {
    sigma *= std::sqrt(*settings.reference_integration_s / *settings.integration_s);
  }
  return sigma;
}

std::vector<DetectorTally> detect(Image& image, std::span<const Band> bands, const DetectorSettings& detector,
                                  const DetectorFrame& frame) {
  std::vector<DetectorTally> tallies;
  if (!detector.on()) return tallies;
  const std::vector<bool> done = pixels_done(image);
  int index = 0;
  for (const Band& band : bands) {
    const DetectorSettings settings = detector.of_band(band.name());
    assert(settings.bits >= 0 && settings.bits <= 16 && settings.range[1] > settings.range[0]);
    const double sigma = noise_radiance(settings, band);
    const std::vector<double> radiance = arriving(image, band.name() + ".radiance", done, settings);
    std::vector<float> calibrated(image.pixel_count());
    Outputs out;
    out.signal = image.add(band.name() + ".detector");
    out.calibrated = calibrated;
    if (settings.bits > 0) out.counts = image.add(band.name() + ".counts");
    DetectorTally tally = read_out(radiance, done, settings, frame, sigma, index++, out);
    tally.band = band.name();
    if (!band.grey()) fill_temperature(band, calibrated, image.add(band.name() + ".detector_temperature"));

    const std::string key = "obscura:detector." + band.name();
    image.metadata[key + ".settings"] = settings_text(settings, frame);
    image.metadata[key + ".noise_radiance"] = sigma;
    image.metadata[key + ".dead"] = static_cast<double>(tally.dead);
    if (settings.bits > 0) {
      image.metadata[key + ".above_range"] = static_cast<double>(tally.above);
      image.metadata[key + ".below_range"] = static_cast<double>(tally.below);
    }
    tallies.push_back(std::move(tally));
  }
  return tallies;
}

}  // namespace obscura
