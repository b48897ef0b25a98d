// Light between surfaces and clouds against exact answers: the furnace, view factors, lit planes, mirrors.
#include <catch2/catch.hpp>

#include "photon/optics/sampling.h"
#include "sensor/capture/render.h"
#include "tests/support/agree.h"
#include "tests/support/rendered.h"
#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

constexpr double kRadiance = 3.7;

TraceSettings photons(std::uint64_t count) {
  TraceSettings settings;
  settings.photons = count;
  return settings;
}

Film photograph(const World& world, const Light& light, const CameraSettings& camera, int rays,
                const RadianceSettings& radiance = {}) {
  CHECK(light.anomalies == 0);
  Rendered rendered =
      test::render_pass(world, light.maps, Camera(camera), {.max_oversampling = rays, .seed = 1}, radiance);
  CHECK(rendered.counts.anomalies == 0);
  return std::move(rendered.film);
}

/// A rough cloud in a closed box that is as warm as it is.
WorldContents furnace(double albedo, const Material& material, double walls = kRadiance) {
  WorldContents contents = grey_contents(rough_wish(albedo, 0, kRadiance));
  contents.materials = {material};
  contents.objects = {grey_object(box_mesh({-1, -1, -1}, {4.2, 4.4, 4.1}, true), 0, walls),
                      grey_sphere({3.5, -0.3, 0}, 0.4, 0, kRadiance)};
  return contents;
}

ImageMean furnace_mean(const WorldContents& contents) {
  const World world(contents);
  const Light light = trace_light(world, photons(500000));
  CHECK(pairwise_sum(light.bands[0].energy.escaped) == 0);
  CameraSettings camera;
  camera.position_m = {-0.9, -0.8, 3.5};
  camera.look_at_m = {2, 2, 1};
  camera.fov_deg = 90;
  camera.resolution = {32, 24};
  return photograph(world, light, camera, 32).mean(0);
}

}  // namespace

TEST_CASE("a closed box with a cloud of its temperature is black everywhere", "[physics][furnace][surfaces]") {
  Material by_angle = grey_material(0.7);
  by_angle.angle_deg = {0, 50, 90};
  by_angle.angle_factor = {1, 0.9, 0.1};
  const struct {
    double albedo;
    Material material;
  } cases[] = {{0, grey_material(0.3)},
               {0.8, grey_material(0.5)},
               {0.8, grey_material(0.2, 1)},
               {0.6, grey_material(0.4, 0.5, 0.2)},
               {0.5, by_angle},
               {0, grey_material(1)}};
  for (const auto& c : cases) {
    const ImageMean mean = furnace_mean(furnace(c.albedo, c.material));
    INFO("albedo " << c.albedo << ", emissivity " << c.material.emissivity[0] << ", specular " << c.material.specular
                   << ": mean " << mean.mean << " +- " << mean.standard_error);
    CHECK(std::abs(mean.mean - kRadiance) <= 3 * mean.standard_error + 1e-6 * kRadiance);
    CHECK(mean.standard_error < 0.003 * kRadiance);
  }
}

TEST_CASE("a box that is colder than its cloud is seen to be no furnace", "[physics][furnace][surfaces]") {
  const ImageMean mean = furnace_mean(furnace(0.8, grey_material(0.5), 0.95 * kRadiance));
  CHECK(std::abs(mean.mean - kRadiance) > 3 * mean.standard_error);
}

namespace {

/// Share of the emitted power that lands on surfaces.
BatchMean landed_share(const World& world, std::uint64_t count) {
  const EnergyTally energy = trace_light(world, photons(count)).bands[0].energy;
  BatchTally share;
  for (std::size_t b = 0; b < share.size(); ++b) share[b] = energy.surface[b] / energy.emitted[b];
  return batch_mean(share);
}

CameraSettings from_above(double width, const Vec3d& middle) {
  CameraSettings camera;
  camera.projection = Projection::orthographic;
  camera.width_m = width;
  camera.position_m = middle + Vec3d(0, 0, 0.5);
  camera.look_at_m = middle;
  camera.up = {0, 1, 0};
  camera.resolution = {16, 16};
  return camera;
}

}  // namespace

