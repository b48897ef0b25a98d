// Every source of photons: its power, where they start, where they go, and what they weigh.
#include "photon/trace/emission.h"

#include <catch2/catch.hpp>

#include "tests/support/agree.h"
#include "tests/support/chi_square.h"
#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

constexpr int kPhotons = 200000;

/// Independent photons; `each` sees them.
template <class F>
Moments emit_many(const PhotonEmitter& emitter, int count, F&& each, std::uint64_t seed = 1) {
  Stream random(seed, 0, 0);
  Moments power;
  PhotonEmitter::Cache cache;
  for (int i = 0; i < count; ++i) {
    std::array<double, 8> u;
    for (double& x : u) x = random.uniform();
    const EmittedPhoton photon = emitter.emit(u, cache);
    power.add(photon.power);
    each(photon);
  }
  return power;
}

World empty_world(double sky, std::optional<Sun> sun) {
  CloudWish wish;
  wish.voxels = {8, 16, 8};
  wish.extinction = 1e-9;
  wish.corner_m = {1, 2, 3};
  WorldContents contents = grey_contents(wish, sky);
  contents.sun = sun;
  return World(std::move(contents));
}

/// Where the photon's ray enters the sphere of radius r about the middle: t, or infinity.
double entry(const EmittedPhoton& photon, const Vec3d& middle, double r) {
  const Vec3d o = photon.position - middle;
  const double b = -o.dot(photon.direction);
  const double disc = r * r - (o + b * photon.direction).length2();
  return disc > 0 ? b - std::sqrt(disc) : kInfinity;
}

double rough_source(const Vec3i& v) { return voxel_noise(4, v, 1) < 0.5 ? 0.0 : voxel_noise(4, v, 2); }

}  // namespace

TEST_CASE("voxels emit in proportion to their emission and evenly inside", "[photon][emission]") {
  CloudWish wish;
  wish.voxels = {12, 8, 9};  // more than one brick
  wish.density = rough_source;
  wish.extinction = 1e-3;
  wish.albedo = 0.25;
  wish.source = 3;
  wish.voxel_m = 0.5;
  WorldContents contents = grey_contents(wish);
  contents.clouds[0].local_to_world = placement({5, 6, 7}, {0.4, -0.3, 1.2}, 2);
  const World world(std::move(contents));
  const PhotonEmitter emitter(world, 0);
  double density = 0;
  std::vector<double> expected(12 * 8 * 9), observed(expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    expected[i] = rough_source(Vec3i(static_cast<int>(i % 12), static_cast<int>(i / 12 % 8), static_cast<int>(i / 96)));
    density += expected[i];
  }
  // 4 pi k_a B V in world metres.
  const double power = 4 * kPi * 1e-3 * 0.75 * 3 * density;
  CHECK(emitter.power() == Approx(power).epsilon(1e-6));
  for (double& e : expected) e *= kPhotons / density;
  std::vector<double> inside(4 * 4 * 4);
  std::vector<double> directions_z(20);
  const Moments weights = emit_many(emitter, kPhotons, [&](const EmittedPhoton& photon) {
    const Vec3d index = world.index_point(0, photon.position);
    const Vec3i v(static_cast<int>(std::floor(index.x)), static_cast<int>(std::floor(index.y)),
                  static_cast<int>(std::floor(index.z)));
    REQUIRE((v.x >= 0 && v.x < 12 && v.y >= 0 && v.y < 8 && v.z >= 0 && v.z < 9));
    ++observed[static_cast<std::size_t>(v.x + 12 * v.y + 96 * v.z)];
    const Vec3d f = index - Vec3d(v);
    ++inside[static_cast<std::size_t>(4 * f.x) + 4 * static_cast<std::size_t>(4 * f.y) +
             16 * static_cast<std::size_t>(4 * f.z)];
    CHECK_FALSE(photon.in_direct_set);
  });
  CHECK(chi_square(observed, expected));
  CHECK(chi_square(inside, std::vector<double>(64, kPhotons / 64.0)));
  // Uniform over voxels, whatever they emit, fails.
  CHECK(!chi_square(observed, std::vector<double>(expected.size(), kPhotons / double(expected.size()))));
  // A thin cloud: all weigh alike.
  CHECK(weights.mean() == Approx(power).epsilon(1e-6));
  CHECK(std::sqrt(weights.variance()) < 1e-6 * power);
  Stream random(3, 0, 0);
  PhotonEmitter::Cache cache;
  const auto draw = [&] {
    std::array<double, 8> u;
    for (double& x : u) x = random.uniform();
    return emitter.emit(u, cache).direction;
  };
  CHECK(chi_square_directions(
      draw, [](const Vec3d&) { return 1 / (4 * kPi); }, kPhotons));
}

