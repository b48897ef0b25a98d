// The detector: each stage alone does what it says, together in their order, and nothing else changes.
#include "sensor/picture/detector.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "sensor/picture/image_io.h"
#include "tests/sensor/picture/uniform_images.h"
#include "tests/support/scratch_folder.h"

using namespace obscura;
using obscura::test::lwir;
using obscura::test::moments;
using obscura::test::same_bits;
using obscura::test::uniform;

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
