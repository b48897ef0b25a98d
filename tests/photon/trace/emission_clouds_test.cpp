// Photons of clouds: their power, which voxels they start in, where they go, and what they weigh.
#include <catch2/catch.hpp>

#include "photon/trace/emission.h"
#include "tests/photon/trace/emit_many.h"
#include "tests/support/agree.h"
#include "tests/support/chi_square.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

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
  const PhotonEmitter emitter({world, 0});
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
  const PhotonEmitter emitter({world, 0});
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
  const PhotonEmitter emitter({world, 0});
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