TEST_CASE("two facing squares exchange what their view factor says", "[physics][surfaces]") {
  // Unit squares at unit distance: 0.199825 (Howell, A Catalog of Radiation Transfer Configuration Factors, C-11).
  constexpr double kFactor = 0.19982489;
  WorldContents contents = empty_contents();
  contents.materials = {grey_material(1), grey_material(0.4)};
  contents.objects = {grey_object(parallelogram({0, 0, 1}, {0, 1, 0}, {1, 0, 0}), 0, 5),  // faces down
                      grey_object(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), 0, 0)};
  const BatchMean share = landed_share(World(contents), 2000000);
  CHECK(agree(share.mean, share.standard_error, kFactor, {.resolution = 0.01, .degrees_of_freedom = 15}));
  CHECK(std::abs(share.mean - kFactor) < 3 * share.standard_error);
  CHECK(share.standard_error < 0.003 * kFactor);

  // The sensor sees the same on the other square, which reflects 0.6.
  contents.objects[1].materials = {1};
  const World lit(contents);
  const ImageMean mean = photograph(lit, trace_light(lit, photons(1000)), from_above(1, {0.5, 0.5, 0}), 128).mean(0);
  const double expected = 0.6 * kFactor * 5;
  INFO(mean.mean << " +- " << mean.standard_error << " against " << expected);
  CHECK(std::abs(mean.mean - expected) < 3 * mean.standard_error);
  CHECK(mean.standard_error < 0.003 * expected);
}

TEST_CASE("a sphere sends to a rectangle what it fills of its sky", "[physics][surfaces]") {
  // A Lambertian sphere is as bright from everywhere: the view factor is the solid angle over 4 pi.
  WorldContents contents = empty_contents();
  contents.materials = {grey_material(1), grey_material(0.3)};
  contents.objects = {grey_sphere({0, 0, 1.2}, 1, 0, 5),
                      grey_object(parallelogram({-2, -1.5, 0}, {4, 0, 0}, {0, 3, 0}), 0, 0)};
  const double a = 2, b = 1.5, h = 1.2;
  const double factor = 4 * std::atan(a * b / (h * std::sqrt(a * a + b * b + h * h))) / (4 * kPi);
  const BatchMean share = landed_share(World(contents), 2000000);
  CHECK(std::abs(share.mean - factor) < 3 * share.standard_error);
  CHECK(share.standard_error < 0.003 * factor);
  // Seen from below the sphere, E = pi L cos(angle) (R / d)^2: looked at in one point away from its foot.
  contents.objects[1].materials = {1};
  const World lit(contents);
  const Vec3d at(1.5, 1.0, 0);
  const double d2 = at.length2() + h * h;
  const double expected = 0.7 * 5 * h / std::sqrt(d2) / d2;
  const Light light;
  const RayRadiance seen =
      ray_radiance(lit, light, {at + Vec3d(0.2, 0, 0.1), Vec3d(-0.2, 0, -0.1).normalized(), 0, kInfinity}, 400000);
  CHECK(std::abs(seen.mean - expected) < 3 * seen.error);
  CHECK(seen.error < 0.003 * expected);
}

TEST_CASE("a Lambertian plane under sun, moon and a uniform sky has its exact radiance", "[physics][surfaces]") {
  WorldContents contents = empty_contents(0.7);
  contents.materials = {grey_material(0.4)};
  contents.objects = {grey_object(parallelogram({-50, -50, 0}, {100, 0, 0}, {0, 100, 0}), 0, 0.3)};
  contents.sun = Sun{Vec3d(0.3, -0.5, 0.8).normalized(), {5}, 0.0093};
  contents.moon = Sun{Vec3d(-0.3, -0.5, 0.4).normalized(), {1.5}, 0.009};
  const World world(contents);
  const double irradiance = 5 * contents.sun->toward.z + 1.5 * contents.moon->toward.z + kPi * 0.7;
  const double expected = 0.6 / kPi * irradiance + 0.4 * 0.3;
  const Film film = photograph(world, trace_light(world, photons(20000)), from_above(2, {0, 0, 0}), 16);
  for (const float value : film.values(0, Film::Value::radiance))
    CHECK(double(value) == Approx(expected).epsilon(1e-4));
}

