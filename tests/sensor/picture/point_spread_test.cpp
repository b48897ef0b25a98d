// Point spread: what becomes of a point, of a uniform picture and of the energy.
#include "sensor/picture/point_spread.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "octree/base/random.h"
#include "tests/support/chi_square.h"

using namespace obscura;
using obscura::test::chi_square;

namespace {

constexpr int kSide = 61;

std::vector<double> point(int x, int y, int columns = kSide, int rows = kSide) {
  std::vector<double> image(static_cast<std::size_t>(columns * rows));
  image[static_cast<std::size_t>(y * columns + x)] = 1;
  return image;
}

std::vector<double> blurred(const std::vector<double>& image, double sigma, int columns = kSide, int rows = kSide) {
  const PointSpread row = gaussian_row(sigma);
  return spread(spread(image, columns, rows, row), columns, rows, row.transposed());
}

double total(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

// Simpson's rule, which knows no error function.
double gaussian_integral(double from, double to, double sigma) {
  constexpr int steps = 200;
  const double h = (to - from) / steps;
  const auto density = [&](double x) {
    return std::exp(-0.5 * x * x / (sigma * sigma)) / (sigma * std::sqrt(2 * kPi));
  };
  double sum = density(from) + density(to);
  for (int i = 1; i < steps; ++i) sum += (i % 2 ? 4 : 2) * density(from + i * h);
  return sum * h / 3;
}

// The picture of a point, as if made of so many photons, against the law.
test::ChiSquare against_law(const std::vector<double>& picture, double sigma, double photons) {
  std::vector<double> observed, expected;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double dx = x - kSide / 2, dy = y - kSide / 2;
      observed.push_back(photons * picture[static_cast<std::size_t>(y * kSide + x)]);
      expected.push_back(photons * gaussian_integral(dx - 0.5, dx + 0.5, sigma) *
                         gaussian_integral(dy - 0.5, dy + 0.5, sigma));
    }
  }
  return chi_square(observed, expected);
}

Image picture_of(int columns, int rows, const std::vector<float>& values) {
  Image image(columns, rows);
  std::ranges::copy(values, image.add("Y").begin());
  return image;
}

}  // namespace

TEST_CASE("a point becomes a gaussian, integrated over each pixel", "[sensor][detector][psf]") {
  for (const double sigma : {0.3, 1.0, 2.7}) {
    INFO(sigma);
    const std::vector<double> picture = blurred(point(kSide / 2, kSide / 2), sigma);
    CHECK(against_law(picture, sigma, 1e8));
    // A sigma 1 % off, or values at pixel centres, are seen.
    CHECK_FALSE(against_law(blurred(point(kSide / 2, kSide / 2), 1.01 * sigma), sigma, 1e8));
    CHECK_FALSE(against_law(picture, 0.99 * sigma, 1e8));
    // Pixels widen the gaussian by their own twelfth (Sheppard), where they resolve it.
    double moment = 0;
    for (std::size_t i = 0; i < picture.size(); ++i) {
      const double dx = static_cast<double>(i % kSide) - kSide / 2;
      moment += picture[i] * dx * dx;
    }
    if (sigma >= 1) CHECK(moment == Approx(sigma * sigma + 1.0 / 12).epsilon(1e-6));
  }
}

TEST_CASE("a point spread keeps energy and darkens no edge", "[sensor][detector][psf]") {
  const auto keeps = [](const PointSpread& by) {
    constexpr int columns = 17, rows = 9;
    Stream random(5, 0, 99);
    std::vector<double> image(columns * rows);
    for (double& value : image) value = random.uniform();
    const std::vector<double> flat(image.size(), 3.0);
    const auto still_flat = spread(flat, columns, rows, by);
    return std::abs(total(spread(image, columns, rows, by)) / total(image) - 1) < 1e-12 &&
           std::ranges::all_of(still_flat, [](double value) { return std::abs(value - 3) < 1e-12; });
  };
  const PointSpread narrow = gaussian_row(0.8);
  const PointSpread wide = gaussian_row(9);  // its reach is many images
  CHECK(keeps(narrow));
  CHECK(keeps(narrow.transposed()));
  CHECK(keeps(wide));
  CHECK(keeps(wide.transposed()));
  CHECK(keeps(point_spread_of(picture_of(3, 3, {1, 2, 1, 2, 9, 2, 1, 2, 1}))));
  // A lens that swallows a thousandth is seen.
  PointSpread lossy = narrow;
  for (double& weight : lossy.weights) weight *= 0.999;
  CHECK_FALSE(keeps(lossy));
  // A picture of a point that leans to one side keeps the energy of what is inside.
  const PointSpread coma = point_spread_of(picture_of(3, 1, {0, 1, 3}));
  CHECK(total(spread(point(30, 30), kSide, kSide, coma)) == Approx(1).epsilon(1e-14));
}

TEST_CASE("a point is shown as the picture that was given", "[sensor][detector][psf]") {
  const PointSpread by = point_spread_of(picture_of(5, 3, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14}));
  const auto shown = spread(point(20, 10), kSide, kSide, by);
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 5; ++i) {
      CHECK(shown[static_cast<std::size_t>((9 + j) * kSide + 18 + i)] == Approx((j * 5 + i) / 105.0).epsilon(1e-14));
    }
  }
}

TEST_CASE("a picture that is no point spread is refused", "[sensor][detector][psf]") {
  const auto says = [](const Image& image) -> std::string {
    try {
      point_spread_of(image);
    } catch (const InputError& error) {
      return error.what();
    }
    return "nothing";
  };
  CHECK(says(picture_of(3, 1, {1, 2, 1})) == "nothing");
  CHECK(says(picture_of(2, 1, {1, 1})).find("no pixel in the middle") != std::string::npos);
  CHECK(says(picture_of(1, 2, {1, 1})).find("odd sides") != std::string::npos);
  CHECK(says(picture_of(3, 1, {1, -1, 1})).find("-1") != std::string::npos);
  CHECK(says(picture_of(1, 1, {std::nanf("")})).find("nan") != std::string::npos);
  CHECK(says(picture_of(1, 1, {0})).find("black") != std::string::npos);
  Image colours(3, 3);
  colours.add("R");
  colours.add("G");
  CHECK(says(colours).find("2 channels") != std::string::npos);
}