TEST_CASE("uniform blocks emit from every part, and several clouds by their power", "[photon][emission]") {
  CloudWish large;
  large.voxels = Vec3i(32);  // one leaf of level 5
  large.extinction = 1e-3;
  large.source = 1;
  CloudWish small = large;
  small.voxels = Vec3i(8);
  small.corner_m = {100, 0, 0};
  small.source = 32;
  WorldContents contents = grey_contents(large);
  contents.clouds.push_back(make_cloud(small));
  const World world(std::move(contents));
  const PhotonEmitter emitter(world, 0);
  const double powers[] = {4 * kPi * 1e-3 * 32768, 4 * kPi * 1e-3 * 512 * 32};
  CHECK(emitter.power() == Approx(powers[0] + powers[1]));
  std::vector<double> octants(8);
  double of_small = 0;
  emit_many(emitter, kPhotons, [&](const EmittedPhoton& photon) {
    if (photon.position.x > 50) {
      of_small += 1;
    } else {
      const Vec3d& p = photon.position;
      ++octants[(p.x > 16 ? 1u : 0u) + (p.y > 16 ? 2u : 0u) + (p.z > 16 ? 4u : 0u)];
    }
  });
  CHECK(chi_square({of_small, kPhotons - of_small}, {kPhotons / 3.0, kPhotons * 2 / 3.0}));
  CHECK(chi_square(octants, std::vector<double>(8, (kPhotons - of_small) / 8)));
}

TEST_CASE("weights make up for the photons that a thick core is spared", "[photon][emission]") {
  CloudWish wish;
  wish.voxels = {16, 16, 8};
  wish.density = [](const Vec3i& v) { return v.x < 8 ? 100.0 : 0.01; };
  wish.source = 2;
  const World world(grey_contents(wish));
  const PhotonEmitter emitter(world, 0);
  const double thick = 4 * kPi * 100 * 2 * 1024, thin = 4 * kPi * 0.01 * 2 * 1024;
  CHECK(emitter.power() == Approx(thick + thin).epsilon(1e-6));
  Moments from_thick, from_thin;
  double many = 0;
  const Moments power = emit_many(emitter, kPhotons, [&](const EmittedPhoton& photon) {
    const bool is_thick = photon.position.x < 8;
    from_thick.add(is_thick ? photon.power : 0.0);
    from_thin.add(is_thick ? 0.0 : photon.power);
    many += is_thick ? 0 : 1;
  });
  // The thin part gets ten times its share of photons, of a tenth of the weight.
  CHECK(many / kPhotons == Approx(10 * thin / (thick + 10 * thin)).epsilon(0.1));
  CHECK(agree(from_thick.mean(), from_thick.standard_error(), thick, {.resolution = 0.001, .comparisons = 2}));
  CHECK(agree(from_thin.mean(), from_thin.standard_error(), thin, {.resolution = 0.7, .comparisons = 2}));
  CHECK(power.mean() == Approx(thick + thin).epsilon(0.001));
}

TEST_CASE("the sun fills a disc over the bounds with its irradiance", "[photon][emission]") {
  const Vec3d toward = Vec3d(1, -2, 2).normalized();
  const World world = empty_world(0, Sun{toward, {5}, 0.1});
  const PhotonEmitter emitter(world, 0);
  const double radius = 0.5 * std::sqrt(8.0 * 8 + 16 * 16 + 8 * 8);
  CHECK(emitter.power() == Approx(5 * kPi * radius * radius));
  std::vector<double> rings(10), off(10);
  const Vec3d middle(5, 10, 7);
  double inner = 0;
  emit_many(emitter, kPhotons, [&](const EmittedPhoton& photon) {
    const double cosine = -photon.direction.dot(toward);
    const double versine = 2 * std::pow(std::sin(0.025), 2);
    REQUIRE(1 - cosine <= versine * (1 + 1e-9));
    ++off[std::min<std::size_t>(9, static_cast<std::size_t>(10 * (1 - cosine) / versine))];
    // About the middle, at right angles to its own direction.
    const Vec3d o = photon.position - middle;
    const Vec3d across = o - o.dot(photon.direction) * photon.direction;
    ++rings[std::min<std::size_t>(9, static_cast<std::size_t>(10 * across.length2() / (radius * radius)))];
    inner += entry(photon, middle, 0.5 * radius) < kInfinity ? photon.power / kPhotons : 0.0;
    CHECK(photon.in_direct_set);
    CHECK(o.dot(photon.direction) < 0);
  });
  CHECK(chi_square(rings, std::vector<double>(10, kPhotons / 10.0)));
  CHECK(chi_square(off, std::vector<double>(10, kPhotons / 10.0)));
  CHECK(inner == Approx(5 * kPi * 0.25 * radius * radius).epsilon(0.02));
}

