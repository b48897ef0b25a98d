// The detector: each stage alone does what it says, together in their order, and nothing else changes.
#include "sensor/picture/detector.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "octree/base/statistics.h"
#include "sensor/picture/image_io.h"
#include "tests/support/agree.h"
#include "tests/support/chi_square.h"
#include "tests/support/scratch_folder.h"

using namespace obscura;
using obscura::test::agree;
using obscura::test::chi_square;

namespace {

Band lwir() { return Band("lwir", 8, 12); }

// An image of one value in each band.
Image uniform(const std::vector<Band>& bands, int columns, int rows, const std::vector<double>& radiance) {
  Image image(columns, rows);
  for (std::size_t b = 0; b < bands.size(); ++b) {
    std::ranges::fill(image.add(bands[b].name() + ".radiance"), static_cast<float>(radiance[b]));
  }
  std::ranges::fill(image.add("rays.N"), 1.0f);
  return image;
}

Moments moments(std::span<const float> values) {
  Moments result;
  for (const float value : values) result.add(static_cast<double>(value));
  return result;
}

bool same_bits(std::span<const float> a, std::span<const float> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

// Standard deviation of a gaussian sample against its law.
test::Agreement deviation(std::span<const float> values, double expected, double comparisons = 1) {
  const double sd = std::sqrt(moments(values).variance());
  return agree(sd, expected / std::sqrt(2.0 * static_cast<double>(values.size())), expected,
               {.resolution = 0.01, .reference_error = 0, .comparisons = comparisons});
}

// Correlation of two series of zero mean, in its own standard errors.
double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += a[i] * b[i];
    aa += a[i] * a[i];
    bb += b[i] * b[i];
  }
  return ab / std::sqrt(aa * bb) * std::sqrt(static_cast<double>(a.size()));
}

std::vector<double> noise_of(const Image& image, const std::string& band) {
  const auto seen = image.channel(band + ".detector");
  const auto true_ones = image.channel(band + ".radiance");
  std::vector<double> noise;
  for (std::size_t i = 0; i < seen.size(); ++i)
    noise.push_back(static_cast<double>(seen[i]) - static_cast<double>(true_ones[i]));
  return noise;
}

}  // namespace

TEST_CASE("a detector that is not asked for adds nothing", "[sensor][detector]") {
  const std::vector<Band> bands{lwir()};
  Image image = uniform(bands, 4, 3, {40});
  const auto channels = image.channels();
  CHECK_FALSE(DetectorSettings{}.on());
  CHECK(detect(image, bands, {}, {}).empty());
  CHECK(image.channels() == channels);
  CHECK(image.metadata.empty());
}

TEST_CASE("the clean channels stay as they are, and the settings are told", "[sensor][detector]") {
  const std::vector<Band> bands{lwir(), Band("grey")};
  Image image = uniform(bands, 16, 9, {40, 2});
  const Image before = image;
  DetectorSettings settings;
  settings.psf_sigma_px = 1;
  settings.ner = 0.1;
  settings.bits = 8;
  settings.range = {0, 80};
  settings.dead_share = 0.1;
  settings.gain_nonuniformity = 0.1;
  settings.offset_nonuniformity = 0.1;
  detect(image, bands, settings, {});
  for (const std::string& name : before.channels()) CHECK(same_bits(image.channel(name), before.channel(name)));
  for (const char* name :
       {"lwir.detector", "lwir.counts", "lwir.detector_temperature", "grey.detector", "grey.counts"}) {
    CHECK(image.has(name));
  }
  CHECK_FALSE(image.has("grey.detector_temperature"));
  const auto text = std::get<std::string>(image.metadata.at("obscura:detector.lwir.settings"));
  for (const char* part : {"\"psf_sigma_px\": 1", "\"ner\": 0.1", "\"bits\": 8", "\"range\": [0, 80]", "\"seed\": 1"}) {
    INFO(text);
    CHECK(text.find(part) != std::string::npos);
  }
  CHECK(std::get<double>(image.metadata.at("obscura:detector.grey.noise_radiance")) == 0.1);
}

TEST_CASE("without a stage the signal is the radiance to the bit", "[sensor][detector]") {
  const std::vector<Band> bands{lwir()};
  Image image = uniform(bands, 8, 8, {41.23456789});
  DetectorSettings settings;
  settings.bits = 1;
  detect(image, bands, settings, {});
  CHECK(same_bits(image.channel("lwir.detector"), image.channel("lwir.radiance")));
}