TEST_CASE("a mirror shows the exact radiance of what it mirrors", "[physics][surfaces]") {
  WorldContents contents = empty_contents(0.5);
  contents.materials = {grey_material(0.2, 1), grey_material(0.9)};
  contents.objects = {grey_object(parallelogram({-5, -5, 0}, {10, 0, 0}, {0, 10, 0}), 0, 2),
                      grey_sphere({0, 0, 3}, 1, 1, 8)};
  contents.sun = Sun{Vec3d(3, 0, 1).normalized(), {5}, 0.05};
  const World world(contents);
  RadianceSettings settings;
  settings.parts.sun = settings.parts.sky = settings.parts.surfaces = false;  // the ball reflects nothing then
  const auto seen = [&](const Vec3d& toward_mirror) {
    const Vec3d d = toward_mirror.normalized();
    return ray_radiance(world, {}, {-2.0 * d, d, 0, kInfinity}, 1, settings).mean;
  };
  CHECK(seen({0, 0.01, -1}) == Approx(0.2 * 2 + 0.8 * 0.9 * 8).epsilon(1e-12));
  CHECK(seen({0, 1, -1}) == Approx(0.2 * 2 + 0.8 * 0.5).epsilon(1e-12));
  CHECK(seen({3, 0, -1}) == Approx(0.2 * 2 + 0.8 * (0.5 + world.suns()[0].radiance(0))).epsilon(1e-12));
  // Without mirrors to follow it is as bright as chalk.
  settings.specular_depth = 0;
  CHECK(seen({0, 1, -1}) == Approx(0.2 * 2).epsilon(1e-12));
}

TEST_CASE("a wall through a cloud keeps its sides apart", "[physics][surfaces]") {
  for (const bool wall : {true, false}) {
    WorldContents contents = grey_contents(rough_wish(0.9));
    contents.sky = {0};
    contents.beams.push_back({Vec3d(0.8, 1.6, 7), Vec3d(0, 0, -1), 0.7, {50}});
    contents.materials = {grey_material(1), grey_material(0.3)};
    if (wall) {
      Object sheet = grey_object(parallelogram({1.63, -9, -9}, {0, 18, 0}, {0, 0, 18}), 0, 0);
      sheet.double_sided = true;
      contents.objects = {sheet};
    }
    // A floor that reflects, on both sides.
    contents.objects.push_back(grey_object(parallelogram({-9, -9, -0.3}, {18, 0, 0}, {0, 18, 0}), 1, 0));
    const World world(contents);
    const Light light = trace_light(world, photons(200000));
    CHECK(light.maps[0].volume.size() > 10000);
    const Ray dark{{1.9, 1.6, 6}, Vec3d(0, 0, -1), 0, kInfinity};
    const Ray bright{{1.3, 1.6, 6}, Vec3d(0, 0, -1), 0, kInfinity};
    CHECK(ray_radiance(world, light, bright, 100).mean > 0.1);
    if (wall) {
      CHECK(ray_radiance(world, light, dark, 400).mean == 0);
    } else {
      CHECK(ray_radiance(world, light, dark, 400).mean > 0.1);
    }
  }
}

namespace {

/// A floor, a block and a ball that reflect and emit, under a sun; a cloud may stand among them.
WorldContents yard(const Vec3d& shift = Vec3d(0)) {
  WorldContents contents = empty_contents(0.4);
  contents.materials = {grey_material(0.5), grey_material(0.3, 0.6), grey_material(0.8)};
  contents.objects = {grey_object(parallelogram(Vec3d(-20, -20, 0), {40, 0, 0}, {0, 40, 0}), 0, 1),
                      grey_object(box_mesh({-2, -1, 0}, {-0.5, 1, 1.5}, false), 1, 4),
                      grey_sphere({1.5, 0, 0.8}, 0.8, 2, 6)};
  for (Object& object : contents.objects) {
    for (int axis = 0; axis < 3; ++axis) object.local_to_world[3][axis] += shift[axis];
  }
  contents.sun = Sun{Vec3d(0.3, -0.5, 0.8).normalized(), {5}, 0.0093};
  return contents;
}

CameraSettings yard_camera(const Vec3d& shift = Vec3d(0)) {
  CameraSettings camera;
  camera.position_m = shift + Vec3d(1, -9, 3);
  camera.look_at_m = shift + Vec3d(0, 0, 0.5);
  camera.fov_deg = 40;
  camera.resolution = {40, 30};
  return camera;
}

}  // namespace

TEST_CASE("a cloud without extinction changes no pixel by a bit", "[physics][surfaces]") {
  CloudWish nothing;
  nothing.extinction = 0;
  nothing.albedo = 0.5;
  nothing.source = 4;
  nothing.corner_m = {-8, -8, 0};
  std::vector<float> before;
  for (const bool cloud : {false, true}) {
    WorldContents contents = yard();
    if (cloud) contents.clouds.push_back(make_cloud(nothing));
    const World world(contents);
    const Film film = photograph(world, trace_light(world, photons(100000)), yard_camera(), 4);
    const auto values = film.values(0, Film::Value::radiance);
    if (cloud) CHECK(std::equal(values.begin(), values.end(), before.begin()));
    before.assign(values.begin(), values.end());
  }
}

