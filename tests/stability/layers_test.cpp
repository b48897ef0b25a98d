// Layers that are hard to follow light through: the tables h2, h3 and d4 of the reference, and what is refused.
#include <catch2/catch.hpp>

#include "octree/base/error.h"
#include "photon/ordinates/ordinates.h"
#include "photon/paths/path_tracer.h"
#include "tests/stability/limits.h"
#include "tests/support/agree.h"
#include "tests/support/estimators.h"

using namespace obscura;
using namespace obscura::test;

namespace {

/// A homogeneous layer, 1 m thick, that repeats, under a sun at the zenith.
World layer(double depth, double albedo, const PhaseFunction& phase, double sun, double sky = 0) {
  CloudWish wish;
  wish.voxels = Vec3i(4);
  wish.voxel_m = 0.25;
  wish.extinction = depth;
  wish.albedo = albedo;
  wish.phase = phase;
  wish.period_m = {1, 1};
  WorldContents contents = grey_contents(wish, sky);
  if (sun > 0) contents.sun = Sun{{0, 0, 1}, {sun}, 0};
  return World(std::move(contents));
}

}  // namespace

TEST_CASE("h2: layers that scatter straight on or straight back", "[stability][limits][reference]") {
  struct Row {
    double albedo, g, depth, reflected, transmitted;
  };
  // h2_rod_limits.csv
  const Row rows[] = {{1, -1, 1, 0.5, 0.5},
                      {1, 1, 1, 0, 1},
                      {0.999999, -1, 10, 0.90908449047324214, 0.090905509743419197},
                      {0.999999, 1, 10, 0, 0.99999000004999983},
                      {0.9, -1, 0.1, 0.081771107446021826, 0.90828021111916675},
                      {0.9, 1, 0.1, 0, 0.99004983374916805},
                      {0.9, -1, 5, 0.62189629702652101, 0.069016179880171263},
                      {0.9, 1, 5, 0, 0.60653065971263342},
                      {0.5, -1, 2, 0.26014671702802541, 0.1645887185330692},
                      {0.5, 1, 2, 0, 0.36787944117144232}};
  const FluxRectangle planes[] = {{{0.5, 0.5, 1.5}, {1, 0, 0}, {0, 1, 0}}, {{0.5, 0.5, -0.5}, {1, 0, 0}, {0, 1, 0}}};
  for (const Row& row : rows) {
    // 0.9999 goes straight on or back but for an angle of a degree, and 1 but for none.
    for (const double g : {row.g, 0.9999 * row.g}) {
      INFO("albedo " << row.albedo << ", g " << g << ", depth " << row.depth);
      const World lit = layer(row.depth, row.albedo, PhaseFunction::henyey_greenstein(g), 1);
      TraceSettings trace;
      trace.photons = 20000;
      const TraceResult traced = trace_photons({lit, 0}, trace, planes);
      const BatchMean up = per_area(traced.flux[0].forward, 1), down = per_area(traced.flux[1].backward, 1);
      const double spread = std::abs(g) < 1 ? 0.003 : 0;  // what the degree costs
      CHECK(std::abs(up.mean - row.reflected) <= 6 * up.standard_error + spread + 3e-4);
      CHECK(std::abs(down.mean - row.transmitted) <= 6 * down.standard_error + spread + 3e-4);
      CHECK(up.standard_error < 0.009);
      CHECK(down.standard_error < 0.009);
      // Between two equal skies a path along the normal brings reflection and transmission together.
      const World between = layer(row.depth, row.albedo, PhaseFunction::henyey_greenstein(g), 0, 1);
      const Ray ray{{0.4, 0.6, 3}, {0, 0, -1}, 0, kInfinity};
      const Seen both = seen(between, {}, kPathTracer, {&ray, 1}, 4000);
      CHECK(std::abs(both.mean - row.reflected - row.transmitted) <= 6 * both.error + spread + 1e-5);
      CHECK(both.error < 0.01);
    }
  }
}