TEST_CASE("the sky sends pi L through every surface, at every angle", "[photon][emission]") {
  const World world = empty_world(0.7, {});
  const PhotonEmitter emitter(world, 0);
  const double radius = 0.5 * std::sqrt(8.0 * 8 + 16 * 16 + 8 * 8);
  CHECK(emitter.power() == Approx(4 * kPi * kPi * 0.7 * radius * radius));
  // What enters a smaller sphere, anywhere inside the bounds, is uniform over it and Lambertian.
  const Vec3d middle(6, 9, 8);
  const double r = 3;
  double entered = 0;
  int count = 0;
  std::vector<Vec3d> normals;
  std::vector<double> cosines(10);
  const Moments power = emit_many(emitter, kPhotons, [&](const EmittedPhoton& photon) {
    const double t = entry(photon, middle, r);
    CHECK(photon.in_direct_set);
    if (t == kInfinity) return;
    REQUIRE(t > 0);
    entered += photon.power / kPhotons;
    ++count;
    const Vec3d normal = (photon.position + t * photon.direction - middle) / r;
    normals.push_back(normal);
    const double cosine = -normal.dot(photon.direction);
    ++cosines[std::min<std::size_t>(9, static_cast<std::size_t>(10 * cosine * cosine))];
  });
  CHECK(power.mean() == Approx(emitter.power()));
  CHECK(entered == Approx(kPi * 0.7 * 4 * kPi * r * r).epsilon(0.03));
  CHECK(chi_square(cosines, std::vector<double>(10, count / 10.0)));
  std::size_t next = 0;
  CHECK(chi_square_directions([&] { return normals[next++]; }, [](const Vec3d&) { return 1 / (4 * kPi); }, count));
}

TEST_CASE("hot spheres emit Lambertian light from their surface; only sources are in the direct set",
          "[photon][emission]") {
  WorldContents contents;
  contents.bands.emplace_back("grey");
  contents.sources.push_back({{1, 2, 3}, 0.5, {4}});
  contents.particles.push_back({{5, 2, 3}, 0.25, {8}});
  const World world(std::move(contents));
  const PhotonEmitter emitter(world, 0);
  const double powers[] = {4 * 4 * kPi * kPi * 0.25, 8 * 4 * kPi * kPi * 0.0625};
  CHECK(emitter.power() == Approx(powers[0] + powers[1]));
  std::vector<Vec3d> normals;
  std::vector<double> cosines(10);
  double of_particle = 0;
  emit_many(emitter, kPhotons, [&](const EmittedPhoton& photon) {
    const HotSphere& sphere = world.spheres()[photon.position.x > 3 ? 1 : 0];
    of_particle += photon.position.x > 3 ? 1 : 0;
    CHECK(photon.in_direct_set == (photon.position.x < 3));
    const Vec3d normal = (photon.position - sphere.center) / sphere.radius;
    REQUIRE(normal.length() == Approx(1));
    normals.push_back(normal);
    const double cosine = normal.dot(photon.direction);
    REQUIRE(cosine >= -1e-12);
    ++cosines[std::min<std::size_t>(9, static_cast<std::size_t>(10 * cosine * cosine))];
  });
  const double share = powers[1] / (powers[0] + powers[1]);
  CHECK(chi_square({of_particle, kPhotons - of_particle}, {share * kPhotons, (1 - share) * kPhotons}));
  CHECK(chi_square(cosines, std::vector<double>(10, kPhotons / 10.0)));
  std::size_t next = 0;
  CHECK(chi_square_directions([&] { return normals[next++]; }, [](const Vec3d&) { return 1 / (4 * kPi); }, kPhotons));
}

