// Adaptive sampling: pixels are split where the picture is complex and nowhere else, and however they are split the
// mean is right.
#include "sensor/capture/refine.h"

#include <tbb/global_control.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <mutex>
#include <set>

#include "octree/base/statistics.h"
#include "sensor/capture/render.h"
#include "tests/support/agree.h"
#include "tests/support/rendered.h"
#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/worlds.h"

using namespace obscura;

namespace {

/// What a picture is as a function of the place on the image, in pixels: transmission and radiance of one band.
struct Shown {
  double radiance = 1;
  double transmission = 1;
  double noise = 0;  // variance of the radiance, told
};
using Picture = std::function<Shown(double px, double py, Stream& stream)>;

/// Orthographic along +y, a pixel a metre: places are told from the rays' origins.
CameraSettings flat_camera(int columns, int rows) {
  CameraSettings settings;
  settings.position_m = {0, -10, 0};
  settings.look_at_m = {0, 0, 0};
  settings.projection = Projection::orthographic;
  settings.width_m = columns;
  settings.resolution = {columns, rows};
  return settings;
}

RadianceEstimator estimator_of(const Picture& picture, const CameraSettings& camera, std::uint64_t seed) {
  const double half_x = 0.5 * camera.resolution[0], half_y = 0.5 * camera.resolution[1];
  return [=](int, const RayShare&, std::span<const Ray> rays, std::span<const std::uint64_t> histories,
             std::span<Incoming> incoming) {
    for (std::size_t r = 0; r < rays.size(); ++r) {
      Stream stream(seed, histories[r], 99);
      const Shown shown = picture(rays[r].origin.x + half_x, half_y - rays[r].origin.z, stream);
      incoming[r] = {};
      incoming[r].direct = shown.radiance;
      incoming[r].transmission = shown.transmission;
      incoming[r].variance = shown.noise;
    }
    return RadianceCounts{};
  };
}

/// A World with a cloud, so that rays decide; what they meet is the estimator's.
const World& cloudy_world() {
  static const World world(test::grey_contents(test::CloudWish(), 1.0));
  return world;
}

SamplerSettings adaptive(int most, std::uint64_t seed = 1) {
  SamplerSettings settings;
  settings.max_oversampling = most;
  settings.adaptive.emplace();
  settings.seed = seed;
  return settings;
}

Rendered draw(const Picture& picture, int columns, int rows, const SamplerSettings& settings,
              const World& world = cloudy_world()) {
  const CameraSettings camera = flat_camera(columns, rows);
  return render(world, estimator_of(picture, camera, settings.seed), Camera(camera), settings);
}

std::uint64_t asked(const Rendered& image, Criterion criterion) {
  return image.rays.asked[static_cast<std::size_t>(criterion)];
}

/// Brighter and opaque inside a circle.
Shown disc(double px, double py, double cx, double cy, double radius) {
  const bool inside = std::hypot(px - cx, py - cy) < radius;
  return {inside ? 5.0 : 1.0, inside ? 0.0 : 1.0, 0};
}

}  // namespace

TEST_CASE("parts tile their pixels, touch in succession and are no more than allowed", "[sensor][refine]") {
  const CameraSettings settings = flat_camera(20, 12);
  const Camera camera(settings);
  const Picture picture = [](double x, double y, Stream&) { return disc(x, y, 8, 6, 3.3); };
  const RadianceEstimator estimator = estimator_of(picture, settings, 1);
  for (const int most : {2, 3, 4, 9, 16, 64}) {
    const Sampler sampler(camera, adaptive(most));
    const Refiner refiner(cloudy_world(), estimator, sampler, {});
    const Film film({{20, 12}, 1});
    std::size_t split = 0;
    for (int t = 0; t < film.tile_count(); ++t) {
      const FilmTile tile = film.tile(t);
      const TileStrata strata = refiner.split(tile);
      for (std::size_t p = 0; p + 1 < strata.first.size(); ++p) {
        const auto parts = strata.of(p);
        REQUIRE(!parts.empty());
        REQUIRE(parts.size() <= static_cast<std::size_t>(most));
        double area = 0;
        for (std::size_t i = 0; i < parts.size(); ++i) {
          area += parts[i].area();
          for (std::size_t j = 0; j < i; ++j) {
            const double x = std::min(parts[i].x_min + parts[i].width, parts[j].x_min + parts[j].width) -
                             std::max(parts[i].x_min, parts[j].x_min);
            const double y = std::min(parts[i].y_min + parts[i].height, parts[j].y_min + parts[j].height) -
                             std::max(parts[i].y_min, parts[j].y_min);
            REQUIRE(std::min(x, y) <= 0);
            if (j + 1 == i && most >= 4) CHECK(std::max(x, y) > 0);
            if (j + 1 == i && most >= 4) CHECK(std::min(x, y) == 0);
          }
        }
        CHECK(area == 1);
        split += parts.size() > 1;
      }
      CHECK(strata.criterion.size() + 1 == strata.first.size());
    }
    CHECK(split > 0);
  }
}

