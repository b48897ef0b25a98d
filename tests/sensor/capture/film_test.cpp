// The film's sums against formulas by hand, its errors against the scatter of repeated renderings.
#include "sensor/capture/film.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "octree/base/random.h"

using namespace obscura;

namespace {

// Standard normal (Box and Muller).
double normal(Stream& stream) {
  const double radius = std::sqrt(-2 * std::log(stream.uniform()));
  return radius * std::cos(2 * kPi * stream.uniform());
}

// How a synthetic pixel's noise comes about: all have mean `truth`.
struct Noise {
  double shared = 0;  // of one batch, common to all rays of the pixel (photons shared by all)
  double own = 0;     // of one batch, each ray its own (photons not shared)
  double rays = 0;    // of the ray's direct part (what the pixel shows varies)
};

PixelSum synthetic_pixel(std::uint64_t seed, int rays, double truth, const Noise& noise) {
  Stream stream(seed, 77, 1000);
  std::array<double, kBatches> shared;
  for (double& value : shared) value = noise.shared * normal(stream);
  PixelSum pixel(1);
  RaySample sample(1);
  for (int r = 0; r < rays; ++r) {
    sample.reset();
    sample.bands[0].direct = 0.25 * truth + noise.rays * normal(stream);
    for (std::size_t k = 0; k < kBatches; ++k) {
      sample.bands[0].map[k] = 0.75 * truth + shared[k] + noise.own * normal(stream);
    }
    pixel.add(sample);
  }
  return pixel;
}

// Share of 200 renderings whose truth lies inside the 95 % interval of Student's t.
double coverage(int rays, const Noise& noise, double quantile, double claim = 1) {
  int inside = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const PixelBand band = synthetic_pixel(seed, rays, 5.0, noise).band(0);
    inside += std::abs(band.radiance - 5.0) <= claim * quantile * std::sqrt(band.variance);
  }
  return inside / 200.0;
}

RaySample plain_sample(double direct, double map, double transmission, double depth_m) {
  RaySample sample(1);
  sample.bands[0].direct = direct;
  sample.bands[0].map.fill(map);
  sample.bands[0].transmission = transmission;
  sample.depth_m = depth_m;
  return sample;
}

// Fills a film with a picture that differs everywhere, in the given order of tiles.
Film fill(int columns, int rows, std::uint64_t seed, const std::vector<int>& order) {
  Film film({.resolution = {columns, rows}, .bands = 2});
  PixelSum sum(2);
  RaySample sample(2);
  for (const int t : order) {
    FilmTile tile = film.tile(t);
    for (int y = tile.y_begin(); y < tile.y_end(); ++y) {
      for (int x = tile.x_begin(); x < tile.x_end(); ++x) {
        Stream stream(seed, static_cast<std::uint64_t>(y * columns + x), 1001);
        sum.reset();
        for (int r = 0; r < 3; ++r) {
          sample.reset();
          for (BandSample& band : sample.bands) {
            band.direct = stream.uniform();
            for (double& value : band.map) value = stream.uniform();
            band.bias = 0.01 * stream.uniform();
            band.transmission = stream.uniform();
          }
          sample.depth_m = 10 + stream.uniform();
          sum.add(sample);
        }
        tile.put(x, y, sum, static_cast<std::uint32_t>(1 + (x + y) % 5));
      }
    }
    film.put(std::move(tile));
  }
  return film;
}

std::vector<int> tiles(int count) {
  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

}  // namespace

TEST_CASE("a pixel is the mean of its rays", "[sensor][film]") {
  PixelSum pixel(1);
  pixel.add(plain_sample(1, 2, 0.5, 7));
  pixel.add(plain_sample(2, 3, 0.25, 5));
  pixel.add(plain_sample(6, 4, 0, kInfinity));
  const PixelBand band = pixel.band(0);
  CHECK(band.radiance == Approx(6).epsilon(1e-14));
  CHECK(band.transmission == Approx(0.25).epsilon(1e-14));
  CHECK(pixel.depth_m() == 5);
  CHECK(pixel.rays() == 3);
  // Radiances 3, 5, 10: the second difference of 3 makes the variance 9 / 6; batches agree.
  CHECK(band.variance == Approx(1.5 / 3).epsilon(1e-12));
  CHECK(band.ray_variance == Approx(1.5 / 3).epsilon(1e-12));
  for (const double batch : band.batch) CHECK(batch == Approx(6).epsilon(1e-14));
}

TEST_CASE("the batches' scatter is the error that rays share", "[sensor][film]") {
  PixelSum pixel(1);
  RaySample sample(1);
  for (std::size_t k = 0; k < kBatches; ++k) sample.bands[0].map[k] = static_cast<double>(k);
  for (int r = 0; r < 4; ++r) pixel.add(sample);
  // 0..15 has the variance 68/3; rays are equal, so their scatter adds nothing.
  CHECK(pixel.band(0).variance == Approx(68.0 / 3 / 3 * 3 / 16).epsilon(1e-12));
  CHECK(pixel.band(0).ray_variance == 0);
}

