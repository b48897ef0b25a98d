// Pictures with a known bias and a known noise.
#include "sensor/judge/picture_error.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "octree/base/random.h"
#include "octree/base/statistics.h"

using namespace obscura;

namespace {

constexpr int kColumns = 24, kRows = 16;

double truth(int p) { return 1 + 0.5 * std::sin(0.3 * p); }

double normal(Stream& random) {
  double sum = -6;
  for (int k = 0; k < 12; ++k) sum += random.uniform();
  return sum;
}

/// @param bias of every second pixel, relative
Picture picture(double bias, double noise, std::uint64_t seed, std::size_t bands = 1) {
  Picture result{kColumns, kRows, {}};
  Stream random(7, seed, 0);
  for (std::size_t b = 0; b < bands; ++b) {
    std::vector<float>& band = result.bands.emplace_back();
    for (int p = 0; p < kColumns * kRows; ++p)
      band.push_back(static_cast<float>(truth(p) * (1 + (p % 2 ? bias : -bias) + noise * normal(random))));
  }
  return result;
}

ReferencePicture reference(int passes, double noise) {
  ReferencePicture result;
  for (int k = 0; k < passes; ++k) result.add(picture(0, noise, 1000 + static_cast<std::uint64_t>(k)));
  return result;
}

}  // namespace

TEST_CASE("bias and noise of two pictures come apart, and the reference's own error is taken off", "[picture_error]") {
  // A reference that is worse than what is measured against it.
  Moments error2, bias2, noise2, claimed_error2, claimed_bias2;
  for (std::uint64_t trial = 0; trial < 200; ++trial) {
    ReferencePicture ref;
    for (std::uint64_t k = 0; k < 4; ++k) ref.add(picture(0, 0.1, 100000 + 10 * trial + k));
    const std::array<Picture, 2> pair{picture(0.02, 0.03, 2 * trial), picture(0.02, 0.03, 2 * trial + 1)};
    const PictureError found = picture_error(pair, ref);
    error2.add(found.error.square);
    bias2.add(found.bias.square);
    noise2.add(found.noise.square);
    claimed_error2.add(found.error.square_error * found.error.square_error);
    claimed_bias2.add(found.bias.square_error * found.bias.square_error);
  }
  // The reference's noise is in the weights too: a relative change of 3 x 0.05^2 in their mean.
  CHECK(std::abs(error2.mean() - 1.3e-3) < 5 * error2.standard_error() + 2e-5);
  CHECK(std::abs(bias2.mean() - 4e-4) < 5 * bias2.standard_error() + 2e-5);
  CHECK(std::abs(noise2.mean() - 9e-4) < 5 * noise2.standard_error() + 2e-5);
  CHECK(std::abs(bias2.mean() - 4e-4) < 2e-4);
  // The jackknife's errors are the scatter.
  CHECK(claimed_error2.mean() == Approx(error2.variance()).epsilon(0.35));
  CHECK(claimed_bias2.mean() == Approx(bias2.variance()).epsilon(0.35));
}

TEST_CASE("error is bias and noise together", "[picture_error]") {
  const std::array<Picture, 3> pictures{picture(0.05, 0.02, 1), picture(0.05, 0.02, 2), picture(0.05, 0.02, 3)};
  const PictureError found = picture_error(pictures, reference(8, 0.01));
  CHECK(found.error.square == Approx(found.bias.square + found.noise.square));
  CHECK(found.bias.value() == Approx(0.05).margin(4 * found.bias.error()));
  CHECK(found.noise.value() == Approx(0.02).margin(4 * found.noise.error()));
}

TEST_CASE("the worst band counts", "[picture_error]") {
  ReferencePicture ref;
  for (std::uint64_t k = 0; k < 2; ++k) ref.add(picture(0, 0.001, 50 + k, 2));
  std::array<Picture, 2> pair{picture(0, 0.01, 1, 2), picture(0, 0.01, 2, 2)};
  for (Picture& one : pair) {
    for (float& value : one.bands[1]) value *= 1.2f;
  }
  const PictureError found = picture_error(pair, ref);
  CHECK(found.band == 1);
  CHECK(found.error.value() == Approx(0.2).epsilon(0.02));
}

TEST_CASE("a reference knows its error from its passes, or states it", "[picture_error]") {
  ReferencePicture ref;
  CHECK_FALSE(ref.known());
  ref.add(picture(0, 0.1, 1));
  CHECK_FALSE(ref.known());
  ref.add(picture(0, 0.1, 2));
  CHECK(ref.known());
  for (std::uint64_t k = 3; k <= 16; ++k) ref.add(picture(0, 0.1, k));
  CHECK(reference_error(ref).value() == Approx(0.1 / 4).epsilon(0.1));

  Picture errors = picture(0, 0, 1);
  for (float& e : errors.bands[0]) e = 0.03f;
  Picture values = errors;
  for (float& v : values.bands[0]) v = 2;
  const ReferencePicture stated(values, errors);
  CHECK(stated.known());
  CHECK(reference_error(stated).value() == Approx(0.015));
}

TEST_CASE("dark pixels count by a twentieth of the largest", "[picture_error]") {
  Picture values{2, 1, {{100, 0}}}, none{2, 1, {{0, 0}}};
  const ReferencePicture ref(values, none);
  const std::array<Picture, 2> pair{Picture{2, 1, {{100, 1}}}, Picture{2, 1, {{100, 1}}}};
  CHECK(picture_error(pair, ref).error.value() == Approx(0.2 / std::sqrt(2)));
}