TEST_CASE("noise of 0.05 K scatters the temperature of a scene at 300 K by 0.05 K", "[sensor][detector][noise]") {
  const std::vector<Band> bands{lwir()};
  const double radiance = bands[0].planck(300);
  DetectorSettings settings;
  settings.nedt_K = 0.05;
  const auto seen = [&](double at_K) {
    Image image = uniform(bands, 640, 640, {radiance});
    settings.nedt_at_K = at_K;
    detect(image, bands, settings, {});
    return image;
  };
  const Image image = seen(300);
  CHECK(deviation(image.channel("lwir.detector_temperature"), 0.05));
  const Moments kelvin = moments(image.channel("lwir.detector_temperature"));
  CHECK(std::abs(kelvin.mean() - 300) < 4.9 * 0.05 / 640 + 2e-5);
  // Noise stated for another scene is another noise: dB/dT at 310 K is 7 % more.
  CHECK_FALSE(deviation(seen(310).channel("lwir.detector_temperature"), 0.05));
}

TEST_CASE("noise-equivalent temperature is weighed with the response", "[sensor][detector][noise]") {
  const Band band("b", 8, 12, 3, Spectrum::table({8, 10, 12}, {0, 1, 0}));
  DetectorSettings settings;
  settings.nedt_K = 0.2;
  settings.nedt_at_K = 320;
  // Midpoints, and a difference in place of the derivative.
  double slope = 0;
  constexpr int steps = 4000;
  for (int i = 0; i < steps; ++i) {
    const double um = 8 + 4 * (i + 0.5) / steps;
    slope += band.response()(um) * (planck_spectral(um, 320.05) - planck_spectral(um, 319.95)) / 0.1 * 4 / steps;
  }
  CHECK(noise_radiance(settings, band) == Approx(0.2 * slope).epsilon(1e-5));
  CHECK_FALSE(noise_radiance(settings, lwir()) == Approx(0.2 * slope).epsilon(1e-2));
  settings.integration_s = 0.004;
  settings.reference_integration_s = 0.001;
  CHECK(noise_radiance(settings, band) == Approx(0.1 * slope).epsilon(1e-5));
  CHECK_THROWS_AS(noise_radiance(settings, Band("grey")), InputError);
  settings.nedt_K = 0;
  settings.ner = 3;
  CHECK(noise_radiance(settings, Band("grey")) == 1.5);
}

TEST_CASE("noise is gaussian, white, and its own in each band and picture", "[sensor][detector][noise]") {
  const std::vector<Band> bands{Band("a"), Band("b")};
  DetectorSettings settings;
  settings.ner = 1;
  const auto seen = [&](const DetectorFrame& frame) {
    Image image = uniform(bands, 512, 400, {0, 0});
    detect(image, bands, settings, frame);
    return image;
  };
  const Image image = seen({});
  const std::vector<double> a = noise_of(image, "a"), b = noise_of(image, "b");
  const auto gaussian = [&](double sigma) {
    std::vector<double> edges{-100}, observed, expected;
    for (double edge = -4; edge <= 4; edge += 0.25) edges.push_back(edge);
    edges.push_back(100);
    for (std::size_t i = 1; i < edges.size(); ++i) {
      observed.push_back(
          static_cast<double>(std::ranges::count_if(a, [&](double v) { return v >= edges[i - 1] && v < edges[i]; })));
      const auto below = [&](double x) { return 0.5 * std::erfc(-x / (sigma * std::sqrt(2.0))); };
      expected.push_back(static_cast<double>(a.size()) * (below(edges[i]) - below(edges[i - 1])));
    }
    return chi_square(observed, expected);
  };
  CHECK(gaussian(1));
  CHECK_FALSE(gaussian(1.02));

  const auto shifted = [](std::vector<double> values, std::ptrdiff_t by) {
    std::ranges::rotate(values, values.begin() + by);
    return values;
  };
  constexpr double limit = 5.3;  // 1e-7 two-sided, seven times
  for (const std::ptrdiff_t lag : {1, 2, 512, 513}) {
    INFO(lag);
    CHECK(std::abs(correlation(a, shifted(a, lag))) < limit);
  }
  CHECK(std::abs(correlation(a, b)) < limit);
  CHECK(std::abs(correlation(a, noise_of(seen({.seed = 2, .time_s = 0}), "a"))) < limit);
  CHECK(std::abs(correlation(a, noise_of(seen({.seed = 1, .time_s = 0.04}), "a"))) < limit);
  // A tenth of a neighbour's noise is seen, and the same frame has the same noise.
  std::vector<double> mixed = shifted(a, 1);
  for (std::size_t i = 0; i < a.size(); ++i) mixed[i] = mixed[i] + 0.1 * a[i];
  CHECK(std::abs(correlation(a, mixed)) > limit);
  CHECK(noise_of(seen({}), "a") == a);
}