TEST_CASE("a smooth picture costs one ray a pixel and those at the corners", "[sensor][refine]") {
  const auto sloped = [](double x, double y, Stream&) { return Shown{100 + 0.5 * x + y, 0.5, 0}; };
  const Rendered image = draw(sloped, 33, 18, adaptive(64));
  CHECK(image.rays.base == 33 * 18);
  CHECK(image.rays.deciding == 34 * 19);
  for (const std::uint64_t more : image.rays.asked) CHECK(more == 0);
  for (const float rays : image.film.ray_count()) CHECK(rays == 1);
  // The corners know the slope of the picture: one ray anywhere in a pixel brings its mean.
  for (int y = 0; y < 18; ++y) {
    for (int x = 0; x < 33; ++x) {
      const auto p = static_cast<std::size_t>(33 * y + x);
      CHECK(image.film.values(0, Film::Value::radiance)[p] == Approx(100 + 0.5 * (x + 0.5) + y + 0.5).epsilon(1e-6));
      CHECK(image.film.values(0, Film::Value::error)[p] < 1e-4);
    }
  }
}

TEST_CASE("what varies is refined by its own criterion, where it does and nowhere else", "[sensor][refine]") {
  const auto shows = [](const Picture& picture, Criterion criterion) {
    const Rendered image = draw(picture, 16, 16, adaptive(16));
    CHECK(asked(image, criterion) > 0);
    for (std::size_t c = 0; c < image.rays.asked.size(); ++c) {
      if (static_cast<Criterion>(c) != criterion) CHECK(image.rays.asked[c] == 0);
    }
    for (int y = 0; y < 16; ++y) {
      for (int x = 0; x < 16; ++x) {
        const float rays = image.film.ray_count()[static_cast<std::size_t>(16 * y + x)];
        CHECK((rays > 1) == (x == 7));
        CHECK((image.film.criterion()[static_cast<std::size_t>(16 * y + x)] == static_cast<float>(criterion)) ==
              (x == 7));
      }
    }
    return image;
  };
  shows([](double x, double, Stream&) { return Shown{1, x < 7.3 ? 0.5 : 0.6, 0}; }, Criterion::transmission);
  shows([](double x, double, Stream&) { return Shown{x < 7.3 ? 1.0 : 1.1, 1, 0}; }, Criterion::radiance);

  // Below the thresholds, and where nobody asks, there is nothing.
  const auto quiet = [](const Picture& picture, const SamplerSettings& settings) {
    const Rendered image = draw(picture, 16, 16, settings);
    for (const float rays : image.film.ray_count()) CHECK(rays == 1);
  };
  quiet([](double x, double, Stream&) { return Shown{1, x < 7.3 ? 0.5 : 0.54, 0}; }, adaptive(16));
  quiet([](double x, double, Stream&) { return Shown{x < 7.3 ? 1.0 : 1.04, 1, 0}; }, adaptive(16));
  SamplerSettings off = adaptive(16);
  off.adaptive->transmission = off.adaptive->radiance = std::nullopt;
  quiet([](double x, double, Stream&) { return Shown{x < 7.3 ? 1.0 : 9.0, x < 7.3 ? 1.0 : 0.0, 0}; }, off);
  // Dark is dark: twice as bright as a thousandth of the picture's bright end is no difference.
  quiet(
      [](double x, double y, Stream&) {
        return Shown{y > 2.5 && y < 14 ? 1000.0 : x < 7.3 ? 1.0 : 2.0, 1, y > 1.9 && y < 14.1 ? 1e7 : 0.0};
      },
      adaptive(16));
  // Noise that is told is no structure.
  quiet([](double, double, Stream& s) { return Shown{1 + 0.1 * (s.uniform() - 0.5), 1, 0.2}; }, adaptive(16));
}

