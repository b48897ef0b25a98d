// Strata tile the pixel, one ray in each, uniform over the pixel, the same for any order of pixels.
#include "sensor/capture/sampler.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "tests/support/agree.h"
#include "tests/support/chi_square.h"

using namespace obscura;

namespace {

Camera plain_camera() {
  CameraSettings settings;
  settings.resolution = {40, 30};
  return Camera(settings);
}

std::vector<PixelRay> rays_of(const Sampler& sampler, int x, int y) {
  std::vector<PixelRay> result;
  sampler.rays(x, y, sampler.strata(), 0, result);
  return result;
}

// Places of all rays of the image within their pixels, against equal shares of a grid of cells.
test::ChiSquare places(const Sampler& sampler, const std::function<double(double)>& warp) {
  constexpr int cells = 5;
  std::vector<double> observed(cells * cells), expected(cells * cells);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      for (const PixelRay& ray : rays_of(sampler, x, y)) {
        const int i = std::min(cells - 1, static_cast<int>(warp(ray.px - x) * cells));
        const int j = std::min(cells - 1, static_cast<int>((ray.py - y) * cells));
        ++observed[static_cast<std::size_t>(j * cells + i)];
        for (double& share : expected) share += 1.0 / (cells * cells);
      }
    }
  }
  return test::chi_square(observed, expected);
}

}  // namespace

TEST_CASE("strata of any number tile the pixel in equal areas", "[sensor][sampler]") {
  for (int count = 1; count <= 70; ++count) {
    double area = 0;
    for (int i = 0; i < count; ++i) {
      const Stratum a = stratum(i, count);
      CHECK(a.width * a.height == Approx(1.0 / count).epsilon(1e-12));
      CHECK(a.x_min >= 0);
      CHECK(a.x_min + a.width <= 1 + 1e-12);
      CHECK(a.y_min + a.height <= 1 + 1e-12);
      area += a.width * a.height;
      for (int j = 0; j < i; ++j) {
        const Stratum b = stratum(j, count);
        const double x = std::min(a.x_min + a.width, b.x_min + b.width) - std::max(a.x_min, b.x_min);
        const double y = std::min(a.y_min + a.height, b.y_min + b.height) - std::max(a.y_min, b.y_min);
        CHECK(std::min(x, y) < 1e-12);  // they share no area
      }
    }
    CHECK(area == Approx(1).epsilon(1e-12));
  }
  CHECK(stratum(5, 16).x_min == 0.5);
  CHECK(stratum(5, 16).y_min == 0.25);
}

TEST_CASE("each stratum gets one ray", "[sensor][sampler]") {
  const Camera camera = plain_camera();
  for (const int count : {1, 7, 16}) {
    const Sampler sampler(camera, {.max_oversampling = count, .seed = 3});
    const auto rays = rays_of(sampler, 12, 25);
    REQUIRE(rays.size() == static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
      const Stratum cell = stratum(i, count);
      const double x = rays[static_cast<std::size_t>(i)].px - 12, y = rays[static_cast<std::size_t>(i)].py - 25;
      CHECK(x >= cell.x_min);
      CHECK(x <= cell.x_min + cell.width);
      CHECK(y >= cell.y_min);
      CHECK(y <= cell.y_min + cell.height);
    }
  }
}

TEST_CASE("rays are uniform over the pixel", "[sensor][sampler]") {
  const Camera camera = plain_camera();
  for (const int count : {1, 7}) {  // 7 has strata that no cell of the test lines up with
    const Sampler sampler(camera, {.max_oversampling = count, .seed = 5});
    CHECK(places(sampler, [](double x) { return x; }));
    // A twin: places that are slightly denser on the left are seen.
    CHECK(!places(sampler, [](double x) { return std::pow(x, 1.4); }));
  }
}

TEST_CASE("the mean over rays is unbiased for a curved picture", "[sensor][sampler]") {
  // f(x, y) = x^2 y has the mean 1/6; a sampler at fixed centres of its cells would be off.
  const Camera camera = plain_camera();
  for (const int count : {1, 2, 7, 12}) {
    double sum = 0, sum2 = 0, n = 0;
    for (std::uint64_t seed = 1; seed <= 16; ++seed) {
      const Sampler sampler(camera, {.max_oversampling = count, .seed = seed});
      for (int y = 0; y < 30; ++y) {
        for (int x = 0; x < 40; ++x, ++n) {
          double mean = 0;
          for (const PixelRay& ray : rays_of(sampler, x, y)) {
            mean += (ray.px - x) * (ray.px - x) * (ray.py - y) / count;
          }
          sum += mean;
          sum2 += mean * mean;
        }
      }
    }
    const double mean = sum / n, error = std::sqrt((sum2 / n - mean * mean) / n);
    CHECK(test::agree(mean, error, 1.0 / 6, {.resolution = 0.08 / count, .comparisons = 4}));
    CHECK(!test::agree(1.0 / 8, error, 1.0 / 6, {.resolution = 0.08 / count, .comparisons = 4}));
  }
}

TEST_CASE("a pixel's rays depend on seed, pixel and pass alone", "[sensor][sampler]") {
  const Camera camera = plain_camera();
  const Sampler sampler(camera, {.max_oversampling = 4, .seed = 1});
  const auto first = rays_of(sampler, 7, 9);
  rays_of(sampler, 8, 9);
  const auto again = rays_of(sampler, 7, 9);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(first[i].px == again[i].px);
    CHECK(first[i].py == again[i].py);
    CHECK(first[i].history == again[i].history);
  }
  const auto differs = [&](const SamplerSettings& settings) {
    return rays_of(Sampler(camera, settings), 7, 9)[0].px != first[0].px;
  };
  CHECK(differs({.max_oversampling = 4, .seed = 2}));
  CHECK(differs({.max_oversampling = 4, .seed = 1, .pass = 1}));
  CHECK(rays_of(sampler, 8, 9)[0].px - 8 != first[0].px - 7);
}

TEST_CASE("no two rays of an image share a history, over passes too", "[sensor][sampler]") {
  const Camera camera = plain_camera();
  std::set<std::uint64_t> seen;
  for (std::uint32_t pass = 0; pass < 2; ++pass) {
    const Sampler sampler(camera, {.max_oversampling = 3, .seed = 1, .pass = pass});
    for (int y = 0; y < 30; ++y) {
      for (int x = 0; x < 40; ++x) {
        for (const PixelRay& ray : rays_of(sampler, x, y)) seen.insert(ray.history);
      }
    }
  }
  CHECK(seen.size() == 2u * 3u * 40u * 30u);
}

TEST_CASE("the centre ray goes through the pixel's centre", "[sensor][sampler]") {
  const Camera camera = plain_camera();
  const Sampler sampler(camera, {});
  CHECK(sampler.centre(3, 4)->direction == camera.ray(3.5, 4.5)->direction);
}
