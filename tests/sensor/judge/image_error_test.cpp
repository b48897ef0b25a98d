// A film's knowledge of its own image error, on films whose pixels err as told.
#include "sensor/judge/image_error.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "octree/base/random.h"
#include "octree/base/statistics.h"
#include "sensor/capture/render.h"
#include "tests/support/distributions.h"
#include "tests/support/rendered.h"
#include "tests/support/worlds.h"

using namespace obscura;

namespace {

constexpr int kSide = 64;

double normal(Stream& stream) {
  const double u = stream.uniform();
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * kPi * stream.uniform());
}

struct Noise {
  double rays = 0;    // standard deviation of a pixel, by rays of its own
  double shared = 0;  // of every pixel of a tile alike, by the map
  double bias = 0;
};

/// A film of mean `level(x, y)` with noise as told, and of four rays a pixel.
Film noisy_film(const Noise& noise, std::uint64_t seed, const std::function<double(int, int)>& level) {
  Film film({{kSide, kSide}, 1});
  constexpr int kRays = 4;
  for (int t = 0; t < film.tile_count(); ++t) {
    Stream of_tile(seed, static_cast<std::uint64_t>(t), 1);
    std::array<double, kBatches> map;
    for (double& batch : map) batch = noise.shared * std::sqrt(static_cast<double>(kBatches)) * normal(of_tile);
    FilmTile tile = film.tile(t);
    PixelSum sum(1);
    for (int y = tile.y_begin(); y < tile.y_end(); ++y) {
      for (int x = tile.x_begin(); x < tile.x_end(); ++x) {
        Stream stream(seed, static_cast<std::uint64_t>(y * kSide + x), 2);
        sum.reset();
        for (int r = 0; r < kRays; ++r) {
          RaySample sample(1);
          sample.bands[0].direct = level(x, y) + noise.rays * std::sqrt(static_cast<double>(kRays)) * normal(stream);
          sample.bands[0].map = map;
          sample.bands[0].bias = noise.bias + 0.5 * normal(stream);
          sum.add(sample);
        }
        tile.put(x, y, sum, 0);
      }
    }
    film.put(std::move(tile));
  }
  return film;
}

double true_square(const Film& film, const std::function<double(int, int)>& level) {
  double sum = 0, brightest = 0;
  for (int i = 0; i < kSide * kSide; ++i) brightest = std::max(brightest, level(i % kSide, i / kSide));
  for (int i = 0; i < kSide * kSide; ++i) {
    const double truth = level(i % kSide, i / kSide);
    const double off = (film.values(0, Film::Value::radiance)[static_cast<std::size_t>(i)] - truth) /
                       std::max(truth, 0.05 * brightest);
    sum += off * off;
  }
  return sum / (kSide * kSide);
}

}  // namespace

TEST_CASE("a film foretells its image error, dark pixels as the measure has them", "[sensor][image_error]") {
  // Half the picture is darker than a twentieth of its brightest.
  const auto level = [](int x, int y) { return x < kSide / 2 ? 0.01 + 0.001 * y / kSide : 1.0 + 0.5 * y / kSide; };
  for (const double sigma : {0.002, 0.02}) {
    Moments foretold, found;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const Film film = noisy_film({sigma}, seed, level);
      foretold.add(film_error(film, 0).square);
      found.add(true_square(film, level));
    }
    CAPTURE(sigma, foretold.mean(), found.mean());
    CHECK(foretold.mean() == Approx(found.mean()).epsilon(0.04));
  }
}

TEST_CASE("noise that pixels share leaves an image error less certain", "[sensor][image_error]") {
  const auto level = [](int, int) { return 1.0; };
  const auto freedom = [&](const Noise& noise) {
    Moments told, square;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      const Film film = noisy_film(noise, seed, level);
      told.add(film_error(film, 0).freedom);
      square.add(true_square(film, level));
    }
    // Of chi-squared: 2 mean^2 / variance. Forty of them tell it to a factor of 1.6.
    return std::pair(told.mean(), 2 * square.mean() * square.mean() / square.variance());
  };
  const auto [apart, apart_found] = freedom({0.05, 0, 0});
  CHECK(apart > 0.4 * kSide * kSide);
  CHECK(apart == Approx(apart_found).epsilon(0.6));
  const auto [together, together_found] = freedom({0.001, 0.05, 0});
  CHECK(together < 40);  // there are 16 tiles
  CHECK(together == Approx(together_found).epsilon(0.6));
}

TEST_CASE("products of independent estimates tell a bias apart from their noise", "[sensor][image_error]") {
  const auto level = [](int, int) { return 2.0; };
  for (const double bias : {0.0, 0.1}) {
    std::vector<std::vector<double>> estimates;
    for (std::uint64_t seed = 1; seed <= 4; ++seed)
      estimates.push_back(film_error(noisy_film({0.01, 0, bias}, seed, level), 0).bias);
    REQUIRE(estimates[0].size() == 256);
    const BiasSquare square = bias_square(estimates);
    CAPTURE(bias, square.mean, square.standard_error);
    CHECK(std::abs(square.mean - 0.25 * bias * bias) < 4 * square.standard_error);
    CHECK(square.standard_error < 2e-4);
    // One estimate's own square would be off by its noise: of 16 pixels of four rays.
    double own = 0;
    for (const double block : estimates[0]) own += block * block / 256;
    CHECK(own > square.mean + 4 * square.standard_error);
  }
}

TEST_CASE("a pixel is the same whether its tile is done alone or with all others", "[sensor][render]") {
  const World world(test::grey_contents(test::rough_wish(0, 0, 1.0), 0.3));
  CameraSettings settings;
  settings.position_m = {1.6, -8, 1.6};
  settings.look_at_m = {1.6, 0, 1.6};
  settings.resolution = {48, 40};
  const Camera camera(settings);
  const auto picture = [&](std::vector<int> tiles, bool adaptive) {
    SamplerSettings sampling;
    sampling.max_oversampling = 4;
    if (adaptive) {
      sampling.adaptive.emplace();
      sampling.adaptive->radiance = std::nullopt;  // is relative to the whole picture's bright end
    }
    sampling.tiles = std::move(tiles);
    return test::render_pass(world, {}, camera, sampling, RadianceSettings{});
  };
  for (const bool adaptive : {false, true}) {
    const Rendered all = picture({}, adaptive), some = picture({4, 1}, adaptive);
    CHECK(some.film.partial());
    CHECK(some.film.pixels_done() == 512);
    CHECK(some.rays.deciding < all.rays.deciding + !adaptive);
    for (int y = 0; y < 40; ++y) {
      for (int x = 0; x < 48; ++x) {
        const int tile = y / 16 * 3 + x / 16;
        const std::size_t p = static_cast<std::size_t>(y * 48 + x);
        const bool done = tile == 4 || tile == 1;
        REQUIRE((some.film.passes(x, y) > 0) == done);
        if (done)
          REQUIRE(some.film.values(0, Film::Value::radiance)[p] == all.film.values(0, Film::Value::radiance)[p]);
      }
    }
  }
}