TEST_CASE("the error covers the truth as often as it says", "[sensor][film]") {
  // Quantiles of Student's t for the degrees of freedom of what dominates.
  const double t15 = 2.131, t63 = 1.998;
  struct Case {
    const char* name;
    int rays;
    Noise noise;
    double quantile;
  };
  for (const Case& c :
       {Case{"photons that all rays share", 16, {1, 0, 0}, t15}, Case{"photons that no rays share", 16, {0, 1, 0}, t15},
        Case{"half of each", 16, {1, 4, 0}, t15}, Case{"rays alone", 16, {0, 0, 1}, t15},
        Case{"rays alone, many", 64, {0, 0, 1}, t63}, Case{"everything", 16, {1, 2, 0.3}, t15},
        Case{"one ray", 1, {1, 1, 0}, t15}}) {
    INFO(c.name);
    const double share = coverage(c.rays, c.noise, c.quantile);
    CHECK(share >= 0.90);
    CHECK(share <= 0.98 + 0.005);
    // A twin: an error that is half or twice as large as it should be falls out.
    CHECK(coverage(c.rays, c.noise, c.quantile, 0.5) < 0.90);
    CHECK(coverage(c.rays, c.noise, c.quantile, 2) > 0.985);
  }
}

TEST_CASE("the variance is right in the mean, not only on the safe side", "[sensor][film]") {
  for (const Noise& noise : {Noise{1, 0, 0}, Noise{0, 1, 0}, Noise{0.5, 2, 0.2}}) {
    double claimed = 0, found = 0;
    const int n = 4000, rays = 9;
    for (std::uint64_t seed = 0; seed < n; ++seed) {
      const PixelBand band = synthetic_pixel(seed, rays, 5.0, noise).band(0);
      claimed += band.variance / n;
      found += (band.radiance - 5) * (band.radiance - 5) / n;
    }
    const double expected =
        (noise.shared * noise.shared + noise.own * noise.own / rays) / 16 + noise.rays * noise.rays / rays;
    CHECK(found == Approx(expected).epsilon(0.12));
    // Cutting the rays' share at 0 leaves a quarter at most (12 % of the error) on the safe side.
    CHECK(claimed > 0.96 * expected);
    CHECK(claimed < 1.3 * expected);
  }
}

TEST_CASE("what is not finite never reaches the image, and is counted", "[sensor][film]") {
  PixelSum pixel(1);
  pixel.add(plain_sample(2, 0, 1, 3));
  pixel.add(plain_sample(NAN, 0, 1, 3));
  pixel.add(plain_sample(0, INFINITY, 1, 3));
  pixel.add(plain_sample(0, 0, NAN, 3));
  pixel.add(plain_sample(0, 0, 1, NAN));
  CHECK(pixel.anomalies() == 4);
  CHECK(pixel.rays() == 1);
  CHECK(pixel.band(0).radiance == 2);

  Film film({.resolution = {2, 1}, .bands = 1});
  FilmTile tile = film.tile(0);
  tile.put(0, 0, pixel, 0);
  pixel.reset();
  pixel.add(plain_sample(1e300, 0, 1, 3));
  tile.put(1, 0, pixel, 0);
  film.put(std::move(tile));
  CHECK(film.anomalies() == 5);
  CHECK(std::isfinite(film.values(0, Film::Value::radiance)[1]));
  for (int v = 0; v < Film::kBandValues; ++v) {
    for (const float value : film.values(0, static_cast<Film::Value>(v))) CHECK(!std::isnan(value));
  }
}

TEST_CASE("the film's bits do not depend on the order of tiles", "[sensor][film]") {
  std::vector<int> order = tiles(12);
  const Film forward = fill(50, 40, 9, order);
  std::reverse(order.begin(), order.end());
  std::swap(order[2], order[7]);
  const Film backward = fill(50, 40, 9, order);
  REQUIRE(forward.tile_count() == 12);
  CHECK(!forward.partial());
  for (int band = 0; band < 2; ++band) {
    for (int v = 0; v < Film::kBandValues; ++v) {
      const auto a = forward.values(band, static_cast<Film::Value>(v));
      const auto b = backward.values(band, static_cast<Film::Value>(v));
      CHECK(std::equal(a.begin(), a.end(), b.begin(), b.end()));
    }
    CHECK(forward.mean(band).mean == backward.mean(band).mean);
    CHECK(forward.mean(band).standard_error == backward.mean(band).standard_error);
  }
  CHECK(forward.rays() == 3u * 50u * 40u);
}