TEST_CASE("a beam leaves its disc along its direction", "[photon][emission]") {
  WorldContents contents;
  contents.bands.emplace_back("grey");
  const Vec3d d = Vec3d(2, -1, 2).normalized();
  contents.beams.push_back({{1, 2, 3}, d, 0.5, {6}});
  const World world(std::move(contents));
  const PhotonEmitter emitter(world, 0);
  CHECK(emitter.power() == 6);
  std::vector<double> rings(10);
  emit_many(emitter, 20000, [&](const EmittedPhoton& photon) {
    CHECK(photon.direction == d);
    CHECK(photon.power == 6);
    CHECK_FALSE(photon.in_direct_set);
    const Vec3d o = photon.position - Vec3d(1, 2, 3);
    CHECK(o.dot(d) == Approx(0).margin(1e-12));
    ++rings[std::min<std::size_t>(9, static_cast<std::size_t>(10 * o.length2() / 0.25))];
  });
  CHECK(chi_square(rings, std::vector<double>(10, 2000.0)));
}

TEST_CASE("a periodic cell is lit through its upper and lower faces alone", "[photon][emission]") {
  CloudWish wish;
  wish.voxels = {8, 8, 4};
  wish.extinction = 1e-3;
  wish.period_m = {10, 12};
  WorldContents contents = grey_contents(wish, 0.7);
  const Affine place = placement({3, 1, 2}, {0, 0, 0.5}, 2);
  contents.clouds[0].local_to_world = place;
  const double zenith = 0.8;
  contents.sun = Sun{Vec3d(std::sin(zenith), 0, std::cos(zenith)), {5}, 0.05};
  const World world(std::move(contents));
  SourceSelection only_sun;
  only_sun.sky = false;
  const PhotonEmitter sun(world, 0, only_sun);
  CHECK(sun.power() == Approx(5 * std::cos(zenith) * 20 * 24));
  std::vector<double> cells(8 * 8);
  const auto place_in_face = [&](const EmittedPhoton& photon) {
    const Vec3d local = transform_point(world.frame(0).world_to_local, photon.position);
    REQUIRE((local.x >= 0 && local.x <= 10 && local.y >= 0 && local.y <= 12));
    ++cells[std::min<std::size_t>(7, static_cast<std::size_t>(local.x * 0.8)) +
            8 * std::min<std::size_t>(7, static_cast<std::size_t>(local.y * 8 / 12))];
    return local.z;
  };
  Moments power = emit_many(sun, kPhotons, [&](const EmittedPhoton& photon) {
    CHECK(place_in_face(photon) == Approx(4));
    CHECK(photon.direction.z < 0);
  });
  CHECK(chi_square(cells, std::vector<double>(64, kPhotons / 64.0)));
  CHECK(power.mean() == Approx(sun.power()).epsilon(1e-3));  // the disc is as bright as its middle
  SourceSelection only_sky;
  only_sky.sun = false;
  const PhotonEmitter sky(world, 0, only_sky);
  CHECK(sky.power() == Approx(kPi * 0.7 * 2 * 20 * 24));
  cells.assign(64, 0);
  double upper = 0;
  std::vector<double> cosines(10);
  power = emit_many(sky, kPhotons, [&](const EmittedPhoton& photon) {
    const bool top = place_in_face(photon) > 2;
    upper += top ? 1 : 0;
    CHECK((photon.direction.z < 0) == top);
    ++cosines[std::min<std::size_t>(9, static_cast<std::size_t>(10 * photon.direction.z * photon.direction.z))];
  });
  CHECK(chi_square({upper, kPhotons - upper}, {kPhotons / 2.0, kPhotons / 2.0}));
  CHECK(chi_square(cosines, std::vector<double>(10, kPhotons / 10.0)));
  CHECK(chi_square(cells, std::vector<double>(64, kPhotons / 64.0)));
  CHECK(power.mean() == Approx(sky.power()));
}

