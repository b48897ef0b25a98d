// The mixture of phase functions where media and clouds overlap.
#include "photon/world/scatter.h"

#include <catch2/catch.hpp>

#include "tests/support/chi_square.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

/// Three clouds over one place: 0.5 * 0.8, 0.9 * 0.5 and nothing at all that scatters.
World overlapping() {
  WorldContents contents;
  contents.bands.emplace_back("grey");
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.extinction = 0.5;
  wish.albedo = 0.8;
  wish.phase = PhaseFunction::henyey_greenstein(0.7);
  contents.clouds.push_back(make_cloud(wish));
  wish.extinction = 2;
  wish.albedo = 0;
  contents.clouds.push_back(make_cloud(wish));
  wish.extinction = 0.9;
  wish.albedo = 0.5;
  wish.phase = PhaseFunction::double_henyey_greenstein(0.3, -0.8, 0.6);
  wish.density = [](const Vec3i& v) { return v.x < 4 ? 1.0 : 0.0; };
  contents.clouds.push_back(make_cloud(wish));
  return World(std::move(contents));
}

}  // namespace

TEST_CASE("phase functions are mixed in proportion to what each medium scatters", "[photon][scatter]") {
  const World world = overlapping();
  const LocalScattering both({world, 0}, {2, 2, 2});
  const LocalScattering one({world, 0}, {6, 2, 2});
  const LocalScattering none({world, 0}, {-1, 2, 2});
  CHECK(both.total() == Approx(0.4 + 0.45));
  CHECK(one.total() == Approx(0.4));
  CHECK(none.total() == 0);
  CHECK(none.phase(0.3) == 0);
  const PhaseFunction a = PhaseFunction::henyey_greenstein(0.7);
  const PhaseFunction b = PhaseFunction::double_henyey_greenstein(0.3, -0.8, 0.6);
  double integral = 0;
  for (int i = 0; i < 2000; ++i) {
    const double mu = -1 + 2 * (i + 0.5) / 2000;
    CHECK(both.phase(mu) == Approx((0.4 * a.value(mu) + 0.45 * b.value(mu)) / 0.85));
    CHECK(one.phase(mu) == a.value(mu));
    integral += 2 * kPi * both.phase(mu) * 2 / 2000;
  }
  CHECK(integral == Approx(1).epsilon(1e-3));
}

TEST_CASE("directions are drawn from the mixture", "[photon][scatter]") {
  const World world = overlapping();
  const Vec3d before = Vec3d(0.3, -0.7, 0.4).normalized();
  const PhaseFunction a = PhaseFunction::henyey_greenstein(0.7);
  const PhaseFunction b = PhaseFunction::double_henyey_greenstein(0.3, -0.8, 0.6);
  for (const Vec3d& x : {Vec3d(2, 2, 2), Vec3d(6, 2, 2)}) {
    const LocalScattering scattering({world, 0}, x);
    Stream random(8, 0, 0);
    const auto draw = [&] {
      const double u = random.uniform();
      const double v = random.uniform();
      return scattering.sample(before, u, v, random.uniform());
    };
    CHECK(chi_square_directions(
        draw, [&](const Vec3d& w) { return scattering.phase(w.dot(before)); }, 200000));
    // Mixed half and half, or turned round, it fails.
    CHECK(!chi_square_directions(
        draw, [&](const Vec3d& w) { return 0.5 * (a.value(w.dot(before)) + b.value(w.dot(before))); }, 200000));
    CHECK(!chi_square_directions(
        draw, [&](const Vec3d& w) { return scattering.phase(-w.dot(before)); }, 200000));
  }
}
