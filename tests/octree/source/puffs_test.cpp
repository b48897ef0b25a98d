// Puffs: mass, determinism, temperature, the ground, and refusals.
#include "octree/source/puffs.h"

#include <tbb/global_control.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "octree/base/error.h"
#include "octree/source/eddies.h"
#include "tests/support/dense_stream.h"

using namespace obscura;
using obscura::test::Dense;

namespace {

PuffSettings small_screen() {
  PuffSettings settings;
  settings.sources = {{{0, 0, 0}, 300, 30, 600}, {{0, 4, 0}, 100, 10, 700}};
  settings.wind_m_s = {2, 0, 0};
  settings.age_s = 8;
  settings.voxel_m = 0.4;
  return settings;
}

}  // namespace

TEST_CASE("puffs hold the mass released by their age", "[octree][puffs]") {
  PuffSettings settings = small_screen();
  for (const double age : {4.0, 8.0, 14.0}) {
    settings.age_s = age;
    const double released = 300 * age / 30 + 100 * std::min(1.0, age / 10);
    const Dense dense(puffs_stream(settings));
    CHECK(dense.sum(0) * std::pow(settings.voxel_m, 3) == Approx(released).epsilon(1e-6));
    CHECK(dense.twice() == 0);
    CHECK(dense.outside() == 0);
  }
}

TEST_CASE("a burst of no duration releases all its mass", "[octree][puffs]") {
  PuffSettings settings = small_screen();
  settings.sources = {{{0, 0, 5}, 50, 0, 300}};
  settings.wind_m_s = {0, 0, 0};
  settings.age_s = 3;
  CHECK(Dense(puffs_stream(settings)).sum(0) * std::pow(0.4, 3) == Approx(50).epsilon(1e-6));
}

TEST_CASE("puffs are the same bits for any number of threads", "[octree][puffs]") {
  std::vector<float> reference;
  for (const std::size_t threads : {1u, 2u, 7u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Dense dense(puffs_stream(small_screen()));
    if (reference.empty()) reference = dense.values(0);
    CHECK(dense.values(0) == reference);
  }
  PuffSettings other = small_screen();
  other.seed = 2;
  CHECK(Dense(puffs_stream(other)).values(0) != reference);
}

TEST_CASE("smoke cools towards the air and never leaves the range of its sources", "[octree][puffs]") {
  PuffSettings settings = small_screen();
  const Dense dense(puffs_stream(settings));
  float hottest = 0;
  double far_excess = 0, far_mass = 0;
  const Vec3i n = dense.size();
  for (int z = 0; z < n.z; ++z)
    for (int y = 0; y < n.y; ++y)
      for (int x = 0; x < n.x; ++x) {
        const float density = dense.at(0, {x, y, z});
        if (density == 0) continue;
        const float kelvin = dense.at(1, {x, y, z});
        REQUIRE(kelvin >= 288.0f);
        REQUIRE(kelvin <= 700.0f);
        hottest = std::max(hottest, kelvin);
        if (x > 3 * n.x / 4) far_excess += density * (kelvin - 288), far_mass += density;
      }
  CHECK(hottest > 350);
  REQUIRE(far_mass > 0);
  CHECK(far_excess / far_mass < 30);
}

TEST_CASE("smoke drifts with the wind and rises", "[octree][puffs]") {
  PuffSettings settings = small_screen();
  settings.sources = {{{0, 0, 0}, 100, 1, 600}};
  const auto centre = [&](const PuffSettings& s) {
    const VoxelStream stream = puffs_stream(s);
    const Dense dense(stream);
    Vec3d sum(0);
    const Vec3i n = dense.size();
    for (int z = 0; z < n.z; ++z)
      for (int y = 0; y < n.y; ++y)
        for (int x = 0; x < n.x; ++x)
          sum += transform_point(stream.index_to_local, Vec3d(stream.bounds.min + Vec3i(x, y, z)) + Vec3d(0.5)) *
                 double(dense.at(0, {x, y, z}));
    return sum / dense.sum(0);
  };
  settings.turbulence = 0.1;
  const Vec3d hot = centre(settings);
  CHECK(hot.x == Approx(2 * 7.5).margin(2));
  CHECK(std::abs(hot.y) < 1.5);
  settings.sources[0].K = 288;
  CHECK(centre(settings).z < hot.z - 1);
}

TEST_CASE("smoke stays above the ground where its sources do", "[octree][puffs]") {
  PuffSettings settings = small_screen();
  CHECK(puffs_stream(settings).bounds.min.z >= 0);
  settings.sources[0].position_m = {0, 0, -3};
  CHECK(puffs_stream(settings).bounds.min.z < 0);
}

TEST_CASE("eddies carry no divergence", "[octree][puffs]") {
  const detail::CurlNoise noise(7);
  double squares = 0, divergence = 0;
  const double h = 1e-2;
  for (int i = 0; i < 500; ++i) {
    // Inside one spline piece, where the curl is a polynomial of second degree and the difference exact.
    const Vec3d x = Vec3d((i * 37) % 32, (i * 11) % 32, (i * 5) % 32) + Vec3d(0.013 * (i % 30), 0.2, -0.3);
    const double sum = (noise(x + Vec3d(h, 0, 0)).x - noise(x - Vec3d(h, 0, 0)).x + noise(x + Vec3d(0, h, 0)).y -
                        noise(x - Vec3d(0, h, 0)).y + noise(x + Vec3d(0, 0, h)).z - noise(x - Vec3d(0, 0, h)).z) /
                       (2 * h);
    divergence = std::max(divergence, std::abs(sum));
    squares += noise(x).length2();
  }
  CHECK(divergence < 2e-3);
  CHECK(std::sqrt(squares / 500) == Approx(1).epsilon(0.15));
}

TEST_CASE("no age and no mass give an empty cloud", "[octree][puffs]") {
  PuffSettings settings = small_screen();
  settings.age_s = 0;
  CHECK(Dense(puffs_stream(settings)).poured() == 0);
}

TEST_CASE("impossible puffs are refused with every problem at once", "[octree][puffs]") {
  PuffSettings settings = small_screen();
  settings.sources[0].mass_g = -1;
  settings.sources[1].K = 0;
  settings.turbulence = 3;
  try {
    puffs_stream(settings);
    FAIL("accepted");
  } catch (const InputError& error) {
    CHECK(error.problems().size() == 3);
  }
  settings = small_screen();
  settings.voxel_m = 0.005;
  CHECK_THROWS_AS(puffs_stream(settings), InputError);
}
