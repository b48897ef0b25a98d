// Masks, contrasts, shares and intervals from lines of sight whose answer is known on paper.
#include "sensor/sight/obscuration.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "octree/base/math.h"
#include "octree/base/random.h"

using namespace obscura;

namespace {

ObjectMask square(int columns, int rows, int x0, int y0, int side, int width = 0) {
  std::vector<float> share(static_cast<std::size_t>(columns * rows));
  for (int y = y0; y < y0 + side; ++y) {
    for (int x = x0; x < x0 + side; ++x) share[static_cast<std::size_t>(y * columns + x)] = 1;
  }
  return mask_of(columns, rows, std::move(share), width);
}

/// Ten pixels with radiances 1, 2 ... 10 and as many lines each, before 4; the cloud makes of L: T L + glow.
constexpr int kPixels = 10;
constexpr double kSurround = 4;
struct Haze {
  double transmission = 0.5, glow = 3;
};

Look clear_look() {
  Look look;
  for (int p = 0; p < kPixels; ++p) {
    look.lines.push_back(4);
    look.radiance.push_back(4.0 * (p + 1));
  }
  look.surround_lines = 100;
  look.surround_radiance = 100 * kSurround;
  return look;
}

Look hazy(const Look& look, const Haze& haze) {
  Look result = look;
  for (std::size_t p = 0; p < result.lines.size(); ++p) {
    result.radiance[p] = haze.transmission * look.radiance[p] + haze.glow * look.lines[p];
  }
  result.surround_radiance = haze.transmission * look.surround_radiance + haze.glow * look.surround_lines;
  return result;
}

std::vector<SightReplica> exact_replicas(const Haze& haze = {}, int count = 4) {
  SightReplica replica;
  for (int k = 0; k <= 100; ++k) replica.transmission.push_back(0.01f * static_cast<float>(k));
  replica.without = clear_look();
  replica.with = hazy(replica.without, haze);
  return std::vector<SightReplica>(static_cast<std::size_t>(count), replica);
}

double normal(Stream& stream) {
  return std::sqrt(-2 * std::log(stream.uniform())) * std::cos(2 * kPi * stream.uniform());
}

bool holds(const std::optional<Confident>& c, double truth) { return c && c->low <= truth && truth <= c->high; }

}  // namespace

TEST_CASE("the surroundings are a window around the object without any of it", "[sensor][obscuration]") {
  const ObjectMask mask = square(30, 20, 10, 8, 4);
  CHECK(mask.area() == 16);
  CHECK(mask.interior() == 16);
  CHECK(mask.width == 2);
  CHECK(mask.ring_size() == 8 * 8 - 16);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 30; ++x) {
      const auto i = static_cast<std::size_t>(y * 30 + x);
      const bool window = x >= 8 && x < 16 && y >= 6 && y < 14;
      REQUIRE((mask.ring[i] != 0) == (window && !(mask.share[i] > 0)));
    }
  }
  CHECK_FALSE(mask.at_border());
  CHECK(square(30, 20, 26, 8, 4).at_border());
  CHECK(square(30, 20, 10, 16, 4).at_border());
  CHECK(square(30, 20, 10, 8, 4, 5).ring_size() == 14 * 14 - 16);
  CHECK(square(80, 80, 30, 30, 20).width == 10);
  CHECK(square(30, 20, 0, 0, 4).ring_size() == 6 * 6 - 16);
}

TEST_CASE("pixels that show little of the object are in its area and not in its surroundings",
          "[sensor][obscuration]") {
  std::vector<float> share(100);
  share[55] = 0.25f;
  share[56] = 1;
  const ObjectMask mask = mask_of(10, 10, share, 1);
  CHECK(mask.area() == Approx(1.25));
  CHECK(mask.interior() == 1);
  CHECK(mask.ring_size() == 4 * 3 - 2);
  CHECK_FALSE(mask.ring[55]);
}