TEST_CASE("rays that decide are not averaged: the mean of what they see is right", "[sensor][refine]") {
  // A disc of a hundredth of the image, anywhere in it: a corner ray that finds it splits the pixel. If those rays
  // were averaged, or if only pixels that were split saw it, the mean would be off by far more than the limit.
  constexpr int kSeeds = 10000;
  const double area = 0.01, radius = std::sqrt(area / kPi);
  Moments mean, share;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Stream place(seed, 0, 98);
    const double cx = 0.2 + 1.6 * place.uniform(), cy = 0.2 + 1.6 * place.uniform();
    const Rendered image =
        draw([&](double x, double y, Stream&) { return disc(x, y, cx, cy, radius); }, 2, 2, adaptive(16, seed));
    mean.add(image.film.mean(0).mean);
    share.add(asked(image, Criterion::transmission) > 0);
  }
  CHECK(share.mean() > 0.003);
  CHECK(share.mean() < 0.2);
  const double truth = 1 + 4 * area / 4;
  CHECK(test::agree(mean.mean(), mean.standard_error(), truth, {.resolution = 0.008}));
  CHECK_FALSE(test::agree(1 + 4 * area * area, mean.standard_error(), truth, {.resolution = 0.008}));
}

TEST_CASE("what the corners say of a slope leaves the mean alone", "[sensor][refine]") {
  // A curved picture, with noise that is told and without: corners that stand high on a bend lend a slope, not a value.
  const auto bent = [](double noise) {
    return [noise](double x, double y, Stream& s) {
      return Shown{100 + 0.3 * x * x - 2 * x * y + noise * (s.uniform() - 0.5), 0.5, noise * noise / 12};
    };
  };
  // Its mean over 4 x 3 pixels, of x^2: 16 / 3, of x y: 2 * 1.5.
  const double truth = 100 + 0.3 * 16 / 3 - 2 * 2 * 1.5;
  for (const double noise : {0.0, 2.0, 40.0}) {
    Moments mean, plain;
    for (std::uint64_t seed = 1; seed <= 4000; ++seed) {
      SamplerSettings one = adaptive(2, seed);
      one.adaptive->radiance = std::nullopt;
      mean.add(draw(bent(noise), 4, 3, one).film.mean(0).mean);
      one.adaptive = std::nullopt;
      one.max_oversampling = 1;
      plain.add(draw(bent(noise), 4, 3, one).film.mean(0).mean);
    }
    CHECK(test::agree(mean.mean(), mean.standard_error(), truth, {.resolution = 0.01}));
    // Slopes that are known are not noise; noise is not taken for slopes.
    if (noise < 10) CHECK(mean.standard_error() < 0.6 * plain.standard_error());
    CHECK(mean.standard_error() < 1.1 * plain.standard_error());
  }
}

TEST_CASE("a polygon far smaller than the pixel comes out at its true mean", "[sensor][refine]") {
  // A hundredth of the pixel, in its middle, where no ray of the base grid is; a thread across the pixel, as thin.
  const auto world_of = [](std::shared_ptr<const Mesh> mesh) {
    WorldContents contents = test::empty_contents(1.0);
    contents.materials = {test::grey_material(1)};
    contents.objects.push_back(test::grey_object(std::move(mesh), 0, 5.0));
    return World(std::move(contents));
  };
  const World patch = world_of(test::parallelogram({-0.05, 0, -0.05}, {0.1, 0, 0}, {0, 0, 0.1}));
  const World thread = world_of(test::parallelogram({-0.5, 0, 0.2}, {1, 0, 0.03}, {0, 0, 0.01}));
  constexpr int kSeeds = 10000;
  for (const World* world : {&patch, &thread}) {
    CameraSettings camera = flat_camera(1, 1);
    Moments mean;
    std::uint64_t rays = 0;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      const Rendered image = test::render_pass(*world, {}, Camera(camera), adaptive(16, seed), {});
      mean.add(image.film.mean(0).mean);
      rays += image.film.rays();
    }
    CHECK(rays > 9 * kSeeds);
    // A hundredth of (5 - 1); of a base ray alone the standard error would be 0.004.
    CHECK(test::agree(mean.mean(), mean.standard_error(), 1.04, {.resolution = 0.01}));
    CHECK_FALSE(test::agree(1.0004, mean.standard_error(), 1.04, {.resolution = 0.01}));
    CHECK(mean.standard_error() < 0.0015);
  }
}

