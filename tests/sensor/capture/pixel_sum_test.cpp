// What a pixel's rays tell of their own scatter: differences that no slope moves, by kinds of parts, against the
// scatter of many pixels.
#include "sensor/capture/pixel_sum.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "octree/base/random.h"
#include "octree/base/statistics.h"
#include "sensor/capture/film.h"

using namespace obscura;

namespace {

RaySample sample_of(double radiance) {
  RaySample sample(1);
  sample.bands[0].direct = radiance;
  sample.depth_m = 5;  // a surface: the open sky would be exact
  return sample;
}

/// Four quarters of a pixel, or sixteen of these, in an order in which neighbours touch.
std::vector<Stratum> quarters() {
  return {{0, 0, 0.5, 0.5}, {0, 0.5, 0.5, 0.5}, {0.5, 0.5, 0.5, 0.5}, {0.5, 0, 0.5, 0.5}};
}
/// The first quarter split once more: seven parts.
std::vector<Stratum> split_quarters() {
  std::vector<Stratum> parts;
  for (const Stratum& part : quarters()) {
    if (part.x_min > 0 || part.y_min > 0) {
      parts.push_back(part);
      continue;
    }
    for (const Stratum& small : quarters()) parts.push_back({0.5 * small.x_min, 0.5 * small.y_min, 0.25, 0.25});
  }
  return parts;
}

/// What a place of the pixel shows, of noise of its own too.
using Picture = std::function<double(double x, double y, Stream& stream)>;

/// How the claims of many pixels compare with their scatter: claimed variance over true.
double claimed_over_true(const Picture& picture, const std::vector<Stratum>& parts,
                         const std::function<bool(const Stratum&)>& complex, int pixels = 20000) {
  Moments mean, claimed;
  PixelSum sum(1);
  for (int seed = 0; seed < pixels; ++seed) {
    Stream stream(static_cast<std::uint64_t>(seed), 5, 1002);
    sum.reset();
    for (const Stratum& part : parts) {
      const double x = part.x_min + part.width * stream.uniform(), y = part.y_min + part.height * stream.uniform();
      sum.add(sample_of(picture(x, y, stream)), {.place = part, .weight = part.area(), .complex = complex(part)});
    }
    mean.add(sum.band(0).radiance);
    claimed.add(sum.band(0).variance);
  }
  return claimed.mean() / mean.variance();
}

const auto none = [](const Stratum&) { return false; };

}  // namespace

TEST_CASE("no slope moves the differences that tell scatter", "[sensor][film]") {
  const auto plane = [](double x, double y) { return RayLight{3 + 2 * x - 5 * y}; };
  CHECK(bend(plane(0, 1), plane(2, 2), plane(4, 3)) == Approx(0).margin(1e-14));
  CHECK(twist(plane(0, 0), plane(1, 0), plane(1, 1), plane(0, 1)) == Approx(0).margin(1e-14));
  // One that stands out is seen.
  CHECK(bend({1}, {2}, {1}) == -2);
  CHECK(twist({1}, {0}, {0}, {0}) == 1);
  // What corners foretell comes off, where all tell.
  CHECK(bend({1, 1}, {2, 2}, {1, 1}) == 0);
  CHECK(bend({1, 1}, {2}, {1, 1}) == -2);
  CHECK(twist({1, 0.5}, {0, 0}, {0, 0}, {0, 0}) == 0.5);
}

TEST_CASE("what a pixel says of its rays' scatter is right in the mean", "[sensor][film]") {
  const Picture noise = [](double, double, Stream& s) { return s.uniform(); };
  const Picture slope = [](double x, double y, Stream& s) { return 30 * x - 20 * y + s.uniform(); };
  const Picture edge = [](double x, double y, Stream&) { return x + 0.3 * y < 0.37 ? 1.0 : 0.0; };
  std::vector<Stratum> nine;
  for (int i = 0; i < 9; ++i) nine.push_back(stratum(i, 9));
  for (const auto& parts : {quarters(), nine}) {
    // The bound is three standard errors of 20,000 pixels' variances, beside the slope's within the parts.
    CHECK(claimed_over_true(noise, parts, none) == Approx(1).epsilon(0.05));
  }
  // Parts of two sizes: each ray counts by its area.
  CHECK(claimed_over_true(noise, split_quarters(), none) == Approx(1).epsilon(0.05));
  // A slope is scatter within parts only: of each part 1/12 of the square of what it rises across it.
  CHECK(claimed_over_true(slope, quarters(), none) == Approx(1).epsilon(0.05));
  CHECK(claimed_over_true(slope, nine, none) == Approx(1).epsilon(0.05));
  // An edge through the small parts alone. Of the large ones no differences tell (three make no row): by itself a
  // pixel takes them for as rough, and claims 1 + 12 times too much; its neighbours will know better.
  const Picture corner_edge = [](double x, double y, Stream&) { return x < 0.5 && y < 0.5 && x + y < 0.5 ? 1.0 : 0.0; };
  const double own = claimed_over_true(corner_edge, split_quarters(), [](const Stratum& s) { return s.width < 0.4; });
  CHECK(own > 0.9);
  CHECK(own < 14);
  // A twin: noise of which all is called complex is the same noise.
  CHECK(claimed_over_true(noise, nine, [](const Stratum&) { return true; }) == Approx(1).epsilon(0.04));
  CHECK(claimed_over_true(edge, nine, none) > 0.5);
}

