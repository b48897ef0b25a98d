// The World: placement, overlapping media, wrapping, and what lies beyond the clouds.
#include "photon/world/world.h"

#include <catch2/catch.hpp>

#include "octree/base/error.h"
#include "photon/world/world_walk.h"
#include "tests/photon/world/noisy_worlds.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

/// Two channels, three media, of which two share a channel.
Cloud mixed_cloud() {
  const auto field = [](int channel, const Vec3i& v) { return static_cast<float>(1 + channel + v.x); };
  Cloud cloud;
  cloud.name = "mixed";
  BuildSettings settings;
  settings.tolerance = 0;
  cloud.octree = std::make_shared<const Octree>(
      build_octree(field_stream(Box3i(Vec3i(0), Vec3i(8)), {"a", "b"}, field), settings).first);
  cloud.media.push_back({0, {0.1}, {0.5}, {}});
  cloud.media.push_back({1, {0.2}, {0.25}, {}});
  cloud.media.push_back({1, {0.3}, {1.0}, {}});
  cloud.source = {2.0};
  cloud.emission = {0.7};
  return cloud;
}

}  // namespace

TEST_CASE("a point is found through the cloud's placement and its grid", "[photon][world]") {
  Cloud cloud = make_cloud(noisy());
  cloud.local_to_world = placement({4, -3, 2}, {0.3, -1.1, 2.0}, 1.7);
  const World world = world_of({cloud});
  Stream random(1, 0, 0);
  for (int i = 0; i < 200; ++i) {
    const Vec3d index(11 * random.uniform(), 9 * random.uniform(), 7 * random.uniform());
    const Vec3d x = transform_point(cloud.local_to_world, 0.5 * index);
    CHECK((world.index_point(0, x) - index).length() < 1e-12);
    const Vec3i voxel(static_cast<int>(index.x), static_cast<int>(index.y), static_cast<int>(index.z));
    CHECK(SpectralWorld(world, 0).at(x).extinction == Approx(0.4 * noise_density(voxel)).epsilon(1e-6));
  }
  CHECK(SpectralWorld(world, 0).at(transform_point(cloud.local_to_world, Vec3d(-0.01, 1, 1))).extinction == 0);
  // The bounds hold every corner and no more.
  Box3d corners;
  for (int c = 0; c < 8; ++c) {
    corners.extendBy(transform_point(cloud.local_to_world, Vec3d(5.5 * (c & 1), 4.5 * ((c >> 1) & 1), 3.5 * (c >> 2))));
  }
  CHECK((world.bounds().min - corners.min).length() < 1e-9);
  CHECK((world.bounds().max - corners.max).length() < 1e-9);
}

TEST_CASE("coefficients of overlapping media and clouds add", "[photon][world]") {
  CloudWish other;
  other.voxels = Vec3i(8);
  other.extinction = 0.6;
  other.albedo = 0.5;
  other.source = 5;
  const World world = world_of({mixed_cloud(), make_cloud(other)});
  // Voxel x = 2: channel a is 3, channel b is 4.
  const double extinction = 3 * 0.1 + 4 * 0.2 + 4 * 0.3;
  const double scattering = 3 * 0.1 * 0.5 + 4 * 0.2 * 0.25 + 4 * 0.3;
  const LocalOptics here = SpectralWorld(world, 0).at({2.5, 4, 4});
  CHECK(here.extinction == Approx(extinction + 0.6));
  CHECK(here.scattering == Approx(scattering + 0.3));
  CHECK(here.emission == Approx((extinction - scattering) * 2 + 0.7 * 3 + 0.3 * 5));
  CHECK(SpectralWorld(world, 0).optics(0).extinction_weights()[0] == Approx(0.1));
  CHECK(SpectralWorld(world, 0).optics(0).extinction_weights()[1] == Approx(0.5));
  CHECK(SpectralWorld(world, 0).scatters());
  CHECK(SpectralWorld(world, 0).emits());
  const double depth = scalar_depth(world, {{2.5, 4, -1}, {0, 0, 1}, 0, kInfinity});
  CHECK(depth == Approx(8 * (extinction + 0.6)));
}