TEST_CASE("dead pixels are as many as chance has it, and belong to the device", "[sensor][detector][pattern]") {
  const std::vector<Band> bands{Band("a"), Band("b")};
  constexpr int side = 32, pixels = side * side, devices = 1500;
  DetectorSettings settings;
  settings.dead_share = 0.003;
  const auto law = [&](double share) {
    std::vector<double> observed(12), expected(12);
    for (int device = 0; device < devices; ++device) {
      settings.seed = static_cast<std::uint64_t>(device);
      Image image = uniform(bands, side, side, {5, 5});
      for (const DetectorTally& tally : detect(image, bands, settings, {})) {
        const auto signal = image.channel(tally.band + ".detector");
        REQUIRE(static_cast<std::uint64_t>(std::ranges::count(signal, 0.0f)) == tally.dead);
        observed[std::min<std::size_t>(tally.dead, 11)] += 1;
      }
    }
    double left = 2 * devices, chance = std::pow(1 - share, pixels);
    for (int k = 0; k < 11; ++k) {
      expected[static_cast<std::size_t>(k)] = 2 * devices * chance;
      left -= 2 * devices * chance;
      chance *= (pixels - k) / (k + 1.0) * share / (1 - share);
    }
    expected[11] = left;
    return chi_square(observed, expected);
  };
  CHECK(law(0.003));
  CHECK_FALSE(law(0.0033));

  const auto dead_at = [&](std::uint64_t device, const DetectorFrame& frame) {
    settings.seed = device;
    settings.dead_share = 0.2;
    Image image = uniform(bands, side, side, {5, 5});
    detect(image, bands, settings, frame);
    std::vector<bool> dead;
    for (const float value : image.channel("a.detector")) dead.push_back(value == 0);
    for (const float value : image.channel("b.detector")) dead.push_back(value == 0);
    return dead;
  };
  CHECK(dead_at(7, {.seed = 1, .time_s = 0}) == dead_at(7, {.seed = 2, .time_s = 3}));
  CHECK(dead_at(7, {}) != dead_at(8, {}));
  const auto dead = dead_at(7, {});
  CHECK_FALSE(std::equal(dead.begin(), dead.begin() + pixels, dead.begin() + pixels));
}

TEST_CASE("pixels differ in gain and offset as stated, in all pictures alike", "[sensor][detector][pattern]") {
  const std::vector<Band> bands{Band("a"), Band("b")};
  DetectorSettings settings;
  settings.seed = 3;
  const auto seen = [&](const DetectorFrame& frame) {
    Image image = uniform(bands, 640, 640, {50, 0});
    detect(image, bands, settings, frame);
    return image;
  };
  settings.gain_nonuniformity = 0.02;
  const Image gain = seen({});
  CHECK(deviation(gain.channel("a.detector"), 0.02 * 50, 3));
  CHECK_FALSE(deviation(gain.channel("a.detector"), 0.0205 * 50, 3));
  CHECK(moments(gain.channel("b.detector")).variance() == 0);  // nothing to amplify
  settings.gain_nonuniformity = 0;
  settings.offset_nonuniformity = 0.3;
  const Image offset = seen({});
  CHECK(deviation(offset.channel("a.detector"), 0.3, 3));
  CHECK(deviation(offset.channel("b.detector"), 0.3, 3));
  CHECK(same_bits(offset.channel("a.detector"), seen({.seed = 9, .time_s = 1}).channel("a.detector")));
  settings.seed.reset();
  CHECK_FALSE(same_bits(offset.channel("a.detector"), seen({.seed = 9, .time_s = 1}).channel("a.detector")));
}