TEST_CASE("two rays tell their scatter by their difference", "[sensor][film]") {
  const Picture noise = [](double, double, Stream& s) { return s.uniform(); };
  for (const int rays : {2, 3}) {
    std::vector<Stratum> parts;
    for (int i = 0; i < rays; ++i) parts.push_back(stratum(i, rays));
    CHECK(claimed_over_true(noise, parts, none) == Approx(1).epsilon(0.1));
    CHECK(claimed_over_true(noise, parts, [](const Stratum&) { return true; }) == Approx(1).epsilon(0.1));
  }
}

TEST_CASE("rays at the same part differ by their noise alone", "[sensor][film]") {
  PixelSum sum(1);
  const Stratum whole{0, 0, 1, 1};
  sum.add(sample_of(1), {.place = whole});
  sum.add(sample_of(3), {.place = whole});
  // Variance of one 2, of the mean of two 1.
  CHECK(sum.band(0).variance == Approx(1));
}

TEST_CASE("rays of more paths scatter less, and say so", "[sensor][film]") {
  // Half the pixel by one ray of 12 paths, half by four of 3: a path has the variance 12.
  Moments mean, claimed;
  PixelSum sum(1);
  for (std::uint64_t seed = 0; seed < 20000; ++seed) {
    Stream stream(seed, 6, 1002);
    sum.reset();
    std::vector<Stratum> parts = split_quarters();
    for (const Stratum& part : parts) {
      const int paths = part.width > 0.4 ? 12 : 3;
      double radiance = 0;
      for (int i = 0; i < paths; ++i) radiance += 12 * (stream.uniform() - 0.5) / paths;
      sum.add(sample_of(radiance), {.place = part, .weight = part.area(), .paths = paths});
    }
    mean.add(sum.band(0).radiance);
    claimed.add(sum.band(0).variance);
  }
  CHECK(claimed.mean() / mean.variance() == Approx(1).epsilon(0.05));
}

TEST_CASE("pixels lend one another what each knows badly of its scatter", "[sensor][film]") {
  // Light that one ray in thirty finds: a pixel of four rays mostly sees none of it, and by itself would claim to be
  // exact. With one ray, none has any scatter of its own.
  for (const int rays : {1, 4}) {
    Moments squares, claims, rough_claims;
    int zero = 0;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      Film film({{32, 32}, 1});
      PixelSum sum(1);
      for (int t = 0; t < film.tile_count(); ++t) {
        FilmTile tile = film.tile(t);
        for (int y = tile.y_begin(); y < tile.y_end(); ++y) {
          for (int x = tile.x_begin(); x < tile.x_end(); ++x) {
            Stream stream(seed, static_cast<std::uint64_t>(32 * y + x), 1003);
            sum.reset();
            for (int r = 0; r < rays; ++r) {
              const Stratum part = stratum(r, rays);
              sum.add(sample_of(10 + 0.2 * x + (stream.uniform() < 1.0 / 30 ? 30.0 : 0.0)),
                      {.place = part, .weight = part.area()});
            }
            tile.put(x, y, sum, 1);
          }
        }
        film.put(std::move(tile));
      }
      film.pool_errors();
      for (int y = 0; y < 32; ++y) {
        for (int x = 0; x < 32; ++x) {
          const auto p = static_cast<std::size_t>(32 * y + x);
          const double off = film.values(0, Film::Value::radiance)[p] - (11 + 0.2 * x);
          const double error = film.values(0, Film::Value::error)[p];
          squares.add(off * off);
          claims.add(error * error);
          zero += error == 0;
        }
      }
    }
    INFO(rays << " rays");
    // 680 rays of each set find the light (2,700 of four): 5 %.
    CHECK(claims.mean() / squares.mean() == Approx(1).epsilon(0.08));
    // But for a few in corners, where windows are smallest.
    CHECK(zero < 10);
  }
}