TEST_CASE("h3: layers of 1 - albedo = 1e-9 reflect, let through and keep what the table says",
          "[stability][limits][reference]") {
  struct Row {
    double g, depth, collisions, reflected, transmitted;
  };
  // h3_near_conservative_slab.csv, mu0 = 1
  const Row rows[] = {{0, 1, 1.6359448551, 0.34132875895, 0.65867123941},
                      {0, 10, 23.724182706, 0.85300460463, 0.14699537165},
                      {0.85, 1, 1.1856190077, 0.042316218064, 0.95768378075},
                      {0.85, 20, 45.803300394, 0.61716719481, 0.38283275939}};
  const FluxRectangle planes[] = {{{0.5, 0.5, 1.5}, {1, 0, 0}, {0, 1, 0}}, {{0.5, 0.5, -0.5}, {1, 0, 0}, {0, 1, 0}}};
  for (const Row& row : rows) {
    INFO("g " << row.g << ", depth " << row.depth);
    const PhaseFunction phase = row.g == 0 ? PhaseFunction::isotropic() : PhaseFunction::henyey_greenstein(row.g);
    const World world = layer(row.depth, 1 - 1e-9, phase, 1);
    TraceSettings trace;
    trace.photons = 20000;
    const TraceResult traced = trace_photons({world, 0}, trace, planes);
    const BatchMean up = per_area(traced.flux[0].forward, 1), down = per_area(traced.flux[1].backward, 1);
    CHECK(agree(up.mean, up.standard_error, row.reflected,
                {.resolution = 0.5, .comparisons = 20, .degrees_of_freedom = 15}));
    CHECK(agree(down.mean, down.standard_error, row.transmitted,
                {.resolution = 0.25, .comparisons = 20, .degrees_of_freedom = 15}));
    // What is absorbed is 1e-9 of what collides: first collisions are not stored, all later ones are.
    BatchTally stored{};
    for (const Photon& photon : traced.photons) stored[photon.batch] += static_cast<double>(photon.power);
    const BatchMean later = per_area(stored, 1);
    CHECK(agree(later.mean + -std::expm1(-row.depth), later.standard_error, row.collisions,
                {.resolution = 0.3, .comparisons = 20, .degrees_of_freedom = 15}));
    CHECK(total(traced.energy.absorbed) < 1e-3);
    const PathFlux reflected = path_flux({world, 0}, {}, planes[0], 9000, 1),
                   transmitted = path_flux({world, 0}, {}, planes[1], 9000, 2);
    CHECK(agree(reflected.forward.mean, reflected.forward.standard_error, row.reflected,
                {.resolution = 0.9, .comparisons = 20}));
    CHECK(agree(transmitted.backward.mean, transmitted.backward.standard_error, row.transmitted,
                {.resolution = 0.4, .comparisons = 20}));
  }
}

TEST_CASE("a half space of any thickness reflects and glows as the table says", "[stability][limits][reference]") {
  // d4_semi_infinite_isotropic.csv, albedo 0.9 and 0.3 at normal incidence.
  struct Row {
    double albedo, reflected, emissivity;
  };
  const FluxRectangle above{{0.5, 0.5, 1.5}, {1, 0, 0}, {0, 1, 0}};
  for (const Row& row : {Row{0.9, 0.4149474791308, 0.5850525208692}, Row{0.3, 0.05721435060125, 0.9427856493987}}) {
    for (const double depth : {100.0, 1e4, 1e6}) {
      for (const int voxels : {1, 4, 32}) {
        INFO("albedo " << row.albedo << ", depth " << depth << ", " << voxels << " voxels");
        CloudWish wish;
        wish.voxels = Vec3i(voxels);
        wish.voxel_m = 1.0 / voxels;
        wish.extinction = depth;
        wish.albedo = row.albedo;
        wish.period_m = {1, 1};
        WorldContents contents = grey_contents(wish);
        contents.sun = Sun{{0, 0, 1}, {1}, 0};
        TraceSettings trace;
        trace.photons = 10000;
        const BatchMean up = per_area(trace_photons({World(contents), 0}, trace, {&above, 1}).flux[0].forward, 1);
        CHECK(agree(up.mean, up.standard_error, row.reflected,
                    {.resolution = 1, .comparisons = 50, .degrees_of_freedom = 15}));
        wish.source = kB;
        const World glowing(grey_contents(wish));
        const Ray ray{{0.4, 0.6, 3}, {0, 0, -1}, 0, kInfinity};
        const Seen glow = seen(glowing, {}, kPathTracer, {&ray, 1}, 2500);
        CHECK(agree(glow.mean, glow.error, kB * row.emissivity, {.resolution = 0.06, .comparisons = 50}));
      }
    }
  }
}

TEST_CASE("light that nobody could follow to its end is refused by name, and by ordinates it is solved",
          "[stability][refusal]") {
  // 1e6 deep, nothing is absorbed.
  const World endless = layer(1e6, 1, PhaseFunction::isotropic(), 1);
  CHECK_THROWS_AS(photons_of(endless, 100), NumericalError);
  CHECK_THROWS_WITH(photons_of(endless, 100), Catch::Contains("photon") && Catch::Contains("ordinates"));
  REQUIRE(unfit_for_paths(endless));
  CHECK_THAT(unfit_for_paths(endless)->what(), Catch::Contains("path") && Catch::Contains("ordinates"));
  OrdinatesSettings settings;
  settings.cells = {1, 1, 16};
  settings.tolerance = 1e-5;
  const OrdinatesSolution solution = solve_ordinates({endless, 0}, settings);
  const OrdinatesPowers& powers = solution.powers();
  // d5: 1.7e-6 of the sun at the zenith comes through, all the rest is reflected.
  CHECK(powers.left[2][1] == Approx(1).epsilon(1e-4));
  // Where light is absorbed in time, or goes on, nothing is refused.
  CHECK_FALSE(unfit_for_paths(layer(1e6, 0.9, PhaseFunction::isotropic(), 1)));
  CHECK_FALSE(unfit_for_paths(layer(1e6, 1, PhaseFunction::henyey_greenstein(0.9999), 1)));
}