TEST_CASE("counts rise with the signal and end at both ends of the range", "[sensor][detector][counts]") {
  const std::vector<Band> bands{Band("g")};
  const auto counts_of = [&](const DetectorSettings& settings, DetectorTally* tally = nullptr) {
    Image image(1201, 1);
    const auto radiance = image.add("g.radiance");
    for (std::size_t i = 0; i < radiance.size(); ++i) radiance[i] = static_cast<float>(i) / 1000 - 0.1f;
    const auto tallies = detect(image, bands, settings, {});
    if (tally) *tally = tallies[0];
    const auto counts = image.channel("g.counts");
    return std::vector<float>(counts.begin(), counts.end());
  };
  for (const int bits : {1, 8, 12, 16}) {
    INFO(bits);
    DetectorSettings settings;
    settings.bits = bits;
    DetectorTally tally;
    const auto counts = counts_of(settings, &tally);
    const double top = std::pow(2, bits) - 1;
    int wrong = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const double signal = static_cast<double>(static_cast<float>(i) / 1000 - 0.1f);
      wrong += static_cast<double>(counts[i]) != std::clamp(std::round(signal * top), 0.0, top);
    }
    CHECK(wrong == 0);
    CHECK(std::ranges::is_sorted(counts));
    CHECK(counts.front() == 0);
    CHECK(static_cast<double>(counts.back()) == top);
    CHECK(tally.below == 100);
    CHECK(tally.above == 100);
    CHECK(tally.dead == 0);
  }
  DetectorSettings settings;
  settings.bits = 10;
  settings.range = {1, 3};
  settings.gain = 2;
  settings.offset = 1;  // the same as [0, 1] without them
  DetectorSettings plain;
  plain.bits = 10;
  const auto a = counts_of(settings), b = counts_of(plain);
  int off = 0;
  for (std::size_t i = 0; i < a.size(); ++i) off += std::abs(a[i] - b[i]) > 0;
  CHECK(off <= 1);  // rounding may decide a half otherwise
  settings.gain = 1.9;
  CHECK(counts_of(settings) != b);
}

TEST_CASE("a dead pixel is told as dead, not as cut by the range", "[sensor][detector][counts]") {
  const std::vector<Band> bands{Band("g")};
  DetectorSettings settings;
  settings.bits = 8;
  settings.range = {1, 3};
  settings.dead_share = 0.25;
  Image image = uniform(bands, 40, 40, {2});
  const DetectorTally tally = detect(image, bands, settings, {})[0];
  CHECK(tally.dead > 0);
  CHECK(tally.below == 0);
  CHECK(static_cast<std::uint64_t>(std::ranges::count(image.channel("g.counts"), 0.0f)) == tally.dead);
  settings.range = {2.5, 3};  // what lives is cut as well
  image = uniform(bands, 40, 40, {2});
  CHECK(detect(image, bands, settings, {})[0].below == 1600 - tally.dead);
}

TEST_CASE("a band's own settings replace those of all, and what they exclude", "[sensor][detector]") {
  DetectorSettings all;
  all.nedt_K = 0.1;
  all.psf = PointSpread{1, 1, {1}};
  all.range = {0, 9};
  all.gain = 2;
  all.bands["b"].ner = 3;
  all.bands["b"].psf_sigma_px = 1.5;
  all.bands["b"].range = std::array<double, 2>{1, 2};
  const DetectorSettings a = all.of_band("a"), b = all.of_band("b");
  CHECK(a.nedt_K == 0.1);
  CHECK(a.range == std::array<double, 2>{0, 9});
  CHECK(a.bands.empty());
  CHECK_FALSE(a.psf.empty());
  CHECK(b.nedt_K == 0);
  CHECK(b.ner == 3);
  CHECK(b.psf.empty());
  CHECK(b.psf_sigma_px == 1.5);
  CHECK(b.range == std::array<double, 2>{1, 2});
  CHECK(b.gain == 2);
  CHECK(noise_radiance(all, Band("b")) == 3);
}

TEST_CASE("gain and offset change the signal but not the temperature that it means", "[sensor][detector]") {
  const std::vector<Band> bands{lwir()};
  Image image = uniform(bands, 4, 4, {lwir().planck(310)});
  DetectorSettings settings;
  settings.gain = 3;
  settings.offset = -5;
  detect(image, bands, settings, {});
  CHECK(image.channel("lwir.detector")[5] == Approx(3 * lwir().planck(310) - 5).epsilon(1e-6));
  CHECK(image.channel("lwir.detector_temperature")[5] == Approx(310).epsilon(1e-6));
}