TEST_CASE("five thousand kilometres from the origin the picture is the same", "[physics][surfaces]") {
  std::vector<float> here;
  CloudWish smoke = rough_wish(0.6, 0, 2);
  for (const Vec3d& shift : {Vec3d(0), Vec3d(5e6, 1e4, 0)}) {
    WorldContents contents = yard(shift);
    smoke.corner_m = shift + Vec3d(-1, -3, 0.2);
    contents.clouds.push_back(make_cloud(smoke));
    const World world(contents);
    const Film film = photograph(world, trace_light(world, photons(100000)), yard_camera(shift), 4);
    const auto values = film.values(0, Film::Value::radiance);
    if (here.empty()) {
      here.assign(values.begin(), values.end());
      continue;
    }
    double worst = 0, squares = 0;
    for (std::size_t i = 0; i < here.size(); ++i) {
      const double error = std::abs(double(values[i]) - double(here[i])) / double(here[i]);
      worst = std::max(worst, error);
      squares += error * error / static_cast<double>(here.size());
    }
    CHECK(std::sqrt(squares) < 1e-5);
    CHECK(worst < 1e-4);
  }
}

TEST_CASE("air dims and glows between sensor and surface, and leaves the sky as it is", "[physics][surfaces]") {
  WorldContents contents = yard();
  contents.atmosphere = Atmosphere{{0.02}, {3}};
  contents.materials = {grey_material(1)};
  for (Object& object : contents.objects) object.materials = {0};
  const World world(contents);
  const Ray down{{10, 10, 30}, {0, 0, -1}, 0, kInfinity};
  CHECK(ray_radiance(world, {}, down, 1).mean == Approx(std::exp(-0.6) * 1 + (1 - std::exp(-0.6)) * 3).epsilon(1e-12));
  const Ray up{{10, 10, 30}, Vec3d(0, 0.1, 0.99).normalized(), 0, kInfinity};
  CHECK(ray_radiance(world, {}, up, 1).mean == 0.4);
  // A thick cloud as warm as the air, in front of floor or sky, is as bright as both.
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.source = 3;
  wish.extinction = 5;
  wish.corner_m = {6, 6, 10};
  contents.clouds.push_back(make_cloud(wish));
  const World cloudy(contents);
  CHECK(ray_radiance(cloudy, {}, down, 1).mean == Approx(3).epsilon(1e-9));
  CloudWish thin_wish = wish;
  thin_wish.source = 0;
  thin_wish.extinction = 0.05;
  // A thin one that is cold: what it hides of the air's glow is missing.
  contents.clouds.back() = make_cloud(thin_wish);
  const World thin(contents);
  double expected = 0;
  const double k = 0.05, s = 0.02;
  const auto path = [&](double from, double to, double T) {  // the air's glow where the cloud leaves T
    return T * 3 * (std::exp(-s * from) - std::exp(-s * to));
  };
  expected += path(0, 12, 1);
  expected += 3 * s / (s + k) * std::exp(-s * 12) * (1 - std::exp(-(s + k) * 8));
  expected += path(20, 30, std::exp(-0.4)) + std::exp(-0.4 - 0.6) * 1;
  CHECK(ray_radiance(thin, {}, down, 1).mean == Approx(expected).epsilon(1e-6));
}

TEST_CASE("a net lets its share through, of light and of sight", "[physics][surfaces]") {
  WorldContents contents = empty_contents(2);
  contents.materials = {grey_material(1), grey_material(0.5)};
  contents.materials[0].permeable = 0.3;
  Object net = grey_object(parallelogram({-9, -9, 1}, {18, 0, 0}, {0, 18, 0}), 0, 5);
  net.double_sided = true;
  contents.objects = {net, grey_object(parallelogram({-0.05, -0.05, 0}, {0.1, 0, 0}, {0, 0.1, 0}), 1, 0)};
  const World world(contents);
  // Under the net: its own light on 70 %, the sky on the rest; beside it, 1.8 % of the floor's hemisphere,
  // the sky. A square of half side a, a height of 1 above: 4 a / (pi sqrt(1 + a^2)) atan(a / sqrt(1 + a^2)).
  const double root = std::sqrt(1 + 81.0);
  const double filled = 4 / kPi * 9 / root * std::atan(9 / root);
  const double floor = 0.5 * (filled * (0.7 * 5 + 0.3 * 2) + (1 - filled) * 2);
  const RayRadiance under = ray_radiance(world, {}, {{0, 0, 0.5}, {0, 0, -1}, 0, kInfinity}, 200000);
  CHECK(agree(under.mean, under.error, floor, {.resolution = 0.02}));
  const RayRadiance above = ray_radiance(world, {}, {{0, 0, 5}, {0, 0, -1}, 0, kInfinity}, 200000);
  CHECK(agree(above.mean, above.error, 0.7 * 5 + 0.3 * floor, {.resolution = 0.02}));
}

