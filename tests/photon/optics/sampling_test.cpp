// Every sampler against its own density, and against wrong ones that must fail.
#include "photon/optics/sampling.h"

#include <catch2/catch.hpp>

#include "octree/base/random.h"
#include "tests/support/chi_square.h"

using namespace obscura;
using namespace obscura::test;

namespace {

constexpr int kSamples = 200000;
const Vec3d kAxis = Vec3d(0.3, -0.7, 0.4).normalized();

std::vector<double> edges(double low, double high, int bins) {
  std::vector<double> result;
  for (int i = 0; i <= bins; ++i) result.push_back(low + (high - low) * i / bins);
  return result;
}

}  // namespace

TEST_CASE("directions are uniform over the sphere", "[photon][sampling]") {
  Stream random(1, 0, 0);
  const auto draw = [&] {
    const double u = random.uniform();
    return uniform_direction(u, random.uniform());
  };
  CHECK(chi_square_directions(
      draw, [](const Vec3d&) { return 1 / (4 * kPi); }, kSamples));
  CHECK(!chi_square_directions(
      draw, [](const Vec3d& w) { return (1 + 0.05 * w.z) / (4 * kPi); }, kSamples));
}

TEST_CASE("points are uniform over the disc in radius and angle", "[photon][sampling]") {
  Stream random(2, 0, 0);
  std::vector<double> observed(8 * 16), expected(8 * 16, kSamples / 128.0), wrong(8 * 16);
  for (int i = 0; i < kSamples; ++i) {
    const double u = random.uniform();
    const auto [x, y] = uniform_disc(u, random.uniform());
    const double area = x * x + y * y;
    REQUIRE(area <= 1 + 1e-15);
    const int ring = std::min(static_cast<int>(8 * area), 7);
    const int sector = std::min(static_cast<int>(16 * (std::atan2(y, x) / (2 * kPi) + 0.5)), 15);
    ++observed[static_cast<std::size_t>(16 * ring + sector)];
  }
  CHECK(chi_square(observed, expected));
  for (std::size_t i = 0; i < wrong.size(); ++i) wrong[i] = expected[i] * (0.97 + 0.06 * (i % 2));
  CHECK(!chi_square(observed, wrong));
  CHECK(uniform_disc(0.5, 0.5) == std::pair<double, double>(0, 0));
}

TEST_CASE("cosine-weighted directions follow the cosine about any normal", "[photon][sampling]") {
  Stream random(3, 0, 0);
  for (const Vec3d& normal : {kAxis, Vec3d(0, 0, 1), Vec3d(0, 0, -1)}) {
    const auto draw = [&] {
      const double u = random.uniform();
      return cosine_direction(normal, u, random.uniform());
    };
    CHECK(chi_square_directions(
        draw, [&](const Vec3d& w) { return std::max(0.0, w.dot(normal)) / kPi; }, kSamples));
    CHECK(!chi_square_directions(
        draw, [&](const Vec3d& w) { return w.dot(normal) > 0 ? 1 / (2 * kPi) : 0.0; }, kSamples));
  }
}

TEST_CASE("directions in a cone are uniform, wide or narrow", "[photon][sampling]") {
  Stream random(4, 0, 0);
  for (const double sine : {0.9, 0.01, 1e-6}) {
    const double versine = sine * sine / (1 + std::sqrt(1 - sine * sine));
    const double solid_angle = cone_direction(kAxis, sine, 0.5, 0.5).second;
    CHECK(solid_angle == Approx(2 * kPi * versine).epsilon(1e-14));
    // By the squared distance from the axis, which keeps its digits: 1 - cos = |w - axis|^2 / 2.
    const auto draw = [&] {
      const double u = random.uniform();
      return 0.5 * (cone_direction(kAxis, sine, u, random.uniform()).first - kAxis).length2() / versine;
    };
    CHECK(chi_square_numbers(
        draw, edges(0, 1 + 1e-9, 50), [](double a, double b) { return b - a; }, kSamples));
    CHECK(!chi_square_numbers(
        draw, edges(0, 1 + 1e-9, 50), [](double a, double b) { return b * b - a * a; }, kSamples));
  }
  CHECK((cone_direction(kAxis, 0, 0.3, 0.7).first - kAxis).length() < 1e-15);
  CHECK(cone_direction(kAxis, 0, 0.3, 0.7).second == 0);
}

TEST_CASE("a direction about an axis has the cosine and turns with the angle", "[photon][sampling]") {
  for (const Vec3d& axis : {kAxis, Vec3d(0, 0, 1), Vec3d(0, 0, -1), Vec3d(1, 0, 0)}) {
    for (const double cosine : {-1.0, -0.3, 0.0, 0.999, 1.0}) {
      const Vec3d a = direction_about(axis, cosine, 0.4);
      const Vec3d b = direction_about(axis, cosine, 0.4 + kPi / 2);
      CHECK(a.dot(axis) == Approx(cosine).margin(1e-12));
      CHECK(a.length() == Approx(1));
      CHECK((a - cosine * axis).dot(b - cosine * axis) == Approx(0).margin(1e-12));
    }
  }
}