TEST_CASE("pixels never done stay black and lend no light", "[sensor][detector][psf]") {
  const std::vector<Band> bands{lwir()};
  Image image(12, 6);
  const auto radiance = image.add("lwir.radiance");
  const auto rays = image.add("rays.N");
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    rays[i] = i % 12 < 7 ? 4 : 0;
    radiance[i] = rays[i] > 0 ? 30 : 0;
  }
  DetectorSettings settings;
  settings.psf_sigma_px = 2;
  settings.bits = 8;
  settings.range = {20, 45};
  const auto tally = detect(image, bands, settings, {});
  CHECK(tally[0].below == 0);
  int wrong = 0;
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    wrong += std::abs(image.channel("lwir.detector")[i] - image.channel("lwir.radiance")[i]) > 1e-5f;
    wrong += image.channel("lwir.counts")[i] != (image.channel("rays.N")[i] > 0 ? 102.0f : 0.0f);
    wrong += (image.channel("lwir.detector_temperature")[i] > 0) != (image.channel("rays.N")[i] > 0);
  }
  CHECK(wrong == 0);
}

TEST_CASE("the detector has the same bits on any number of threads", "[sensor][detector]") {
  const std::vector<Band> bands{lwir(), Band("mwir", 3, 5)};
  DetectorSettings settings;
  settings.psf_sigma_px = 1.5;
  settings.nedt_K = 0.1;
  settings.dead_share = 0.01;
  settings.gain_nonuniformity = 0.01;
  settings.bits = 14;
  settings.range = {0, 40};
  const auto seen = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Image image = uniform(bands, 150, 131, {30, 2});
    const auto tallies = detect(image, bands, settings, {});
    return std::pair(std::move(image), tallies[0].dead);
  };
  const auto one = seen(1), four = seen(4);
  CHECK(one.second == four.second);
  CHECK(one.first.metadata == four.first.metadata);
  for (const std::string& name : one.first.channels())
    CHECK(same_bits(one.first.channel(name), four.first.channel(name)));
}

TEST_CASE("no radiance and no setting makes a value that is not finite", "[sensor][detector]") {
  const std::vector<Band> bands{lwir()};
  Image image(3, 3);
  const float most = std::numeric_limits<float>::max();
  std::ranges::copy(std::vector<float>{0, -1, most, -most, 1e-45f, 40, 1e30f, 0, 1},
                    image.add("lwir.radiance").begin());
  DetectorSettings settings;
  settings.psf_sigma_px = 1000;
  settings.nedt_K = 1e4;
  settings.nedt_at_K = 1e4;
  settings.integration_s = 1e-9;
  settings.reference_integration_s = 1e9;
  settings.gain_nonuniformity = 1;
  settings.offset_nonuniformity = 1e30;
  settings.gain = 1e30;
  settings.offset = -1e30;
  settings.bits = 16;
  detect(image, bands, settings, {});
  for (const std::string& name : image.channels()) {
    INFO(name);
    CHECK(std::ranges::all_of(image.channel(name), [](float v) { return std::isfinite(v); }));
  }
  CHECK(std::ranges::all_of(image.channel("lwir.counts"), [](float v) { return v >= 0 && v <= 65535; }));
}

TEST_CASE("the detector's channels come back from their file", "[sensor][detector][image_io]") {
  const test::ScratchFolder folder;
  const std::vector<Band> bands{lwir()};
  Image image = uniform(bands, 33, 21, {40});
  DetectorSettings settings;
  settings.nedt_K = 0.5;
  settings.bits = 16;
  settings.range = {38, 42};
  detect(image, bands, settings, {});
  write_image(folder / "a.exr", image);
  const Image back = read_image(folder / "a.exr");
  for (const std::string& name : image.channels()) CHECK(same_bits(image.channel(name), back.channel(name)));
  CHECK(back.metadata.at("obscura:detector.lwir.settings") == image.metadata.at("obscura:detector.lwir.settings"));

  // And the counts from 16-bit pictures, as the values that they are.
  for (const char* name : {"c.png", "c.tif"}) {
    INFO(name);
    write_counts(folder / name, image, "lwir.counts");
    const Image counts = read_image(folder / name);
    REQUIRE(counts.channels().size() == 1);
    const auto read = counts.channel(counts.channels()[0]);
    std::vector<float> values;
    for (const float value : read) values.push_back(std::round(value * 65535));
    CHECK(same_bits(values, image.channel("lwir.counts")));
    CHECK(moments(values).variance() > 1e4);
  }
  CHECK(folder.file_count() == 3);
  CHECK_THROWS_AS(write_counts(folder / "d.png", image, "mwir.counts"), InputError);
}