TEST_CASE("an image's mean and its error come from the batches", "[sensor][film]") {
  // Every pixel shares the batches' errors 0..15: the image's mean is no better than one pixel's.
  Film film({.resolution = {20, 20}, .bands = 1});
  PixelSum pixel(1);
  RaySample sample(1);
  for (std::size_t k = 0; k < kBatches; ++k) sample.bands[0].map[k] = static_cast<double>(k);
  pixel.add(sample);
  pixel.add(sample);
  for (int t = 0; t < film.tile_count(); ++t) {
    FilmTile tile = film.tile(t);
    for (int y = tile.y_begin(); y < tile.y_end(); ++y) {
      for (int x = tile.x_begin(); x < tile.x_end(); ++x) tile.put(x, y, pixel, 0);
    }
    film.put(std::move(tile));
  }
  const ImageMean mean = film.mean(0);
  CHECK(mean.mean == Approx(7.5).epsilon(1e-14));
  CHECK(mean.batch[3] == Approx(3).epsilon(1e-14));
  CHECK(mean.standard_error == Approx(std::sqrt(68.0 / 3 / 16)).epsilon(1e-12));

  // A tile is an image of its own: here the last, of 4 x 4 pixels.
  const ImageMean corner = film.mean_of_tile(3, 0);
  CHECK(film.tile_box(3) == std::array<int, 4>{16, 16, 4, 4});
  CHECK(corner.mean == Approx(7.5).epsilon(1e-14));
  CHECK(corner.standard_error == Approx(mean.standard_error).epsilon(1e-12));

  // Rays that scatter on their own average out over pixels.
  const Film rays = fill(50, 40, 4, tiles(12));
  const auto error = rays.values(0, Film::Value::error);
  CHECK(rays.mean(0).standard_error < 0.1 * error[0]);
  // Tiles together are the image.
  double sum = 0;
  for (int t = 0; t < rays.tile_count(); ++t) {
    const auto box = rays.tile_box(t);
    sum += rays.mean_of_tile(t, 0).mean * box[2] * box[3];
  }
  CHECK(sum / (50 * 40) == Approx(rays.mean(0).mean).epsilon(1e-12));
}

TEST_CASE("a film that lacks tiles is partial and says which pixels", "[sensor][film]") {
  const Film film = fill(50, 40, 9, {0, 5});
  CHECK(film.partial());
  CHECK(film.pixels_done() == 2u * 16u * 16u);
  CHECK(film.passes(3, 3) == 1);
  CHECK(film.passes(40, 3) == 0);
  CHECK(film.ray_count()[40] == 0);
  CHECK(std::isinf(film.depth_m()[40]));
  CHECK(film.mean(0).mean == Approx(1).epsilon(0.05));  // over the pixels that are done
}

TEST_CASE("passes merge to their mean, errors in squares", "[sensor][film]") {
  Film a = fill(50, 40, 1, tiles(12));
  const Film b = fill(50, 40, 2, tiles(12)), c = fill(50, 40, 3, tiles(12));
  const Film first = a;
  a.merge(b);
  a.merge(c);
  const auto value = [](const Film& film, Film::Value which) { return film.values(1, which)[777]; };
  using enum Film::Value;
  CHECK(value(a, radiance) ==
        Approx((value(first, radiance) + value(b, radiance) + value(c, radiance)) / 3).epsilon(1e-6));
  CHECK(value(a, error) == Approx(std::sqrt(std::pow(value(first, error), 2) + std::pow(value(b, error), 2) +
                                            std::pow(value(c, error), 2)) /
                                  3)
                               .epsilon(1e-6));
  CHECK(a.depth_m()[777] == std::min({first.depth_m()[777], b.depth_m()[777], c.depth_m()[777]}));
  CHECK(a.ray_count()[777] == 9);
  CHECK(a.object_id()[777] == first.object_id()[777]);
  CHECK(a.passes(0, 0) == 3);
  CHECK(a.rays() == 3 * first.rays());
  CHECK(a.mean(1).mean == Approx((first.mean(1).mean + b.mean(1).mean + c.mean(1).mean) / 3).epsilon(1e-12));
  CHECK(a.mean(1).standard_error == Approx(first.mean(1).standard_error / std::sqrt(3)).epsilon(0.5));
}

TEST_CASE("merging a pass that covers other tiles fills the gaps", "[sensor][film]") {
  Film a = fill(50, 40, 1, {0, 1, 2, 3, 4});
  const Film b = fill(50, 40, 1, {5, 6, 7, 8, 9, 10, 11});
  const Film whole = fill(50, 40, 1, tiles(12));
  a.merge(b);
  CHECK(!a.partial());
  const auto merged = a.values(0, Film::Value::radiance), direct = whole.values(0, Film::Value::radiance);
  CHECK(std::equal(merged.begin(), merged.end(), direct.begin(), direct.end()));
  CHECK(a.mean(0).standard_error == whole.mean(0).standard_error);
  CHECK(std::equal(a.object_id().begin(), a.object_id().end(), whole.object_id().begin()));
}
