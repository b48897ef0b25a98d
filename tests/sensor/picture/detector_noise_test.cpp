// The detector's noise and pattern: normal, white, its own in each band and picture, and as much as is asked for.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "sensor/picture/detector.h"
#include "tests/sensor/picture/uniform_images.h"
#include "tests/support/agree.h"
#include "tests/support/chi_square.h"

using namespace obscura;
using obscura::test::agree;
using obscura::test::chi_square;
using obscura::test::lwir;
using obscura::test::moments;
using obscura::test::same_bits;
using obscura::test::uniform;

namespace {

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