TEST_CASE("sources that are off emit nothing, and a dark World has no power", "[photon][emission]") {
  CloudWish wish;
  wish.source = 1;
  WorldContents contents = grey_contents(wish, 1);
  contents.sun = Sun{{0, 0, 1}, {1}, 0.01};
  contents.sources.push_back({{0, 0, 30}, 1, {1}});
  contents.particles.push_back({{0, 0, 40}, 1, {1}});
  contents.beams.push_back({{0, 0, -3}, {0, 0, 1}, 1, {1}});
  const World world(std::move(contents));
  const double whole = PhotonEmitter(world, 0).power();
  double sum = 0;
  for (bool SourceSelection::*source :
       {&SourceSelection::emission, &SourceSelection::sun, &SourceSelection::sky, &SourceSelection::spheres,
        &SourceSelection::particles, &SourceSelection::beams}) {
    SourceSelection one{false, false, false, false, false, false, false};
    one.*source = true;
    const double part = PhotonEmitter(world, 0, one).power();
    CHECK(part > 0);
    sum += part;
  }
  CHECK(sum == Approx(whole).epsilon(1e-12));
  CHECK(PhotonEmitter(world, 0, {false, false, false, false, false, false, false}).power() == 0);
}

TEST_CASE("faces emit exactly their power, by the cosine and from the side that shines",
          "[photon][emission][surfaces]") {
  for (const bool double_sided : {false, true}) {
    WorldContents contents = empty_contents();
    contents.materials = {grey_material(0.6)};
    Object sheet = grey_object(parallelogram({1, 2, 3}, {2, 0, 0}, {0, 3, 0}), 0, 5);
    sheet.local_to_world = placement({-4, 1, 0}, {0.4, 0.3, -0.2}, 2);
    sheet.double_sided = double_sided;
    contents.objects = {sheet};
    const World world(contents);
    const PhotonEmitter emitter(world, 0);
    const double power = kPi * 0.6 * 5 * 24 * (double_sided ? 2 : 1);
    CHECK(emitter.power() == Approx(power).epsilon(1e-12));
    const Vec3d front = transform_direction(sheet.local_to_world, Vec3d(0, 0, 1)).normalized();
    std::vector<double> cosines(20), sides(2), cells(24);
    double worst_power = 0, worst_place = 0;
    int strangers = 0;
    emit_many(emitter, kPhotons, [&](const EmittedPhoton& photon) {
      worst_power = std::max(worst_power, std::abs(photon.power / power - 1));
      const double cosine = photon.direction.dot(front);
      ++cosines[std::min<std::size_t>(19, static_cast<std::size_t>(20 * cosine * cosine))];
      ++sides[cosine > 0 ? 0 : 1];
      strangers += photon.from.surface != 0 || photon.from.face > 1 || !photon.in_direct_set || photon.from_beyond;
      const Vec3d local = transform_point(sheet.local_to_world.inverse(), photon.position) - Vec3d(1, 2, 3);
      worst_place = std::max(worst_place, std::abs(local.z));
      ++cells[std::min<std::size_t>(3, static_cast<std::size_t>(2 * std::max(0.0, local.x))) +
              4 * std::min<std::size_t>(5, static_cast<std::size_t>(2 * std::max(0.0, local.y)))];
    });
    CHECK(worst_power < 1e-12);
    CHECK(worst_place < 1e-12);
    CHECK(strangers == 0);
    CHECK(chi_square(cosines, std::vector<double>(20, kPhotons / 20.0)));
    CHECK(chi_square(cells, std::vector<double>(24, kPhotons / 24.0)));
    if (double_sided) {
      CHECK(chi_square(sides, {kPhotons / 2.0, kPhotons / 2.0}));
    } else {
      CHECK(sides[1] == 0);
    }
  }
}