TEST_CASE("the source is uniform only where it is one number in every cloud", "[photon][world]") {
  CloudWish wish;
  wish.source = 4;
  wish.albedo = 0.25;
  CHECK(*SpectralWorld(world_of({make_cloud(wish)}), 0).uniform_source() == Approx(3));
  CHECK(*SpectralWorld(world_of({make_cloud(wish), make_cloud(wish)}), 0).uniform_source() == Approx(3));
  CloudWish hotter = wish;
  hotter.source = 5;
  CHECK(!SpectralWorld(world_of({make_cloud(wish), make_cloud(hotter)}), 0).uniform_source());
  CloudWish paler = wish;
  paler.albedo = 0.5;
  CHECK(!SpectralWorld(world_of({make_cloud(wish), make_cloud(paler)}), 0).uniform_source());
  CHECK(!SpectralWorld(world_of({mixed_cloud()}), 0).uniform_source());
  CHECK(!SpectralWorld(world_of({}), 0).uniform_source());
  // A temperature channel varies.
  Cloud warm = mixed_cloud();
  warm.source = {};
  warm.emission = {};
  warm.temperature = {1, 100, 0, 0};
  WorldContents contents;
  contents.bands.emplace_back("ir", 8.0, 12.0);
  contents.clouds = {warm};
  const World world(std::move(contents));
  CHECK(!SpectralWorld(world, 0).uniform_source());
  const double absorption = 3 * 0.1 * 0.5 + 4 * 0.2 * 0.75;
  CHECK(SpectralWorld(world, 0).at({2.5, 4, 4}).emission ==
        Approx(absorption * world.bands()[0].planck(0, 400)).epsilon(1e-8));
}

TEST_CASE("behind the clouds are the sky and the sun's disc with its irradiance", "[photon][world]") {
  WorldContents contents;
  contents.bands.emplace_back("grey");
  contents.sky = {0.5};
  const Vec3d toward = Vec3d(1, 2, 2).normalized();
  contents.sun = Sun{toward, {7}, 0.02};
  const World world(std::move(contents));
  CHECK(SpectralWorld(world, 0).background(direction_about(toward, std::cos(0.0099), 1)) ==
        0.5 + world.suns()[0].radiance(0));
  CHECK(SpectralWorld(world, 0).background(direction_about(toward, std::cos(0.0101), 1)) == 0.5);
  CHECK(SpectralWorld(world, 0).background(toward, false) == 0.5);
  CHECK(SpectralWorld(world, 0).background(-toward) == 0.5);
  // Radiance times the projected solid angle is the irradiance on a plane that faces the sun.
  double irradiance = 0;
  const int steps = 1000;
  for (int i = 0; i < steps; ++i) {
    const double angle = 0.01 * (i + 0.5) / steps;
    irradiance += world.suns()[0].radiance(0) * 2 * kPi * std::sin(angle) * std::cos(angle) * 0.01 / steps;
  }
  CHECK(irradiance == Approx(7).epsilon(1e-5));
  WorldContents point;
  point.bands.emplace_back("grey");
  point.sun = Sun{toward, {7}, 0};
  const World without_disc(std::move(point));
  CHECK(SpectralWorld(without_disc, 0).background(toward) == 0);
  CHECK(SpectralWorld(without_disc, 0).sky() == 0);
}

TEST_CASE("an empty cloud and no cloud at all leave rays as they are", "[photon][world]") {
  CloudWish wish;
  wish.density = [](const Vec3i&) { return 0.0; };
  CloudWish periodic = wish;
  periodic.period_m = {20, 20};
  for (const World& world :
       {world_of({}, 1.5), world_of({make_cloud(wish)}, 1.5), world_of({make_cloud(periodic)}, 1.5)}) {
    const Ray ray{{-5, 4, 4}, {1, 0, 0}, 0, kInfinity};
    double depth = -1;
    SpectralWorld(world, 0).optical_depths({&ray, 1}, {&depth, 1});
    CHECK(depth == 0);
    const Flight flight{ray, 1};
    FreePath end;
    SpectralWorld(world, 0).reach_depths({&flight, 1}, {&end, 1});
    CHECK(!end.collided);
    CHECK(SpectralWorld(world, 0).at({4, 4, 4}).extinction == 0);
    CHECK(world.bounds().isEmpty());
    CHECK(!WorldWalk({world, 0}, ray).next());
    CHECK(SpectralWorld(world, 0).background({1, 0, 0}) == 1.5);
  }
}

