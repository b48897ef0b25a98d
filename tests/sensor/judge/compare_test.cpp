// The comparison of images against differences that are known.
#include "sensor/judge/compare.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "octree/base/random.h"

using namespace obscura;

namespace {

Image make(const std::string& name, std::vector<float> values) {
  Image image(static_cast<int>(values.size()), 1);
  std::ranges::copy(values, image.add(name).begin());
  return image;
}

void add(Image& image, const std::string& name, const std::vector<float>& values) {
  std::ranges::copy(values, image.add(name).begin());
}

double normal(Stream& stream) {
  const double radius = std::sqrt(-2 * std::log(stream.uniform()));
  return radius * std::cos(2 * kPi * stream.uniform());
}

// A flat image of 10 with independent noise of size 1 that claims `claim`, shifted.
Image noisy(std::uint64_t seed, float claim, double shift) {
  Image image(100, 100);
  Stream stream(seed, 0, 1002);
  for (float& value : image.add("a.radiance")) value = static_cast<float>(10 + shift + normal(stream));
  for (float& value : image.add("a.error")) value = claim;
  return image;
}

}  // namespace

TEST_CASE("the image error is that of the definition", "[sensor][compare]") {
  // Reference 100, 10, 1: the floor is 5. Differences 1, 1, 1 are 0.01, 0.1 and 0.2 of the scale.
  const Comparison result = compare(make("a.radiance", {101, 11, 2}), make("a.radiance", {100, 10, 1}));
  REQUIRE(result.channels.size() == 1);
  const ChannelDifference& a = result.channels[0];
  CHECK(a.image_error == Approx(std::sqrt((0.0001 + 0.01 + 0.04) / 3)).epsilon(1e-9));
  CHECK(a.mean_ratio == Approx(114.0 / 111).epsilon(1e-9));
  CHECK(a.max_difference == 1);
  CHECK(a.pixels == 3);
  CHECK(!a.z_rms);
  CHECK(result.image_error() == a.image_error);
  // Twins: the roles are not exchangeable, and the floor matters.
  CHECK(compare(make("a.radiance", {100, 10, 1}), make("a.radiance", {101, 11, 2})).image_error() !=
        Approx(a.image_error).epsilon(1e-3));
}

TEST_CASE("an image equals itself", "[sensor][compare]") {
  const Image image = noisy(1, 1, 0);
  const Comparison result = compare(image, image);
  CHECK(result.image_error() == 0);
  CHECK(result.channels[0].mean_ratio == 1);
  CHECK(*result.channels[0].z_rms == 0);
}

TEST_CASE("z is one where the errors explain the difference", "[sensor][compare]") {
  const auto rms = [](float claim, double shift) {
    return *compare(noisy(1, claim, shift), noisy(2, claim, 0)).channels[0].z_rms;
  };
  CHECK(rms(1, 0) == Approx(1).epsilon(0.03));
  CHECK(rms(2, 0) == Approx(0.5).epsilon(0.03));
  CHECK(rms(1, 3) == Approx(std::sqrt(1 + 4.5)).epsilon(0.03));
  const auto mean = *compare(noisy(1, 1, 3), noisy(2, 1, 0)).channels[0].z_mean;
  CHECK(mean == Approx(3 / std::sqrt(2)).epsilon(0.03));
}

TEST_CASE("an error of 0 explains no difference", "[sensor][compare][not_finite]") {
  Image image = make("a.radiance", {1, 2}), reference = make("a.radiance", {1, 3});
  add(image, "a.error", {0, 0});
  add(reference, "a.error", {0, 0});
  CHECK(std::isinf(*compare(image, reference).channels[0].z_rms));
  CHECK(!compare(image, image).channels[0].z_rms);
}

TEST_CASE("infinite depths agree with each other alone", "[sensor][compare]") {
  const Image image = make("depth.Z", {INFINITY, 5, INFINITY, 10});
  CHECK(compare(image, image).channels[0].mismatched == 0);
  CHECK(compare(image, image).image_error() == 0);
  const Comparison other = compare(image, make("depth.Z", {INFINITY, 5, 7, 10}));
  CHECK(other.channels[0].mismatched == 1);
  CHECK(std::isinf(other.image_error()));
}

TEST_CASE("pixels never done are left out", "[sensor][compare]") {
  Image image = make("a.radiance", {1, 0, 3}), reference = make("a.radiance", {1, 2, 3});
  add(image, "rays.N", {16, 0, 16});
  add(reference, "rays.N", {16, 16, 16});
  CHECK(compare(image, reference).image_error() == 0);
  CHECK(compare(image, reference).channels[0].pixels == 2);
  CHECK(compare(image, make("a.radiance", {1, 2, 3})).image_error() == 0);
  CHECK(compare(make("a.radiance", {1, 0, 3}), reference).image_error() > 0);
}

TEST_CASE("a black reference is met by black alone", "[sensor][compare][not_finite]") {
  CHECK(compare(make("a.radiance", {0, 0}), make("a.radiance", {0, 0})).image_error() == 0);
  CHECK(std::isinf(compare(make("a.radiance", {0, 1}), make("a.radiance", {0, 0})).image_error()));
}

TEST_CASE("images that cannot be compared are bad input", "[sensor][compare]") {
  CHECK_THROWS_AS(compare(make("a.radiance", {1}), make("a.radiance", {1, 2})), InputError);
  CHECK_THROWS_AS(compare(make("a.radiance", {1}), make("b.radiance", {1})), InputError);
  Image undone = make("a.radiance", {1});
  add(undone, "rays.N", {0});
  CHECK_THROWS_AS(compare(undone, undone), InputError);
}

TEST_CASE("the table names every channel and what only one image has", "[sensor][compare]") {
  Image image = make("a.radiance", {1, 2}), reference = make("a.radiance", {1, 2});
  add(image, "b.radiance", {1, 2});
  add(reference, "depth.Z", {1, 2});
  add(image, "depth.Z", {1, 2});
  const std::string table = compare(image, reference).table();
  for (const char* word : {"a.radiance", "depth.Z", "only in the image: b.radiance"}) {
    CHECK(table.find(word) != std::string::npos);
  }
}