TEST_CASE("the surface map holds what the path of light says: a second reflection", "[physics][surfaces]") {
  // In a closed box of reflectance r that emits e B everywhere, each generation of light is r times the
  // last: direct light gives r e B, the map the rest of (1 - e) B.
  WorldContents contents = empty_contents();
  contents.materials = {grey_material(0.4)};
  contents.objects = {grey_object(box_mesh({0, 0, 0}, {1, 2, 3}, true), 0, 5)};
  const World world(contents);
  const Light light = trace_light(world, photons(1000000));
  const auto only = [&](bool RadianceParts::*part) {
    RadianceSettings settings;
    settings.parts = {false, true, false, false, false, false, false, false};
    settings.parts.*part = true;
    Moments seen;
    Stream random(1, 0, 0);
    for (int i = 0; i < 400; ++i) {
      const double u = random.uniform();
      const Vec3d d = uniform_direction(u, random.uniform());
      seen.add(ray_radiance(world, light, {{0.3, 0.7, 1.1}, d, 0, kInfinity}, 20, settings,
                            static_cast<std::uint64_t>(20 * i))
                   .mean);
    }
    return seen;
  };
  CHECK(only(&RadianceParts::background).mean() == Approx(0.4 * 5).epsilon(1e-12));
  const Moments direct = only(&RadianceParts::surfaces);
  CHECK(agree(direct.mean(), direct.standard_error(), 0.6 * 0.4 * 5, {.resolution = 0.03}));
  const Moments map = only(&RadianceParts::map);
  CHECK(agree(map.mean(), map.standard_error(), 0.36 * 5, {.resolution = 0.1}));
}

TEST_CASE("a small cloud over wide land takes in what it gives off where all is as warm", "[physics][surfaces]") {
  // By reciprocity: in a black room of radiance B the cloud absorbs of outside light what leaves it of its
  // own. Land, a plate in and a block beside the cloud, a net above and the sky are all at B.
  WorldContents contents = grey_contents(rough_wish(0.5, 0.3, kRadiance));
  contents.sky = {kRadiance};
  contents.materials = {grey_material(1), grey_material(0.6, 0.4), grey_material(0.8)};
  contents.materials[2].permeable = 0.5;
  contents.objects = {grey_object(parallelogram({-100, -100, -1}, {200, 0, 0}, {0, 200, 0}), 0, kRadiance),
                      grey_object(parallelogram({0.3, 0.4, 1.3}, {2, 0, 0.7}, {0, 2, 0.4}), 1, kRadiance),
                      grey_object(box_mesh({20, 1, -1}, {30, 9, 12}, false), 1, kRadiance),
                      grey_object(parallelogram({-2, -2, 4}, {7, 0, 0}, {0, 7, 0}), 2, kRadiance)};
  contents.objects[1].double_sided = contents.objects[3].double_sided = true;
  const World world(contents);
  const auto of_batches = [](const BatchTally& tally, double scale = kBatches) {
    BatchTally batches = tally;
    for (double& value : batches) value *= scale;
    return batch_mean(batches);
  };
  TraceSettings settings = photons(400000);
  settings.sources = {true, false, false, false, false, false, false};
  const EnergyTally own = trace_light(world, settings).bands[0].energy;
  BatchTally left;
  for (std::size_t b = 0; b < left.size(); ++b) left[b] = own.escaped[b] + own.surface[b];
  settings.sources = {false, true, true, true, true, true, true};
  settings.photons = 4000000;
  const EnergyTally outside = trace_light(world, settings).bands[0].energy;
  const BatchMean gives = of_batches(left), takes = of_batches(outside.absorbed);
  INFO("gives " << gives.mean << " +- " << gives.standard_error << ", takes " << takes.mean << " +- "
                << takes.standard_error);
  CHECK(agree(takes.mean, takes.standard_error, gives.mean,
              {.resolution = 0.1, .reference_error = gives.standard_error, .degrees_of_freedom = 15}));
}