TEST_CASE("known radiances have their contrasts, ratios and shares", "[sensor][obscuration]") {
  ObscurationSettings settings;
  settings.contrast = 0.5;
  const BandObscuration found = find_obscuration(Band("grey"), exact_replicas(), settings);
  // Object 5.5 before 4; through the cloud 5.75 before 5.
  CHECK(found.without.difference->value == Approx(1.5));
  CHECK(found.without.relative->value == Approx(0.375));
  CHECK(found.with.object->value == Approx(5.75));
  CHECK(found.with.surroundings->value == Approx(5));
  CHECK(found.with.difference->value == Approx(0.75));
  CHECK(found.difference_ratio->value == Approx(0.5));
  // Duntley: the relative contrast shrinks by T L_s / L_s'.
  CHECK(found.relative_ratio->value == Approx(0.5 * 4 / 5));
  // Without: radiances in (2, 6) are lost: 3, 4, 5. With: L/2 + 3 in (2.5, 7.5): below 9.
  CHECK(found.without.lost_contrast->value == Approx(0.3));
  CHECK(found.with.lost_contrast->value == Approx(0.8));
  // Nothing scatters, nothing is open.
  CHECK(found.with.difference->high - found.with.difference->low < 1e-9);
  CHECK_FALSE(found.with.object_K.has_value());
  CHECK_FALSE(found.with.lost_K.has_value());

  CHECK(found.transmission->value == Approx(0.5));
  CHECK(found.transmission_min == 0);
  CHECK(found.transmission_max == 1);
  CHECK(found.obscured->value == Approx(11.0 / 101));
  REQUIRE(found.percentiles.size() == 5);
  for (const auto& [per_cent, value] : found.percentiles) CHECK(value.value == Approx(per_cent / 100));
}

TEST_CASE("temperatures are those of the mean radiances, and shares in kelvin have bounds in kelvin",
          "[sensor][obscuration]") {
  const Band band("lwir", 8, 12);
  SightReplica replica;
  replica.transmission = {0.5f};
  for (int p = 0; p < kPixels; ++p) {
    replica.without.lines.push_back(1);
    replica.without.radiance.push_back(band.planck(290.0 + 2 * p));  // 290 ... 308 K before 299 K
  }
  replica.without.surround_lines = 1;
  replica.without.surround_radiance = band.planck(299.0);
  replica.with = hazy(replica.without, {0.5, 0.5 * band.planck(280.0)});
  ObscurationSettings settings;
  settings.difference_K = 4;
  const BandObscuration found = find_obscuration(band, std::vector<SightReplica>(3, replica), settings);
  CHECK(found.without.surroundings_K->value == Approx(299));
  CHECK(found.without.object_K->value == Approx(299).margin(0.3));
  CHECK(found.without.lost_K->value == Approx(0.4));  // 296, 298, 300, 302
  const double surround = band.brightness_temperature(0.5 * band.planck(299.0) + 0.5 * band.planck(280.0));
  int lost = 0;
  for (int p = 0; p < kPixels; ++p) {
    const double K = band.brightness_temperature(0.5 * band.planck(290.0 + 2 * p) + 0.5 * band.planck(280.0));
    lost += std::abs(K - surround) < 4 ? 1 : 0;
  }
  CHECK(lost > 4);
  CHECK(found.with.lost_K->value == Approx(lost / 10.0));
  CHECK(found.with.surroundings_K->value == Approx(surround));
}

TEST_CASE("an object as bright as its surroundings has no ratio, and says so", "[sensor][obscuration]") {
  std::vector<SightReplica> replicas = exact_replicas();
  for (SightReplica& replica : replicas) replica.without.surround_radiance = replica.without.surround_lines * 5.5;
  const BandObscuration found = find_obscuration(Band("grey"), replicas, {});
  CHECK_FALSE(found.difference_ratio.has_value());
  CHECK_FALSE(found.relative_ratio.has_value());
  REQUIRE(found.notes.size() == 1);
  CHECK(found.notes.front().find("does not stand out") != std::string::npos);
  // Against darkness there is a difference but no relative contrast.
  for (SightReplica& replica : replicas) replica.without.surround_radiance = 0;
  const BandObscuration dark = find_obscuration(Band("grey"), replicas, {});
  CHECK(dark.difference_ratio.has_value());
  CHECK_FALSE(dark.without.relative.has_value());
  CHECK_FALSE(dark.relative_ratio.has_value());
}