TEST_CASE("what varies with angle and place over a face is made up for by weights", "[photon][emission][surfaces]") {
  WorldContents contents;
  const Band band("infrared", 8, 12, 1);
  contents.bands.push_back(band);
  Material angled = grey_material(0.9);
  angled.angle_deg = {0, 90};
  angled.angle_factor = {1, 0.2};
  contents.materials = {angled};
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh->faces = {{0, 1, 2}};
  mesh->vertex_K = {300, 600, 300};
  Object object;
  object.mesh = mesh;
  contents.objects = {object};
  const World world(contents);
  const PhotonEmitter emitter(world, 0);
  constexpr int kParts = 8;
  std::vector<Moments> by_place(kParts), by_cosine(kParts);
  const Moments power = emit_many(emitter, kPhotons, [&](const EmittedPhoton& photon) {
    const double cosine2 = photon.direction.z * photon.direction.z;
    for (int i = 0; i < kParts; ++i) {
      by_place[static_cast<std::size_t>(i)].add(static_cast<int>(kParts * photon.position.x) == i ? photon.power : 0.0);
      by_cosine[static_cast<std::size_t>(i)].add(
          std::min(static_cast<int>(kParts * cosine2), kParts - 1) == i ? photon.power : 0.0);
    }
  });
  // Integrals over strips of x, where the temperature is 300 + 300 x and the width 1 - x, and over the angle.
  std::array<double, kParts> places{}, angles{};
  double over_places = 0, over_angles = 0;
  constexpr int kSteps = 4000;
  for (int i = 0; i < kSteps; ++i) {
    const double x = (i + 0.5) / kSteps;
    const double here = band.planck(0, 300 + 300 * x) * (1 - x) / kSteps;
    places[static_cast<std::size_t>(kParts * x)] += here;
    over_places += here;
    const double emissivity = 0.9 * (1 - 0.8 * std::acos(std::sqrt(x)) / (0.5 * kPi));  // x is the cosine's square
    angles[static_cast<std::size_t>(kParts * x)] += kPi * emissivity / kSteps;
    over_angles += kPi * emissivity / kSteps;
  }
  CHECK(
      agree(power.mean(), power.standard_error(), over_places * over_angles, {.resolution = 0.02, .comparisons = 17}));
  for (std::size_t i = 0; i < kParts; ++i) {
    INFO("part " << i);
    CHECK(agree(by_place[i].mean(), by_place[i].standard_error(), places[i] * over_angles,
                {.resolution = 0.25, .comparisons = 17}));
    CHECK(agree(by_cosine[i].mean(), by_cosine[i].standard_error(), angles[i] * over_places,
                {.resolution = 0.1, .comparisons = 17}));
  }
}

TEST_CASE("a small cloud over huge terrain gets what the plain disc would send it", "[photon][emission][surfaces]") {
  CloudWish puff;
  puff.voxels = Vec3i(8);
  puff.voxel_m = 0.25;
  puff.corner_m = {10, 5, 2};
  WorldContents contents = grey_contents(puff, 0.7);
  contents.materials = {grey_material(1)};
  contents.objects = {grey_object(parallelogram({-50, -50, 0}, {100, 0, 0}, {0, 100, 0}), 0, 0)};
  const Vec3d toward = Vec3d(1, -2, 2).normalized();
  contents.sun = Sun{toward, {5}, 0.1};
  const World world(contents);
  const double radius = 0.5 * world.bounds().size().length();
  REQUIRE(radius > 70);
  struct Ball {
    Vec3d middle;
    double r;
    double resolution;
  };
  constexpr int kMany = 2000000;
  // The puff, something that the narrow disc only cuts, and something far from it.
  const Ball balls[] = {{{11, 6, 3}, 1, 0.03}, {{15, 6, 3}, 10, 0.1}, {{-20, 10, 3}, 15, 0.1}};
  for (const bool sun : {true, false}) {
    SourceSelection one{};
    one.sun = sun;
    one.sky = !sun;
    const PhotonEmitter emitter(world, 0, one);
    const double whole = sun ? 5 * kPi * radius * radius : 4 * kPi * kPi * 0.7 * radius * radius;
    CHECK(emitter.power() == Approx(whole).epsilon(1e-9));
    std::array<Moments, 3> into;
    int near = 0, beyond = 0;
    const Moments power = emit_many(emitter, kMany, [&](const EmittedPhoton& photon) {
      for (std::size_t b = 0; b < 3; ++b) {
        const double t = entry(photon, balls[b].middle, balls[b].r);
        into[b].add(t < kInfinity ? photon.power : 0.0);
        near += b == 0 && t < kInfinity;
      }
      // It starts outside of everything.
      beyond += (photon.position - world.bounds().center()).length() >= radius * (1 - 1e-9) && photon.from_beyond;
    });
    CHECK(beyond == kMany);
    CHECK(agree(power.mean(), power.standard_error(), whole, {.resolution = 0.05, .comparisons = 8}));
    for (std::size_t b = 0; b < 3; ++b) {
      INFO((sun ? "sun" : "sky") << ", ball " << b);
      const double expected = (sun ? 5 : 4 * kPi * 0.7) * kPi * balls[b].r * balls[b].r;
      CHECK(agree(into[b].mean(), into[b].standard_error(), expected,
                  {.resolution = balls[b].resolution, .comparisons = 8}));
    }
    // The plain disc would have sent it one in five thousand.
    CHECK(near > kMany / 20);
  }
}