TEST_CASE("a World that kernels could not serve is refused with cause and remedy", "[photon][world]") {
  std::vector<Cloud> many(65, make_cloud({}));
  CHECK_THROWS_AS(world_of(many), InputError);
  many.pop_back();
  CHECK_NOTHROW(world_of(many));
  CloudWish narrow;
  narrow.period_m = {16, 15.9};
  CHECK_THROWS_AS(world_of({make_cloud(narrow)}), InputError);
  narrow.period_m = {16, 0};
  CHECK_NOTHROW(world_of({make_cloud(narrow)}));
  Cloud flat = make_cloud({});
  flat.local_to_world = placement(Vec3d(0), Vec3d(0), 0);
  CHECK_THROWS_AS(world_of({flat}), InputError);
  for (const int channels : {16, 17}) {
    std::vector<std::string> names;
    for (int c = 0; c < channels; ++c) names.push_back("c" + std::to_string(c));
    BuildSettings settings;
    settings.tolerance = 0;
    Cloud wide = make_cloud({});
    wide.octree = std::make_shared<const Octree>(
        build_octree(field_stream(Box3i(Vec3i(0), Vec3i(8)), names, [](int, const Vec3i&) { return 1.0f; }), settings)
            .first);
    if (channels == 16) {
      CHECK_NOTHROW(world_of({wide}));
    } else {
      CHECK_THROWS_AS(world_of({wide}), InputError);
    }
  }
}

TEST_CASE("a point is wrapped into the first cell and has the same optics there", "[photon][world]") {
  CloudWish wish = noisy();
  wish.period_m = {6, 5};
  Cloud cloud = make_cloud(wish);
  cloud.local_to_world = placement({1, 2, 3}, {0, 0, 0.6}, 2);
  const World world = world_of({cloud});
  CHECK(world.periodic());
  CHECK(world.period()[0].length() == Approx(12));
  CHECK(world.period()[1].length() == Approx(10));
  Stream random(2, 0, 0);
  int met = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3d x(200 * random.uniform() - 100, 200 * random.uniform() - 100, 3 + 7 * random.uniform());
    const Vec3d wrapped = world.wrap(x);
    const Vec3d local = transform_point(world.frame(0).world_to_local, wrapped);
    CHECK((local.x > -1e-9 && local.x < 6 + 1e-9 && local.y > -1e-9 && local.y < 5 + 1e-9));
    const Vec3d moved = wrapped - x;
    for (const Vec3d& period : world.period()) {
      const double count = moved.dot(period) / period.length2();
      CHECK(std::abs(count - std::round(count)) < 1e-9);
    }
    CHECK(SpectralWorld(world, 0).at(wrapped).extinction == SpectralWorld(world, 0).at(x).extinction);
    met += SpectralWorld(world, 0).at(x).extinction > 0;
  }
  CHECK(met > 100);
}

TEST_CASE("the map's frame is rigid, and extinction there is that of the World", "[photon][world]") {
  CloudWish wish = noisy();
  Cloud plain = make_cloud(wish);
  plain.local_to_world = placement({100, 2, 3}, {0.1, 0.2, 0.6}, 2);
  wish.period_m = {6, 5};
  Cloud periodic = make_cloud(wish);
  periodic.local_to_world = plain.local_to_world;
  for (const World& world : {world_of({plain, make_cloud(noisy())}), world_of({periodic})}) {
    CHECK(linear_determinant(world.world_to_map()) == Approx(1));
    CHECK(world.map_period() == (world.periodic() ? Vec3d(12, 10, 0) : Vec3d(0)));
    // The cell's sides are the axes.
    for (std::size_t axis = 0; axis < 2 && world.periodic(); ++axis) {
      Vec3d side(0);
      side[static_cast<int>(axis)] = world.map_period()[static_cast<int>(axis)];
      CHECK((transform_direction(world.world_to_map(), world.period()[axis]) - side).length() < 1e-12);
    }
    int met = 0;
    for (const Ray& ray : rays_about(world, 3000)) {
      const Vec3d x = ray.origin;  // every third is in the bounds
      const double here = SpectralWorld(world, 0).at(x).extinction;
      met += here > 0;
      CHECK(SpectralWorld(world, 0).extinction_in_map(transform_point(world.world_to_map(), x)) ==
            Approx(here).margin(1e-12));
    }
    CHECK(met > 10);
  }
}