TEST_CASE("noise and bias that no interval holds are told", "[sensor][obscuration]") {
  std::vector<SightReplica> replicas = exact_replicas();
  CHECK(find_obscuration(Band("grey"), replicas, {}).notes.empty());
  for (std::size_t r = 0; r < replicas.size(); ++r) {
    replicas[r].with.bias = 40 * 0.5;
    replicas[r].with.surround_bias = 100 * 0.1;
    for (double& radiance : replicas[r].without.radiance) radiance += (r % 2 ? 4 : -4) * 0.2;
  }
  const BandObscuration found = find_obscuration(Band("grey"), replicas, {});
  CHECK(found.with.difference_bias == Approx(0.4));
  CHECK(found.without.pixel_error == Approx(0.2 * std::sqrt(4.0 / 3) / 2));
  REQUIRE(found.notes.size() == 2);
  CHECK(found.notes[0].find("with the cloud, the photon map's own bias may be +0.4") == 0);
  CHECK(found.notes[1].find("without the cloud, a pixel's own noise") == 0);
}

TEST_CASE("a share that every line agrees on keeps room for lines that were not sent", "[sensor][obscuration]") {
  std::vector<SightReplica> replicas = exact_replicas();
  for (SightReplica& replica : replicas) replica.transmission.assign(250, 0.7f);
  const BandObscuration found = find_obscuration(Band("grey"), replicas, {});
  CHECK(found.obscured->value == 0);
  CHECK(found.obscured->low == 0);
  CHECK(found.obscured->high == Approx(3.0 / 1000).epsilon(0.01));  // the rule of three
  for (SightReplica& replica : replicas) replica.transmission.assign(250, 0.05f);
  const BandObscuration all = find_obscuration(Band("grey"), replicas, {});
  CHECK(all.obscured->value == 1);
  CHECK(all.obscured->low == Approx(1 - 3.0 / 1000).epsilon(0.01));
}

TEST_CASE("intervals hold the truth in 95 of 100 cases where replicas share their noise among pixels",
          "[sensor][obscuration]") {
  // A map's noise moves all pixels of a replica together; the ratio is that of noisy numbers.
  constexpr int kTrials = 1200, kReplicas = 8;
  const Haze haze{0.3, 2};
  const double truth = 0.3 * 1.5;
  struct Count {
    int difference = 0, ratio = 0, relative = 0, transmission = 0, obscured = 0, naive = 0;
  } in;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<SightReplica> replicas = exact_replicas(haze, kReplicas);
    double naive_sum = 0, naive_sum2 = 0;
    int naive_count = 0;
    for (int r = 0; r < kReplicas; ++r) {
      SightReplica& replica = replicas[static_cast<std::size_t>(r)];
      Stream stream(17, static_cast<std::uint64_t>(trial * kReplicas + r), 1);
      const double map = 0.15 * normal(stream), around = 0.1 * normal(stream);
      for (std::size_t p = 0; p < kPixels; ++p) {
        replica.without.radiance[p] += 4 * 0.3 * normal(stream);
        replica.with.radiance[p] += 4 * (map + 0.1 * normal(stream));
        const double value = replica.with.radiance[p] / 4 - 0.3 * static_cast<double>(p + 1);
        naive_sum += value, naive_sum2 += value * value, ++naive_count;
      }
      replica.without.surround_radiance += 100 * 0.05 * normal(stream);
      replica.with.surround_radiance += 100 * around;
      for (float& t : replica.transmission) t = static_cast<float>(stream.uniform());
    }
    const BandObscuration found = find_obscuration(Band("grey"), replicas, {});
    in.difference += holds(found.with.difference, truth) ? 1 : 0;
    in.ratio += holds(found.difference_ratio, 0.3) ? 1 : 0;
    in.relative += holds(found.with.relative, truth / 3.2) ? 1 : 0;
    in.transmission += holds(found.transmission, 0.5) ? 1 : 0;
    in.obscured += holds(found.obscured, 0.1) ? 1 : 0;
    // What one would get from pixels taken for independent.
    const double mean = naive_sum / naive_count,
                 error = std::sqrt((naive_sum2 / naive_count - mean * mean) / naive_count);
    in.naive += std::abs(mean - haze.glow) < 1.96 * error ? 1 : 0;
  }
  const auto share = [](int count) { return static_cast<double>(count) / kTrials; };
  for (const int count : {in.difference, in.ratio, in.relative, in.transmission, in.obscured}) {
    CHECK(share(count) >= 0.92);
    CHECK(share(count) <= 0.98);
  }
  CHECK(share(in.naive) < 0.85);
}
