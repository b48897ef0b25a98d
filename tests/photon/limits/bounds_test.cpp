// The bounds behind decisions, on clouds whose answer is known.
#include "photon/limits/bounds.h"

#include <catch2/catch.hpp>

#include "octree/base/error.h"
#include "photon/world/thickness.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

World box(double extinction, double albedo, double g) {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.extinction = extinction;
  wish.albedo = albedo;
  wish.phase = PhaseFunction::henyey_greenstein(g);
  return World(grey_contents(wish));
}

}  // namespace

TEST_CASE("the largest depth lies between a side and the diagonal of a box", "[photon][bounds]") {
  const double depth = largest_optical_depth({box(0.5, 0, 0), 0});
  CHECK(depth >= 0.5 * 8);
  CHECK(depth <= 0.5 * 8 * std::sqrt(3.0) * (1 + 1e-6));
  CHECK(depth > 0.5 * 8 * 1.4);  // 256 chords come near the diagonal
  CHECK(largest_optical_depth({box(5, 0, 0), 0}) == Approx(10 * depth).epsilon(1e-4));
  WorldContents nothing;
  nothing.bands.emplace_back("grey");
  CHECK(largest_optical_depth({World(std::move(nothing)), 0}) == 0);
}

TEST_CASE("histories that would not end are refused by name, those that end are not", "[photon][bounds]") {
  CHECK(endless_histories({box(1e4, 1, 0), 0}, "photon"));
  CHECK_THAT(endless_histories({box(1e4, 1, 0), 0}, "photon")->what(),
             Catch::Contains("photon") && Catch::Contains("ordinates"));
  CHECK(endless_histories({box(1e4, 1 - 1e-6, 0.5), 0}, "photon"));
  CHECK_FALSE(endless_histories({box(1e4, 0.999, 0), 0}, "photon"));  // absorbs in time
  CHECK_FALSE(endless_histories({box(500, 1, 0), 0}, "photon"));      // some 1e7 collisions
  CHECK_FALSE(endless_histories({box(1e4, 1, 0.95), 0}, "photon"));   // mostly forward
  CHECK_FALSE(endless_histories({box(1e6, 0, 0), 0}, "photon"));
}

namespace {

/// No larger than the guaranteed depth: that of seeded chords through random places in random directions.
double deepest_chord(const World& world, int chords) { return largest_optical_depth({world, 0}, chords); }

}  // namespace

TEST_CASE("no chord is deeper than the guaranteed depth, which is within a stated factor", "[photon][bounds]") {
  struct Shape {
    const char* name;
    CloudWish wish;
    Vec3d rotation;
    double factor;  // the guarantee is at most this times the deepest chord
  };
  CloudWish flat;
  flat.voxels = Vec3i(24, 24, 24);
  flat.density = [](const Vec3i& v) { return 0.1 + 0.9 * ((v.x * 7 + v.y * 3 + v.z * 5) % 11 < 3); };
  flat.stretch = {1, 0.3, 0.05};
  CloudWish ball = flat;
  ball.stretch = Vec3d(1);
  ball.density = [](const Vec3i& v) { return (Vec3d(v) - Vec3d(11.5)).length() < 11 ? 1.0 : 0.0; };
  CloudWish box;
  const std::vector<Shape> shapes = {{"box", box, Vec3d(0), 1.3},
                                     {"ball", ball, Vec3d(0.3, 0.7, 1.1), 2.2},
                                     {"rough", rough_wish(0.5), Vec3d(0), 6},
                                     {"flat and turned", flat, Vec3d(0.4, 1.2, 0.2), 6}};
  for (const Shape& shape : shapes) {
    INFO(shape.name);
    WorldContents contents = grey_contents(shape.wish, 1);
    contents.clouds[0].local_to_world =
        contents.clouds[0].local_to_world * placement(Vec3d(100, -20, 3), shape.rotation, 1.5);
    const World world(std::move(contents));
    const MediaSummary summary = summarize(world, {});
    const double most = summary.intervals[0].depth, seen = deepest_chord(world, 10000);
    CHECK(seen <= most);
    CHECK(most <= shape.factor * seen);
    // A twin that forgets slanted rays would be broken by the box.
    if (shape.name == std::string("box")) CHECK(seen > most / std::sqrt(3.0) * 1.05);
  }
}

TEST_CASE("bounds of effects have the stated limits", "[photon][bounds]") {
  IntervalLimits limits;
  limits.depth = limits.scattering_depth = 1e-3;
  limits.albedo_max = 1;
  limits.phase_max = 1 / (4 * kPi);
  limits.sky = 2;
  limits.sun = 3;
  const double q = scattering_norm(limits);
  CHECK(q == Approx(-std::expm1(-1e-3)));
  const EffectBounds thin = effect_bounds(limits, 10, false);
  CHECK(thin.sun == Approx(q * 3 / (4 * kPi) / (1 - q)));
  CHECK(thin.multiple_scattering == Approx(q * q * 2 + q * thin.sun));
  CHECK(thin.sky == 2);
  CHECK(thin.emission == 0);
  // Thick and white: no series converges.
  limits.depth = limits.scattering_depth = kInfinity;
  CHECK(effect_bounds(limits, 10, false).sun == kInfinity);
  CHECK(effect_bounds(limits, 10, false).multiple_scattering == kInfinity);
  CHECK(effect_bounds(limits, 10, false).sky == 2);
  // A surface behind the cloud reflects what comes through.
  limits = {};
  limits.reflectance_max = 0.5;
  CHECK(interaction_norm(limits) == 0.5);
  limits.depth = limits.scattering_depth = 1;
  limits.albedo_max = 0.9;
  CHECK(interaction_norm(limits) == Approx(0.9 * -std::expm1(-1.0) + 0.5 * std::exp(-1.0)));
  // Air: a share of what is seen, and its own light.
  limits = {};
  limits.air_extinction = 1e-4;
  limits.air = 7;
  CHECK(effect_bounds(limits, 100, false).air_share == Approx(0.01).epsilon(0.01));
  CHECK(effect_bounds(limits, 100, false).air_gained == Approx(0.07).epsilon(0.01));
  CHECK(effect_bounds(limits, kInfinity, false).air_gained == 7);
}

TEST_CASE("the largest value of a phase function is found at its ends or nodes", "[photon][bounds]") {
  for (const double g : {-0.7, 0.0, 0.3, 0.95}) {
    const PhaseFunction p = PhaseFunction::double_henyey_greenstein(g, -0.5, 0.6);
    double seen = 0;
    for (int k = 0; k <= 1000; ++k) seen = std::max(seen, p.value(k / 500.0 - 1));
    CHECK(p.largest() == Approx(seen));
  }
  CHECK(PhaseFunction::rayleigh().largest() == Approx(3 / (8 * kPi)));
  CHECK(PhaseFunction::henyey_greenstein(1).largest() == kInfinity);
  const PhaseFunction table = PhaseFunction::table({0, 60, 180}, {1, 5, 1});
  CHECK(table.largest() == Approx(table.value(0.5)));
}