TEST_CASE("rays for the error leave the mean alone and reach the error", "[sensor][refine]") {
  // Light that one ray in fifty finds: few rays that see none of it would stop at once.
  const Picture rare = [](double, double, Stream& s) { return Shown{s.uniform() < 0.02 ? 50.0 : 0.0, 0.5, 0}; };
  SamplerSettings settings = adaptive(256);
  settings.adaptive->radiance = std::nullopt;
  Moments mean, rays;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    settings.seed = seed;
    settings.adaptive->error = 0.5;
    const Rendered image = draw(rare, 24, 24, settings);
    mean.add(image.film.mean(0).mean);
    rays.add(static_cast<double>(image.film.rays()) / (24 * 24));
    CHECK(asked(image, Criterion::error) == image.film.rays() - image.rays.base);
  }
  CHECK(rays.mean() > 4);
  CHECK(rays.mean() < 200);
  CHECK(test::agree(mean.mean(), mean.standard_error(), 1.0, {.resolution = 0.25}));

  // Of plain noise the target is met: the true error, and what the film says of it.
  const Picture plain = [](double, double, Stream& s) { return Shown{10 + 2 * (s.uniform() - 0.5), 0.5, 1.0 / 3}; };
  settings.adaptive->error = 0.02;
  const Rendered image = draw(plain, 40, 40, settings);
  double square = 0, claimed = 0;
  for (const float value : image.film.values(0, Film::Value::radiance)) square += (value - 10) * (value - 10) / 1600;
  for (const float error : image.film.values(0, Film::Value::error)) claimed += error * error / 1600;
  CHECK(std::sqrt(square) < 0.2);
  CHECK(std::sqrt(square) > 0.1);
  CHECK(std::sqrt(claimed) == Approx(std::sqrt(square)).epsilon(0.2));
  // Looser wishes cost less.
  settings.adaptive->error = 0.05;
  CHECK(draw(plain, 40, 40, settings).film.rays() < image.film.rays());
}

TEST_CASE("no two rays share their random numbers, those that decide included", "[sensor][refine]") {
  const CameraSettings camera =
      flat_camera(16, 14);  // one tile: neighbours trace the corners between them alike, each for itself
  const Picture picture = [](double x, double y, Stream& s) {
    Shown shown = disc(x, y, 8, 6, 4.4);
    shown.radiance += s.uniform();
    return shown;
  };
  std::mutex lock;
  std::multiset<std::uint64_t> names;
  const RadianceEstimator estimator = estimator_of(picture, camera, 1);
  const RadianceEstimator noted = [&](int interval, const RayShare& share, std::span<const Ray> rays,
                                      std::span<const std::uint64_t> histories, std::span<Incoming> incoming) {
    const std::lock_guard guard(lock);
    names.insert(histories.begin(), histories.end());
    return estimator(interval, share, rays, histories, incoming);
  };
  SamplerSettings settings = adaptive(64);
  settings.adaptive->error = 0.05;
  const Rendered image = render(cloudy_world(), noted, Camera(camera), settings);
  CHECK(image.rays.deciding > 17 * 15);
  CHECK(names.size() == image.film.rays() + image.rays.deciding);
  CHECK(std::set<std::uint64_t>(names.begin(), names.end()).size() == names.size());
}

TEST_CASE("adaptive pictures have the same bits for any number of threads", "[sensor][refine]") {
  const Picture picture = [](double x, double y, Stream& s) {
    Shown shown = disc(x, y, 20, 17, 9);
    shown.radiance += 0.3 * s.uniform();
    return shown;
  };
  SamplerSettings settings = adaptive(64);
  settings.adaptive->error = 0.02;
  const auto with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return draw(picture, 50, 37, settings);
  };
  const Rendered one = with(1), three = with(3);
  for (const Film::Value value : {Film::Value::radiance, Film::Value::error}) {
    CHECK(std::ranges::equal(one.film.values(0, value), three.film.values(0, value)));
  }
  CHECK(std::ranges::equal(one.film.ray_count(), three.film.ray_count()));
  CHECK(one.rays.asked == three.rays.asked);
  CHECK(one.rays.deciding == three.rays.deciding);
}
