// Discrete ordinates against exact values, conservation and themselves.
#include "photon/ordinates/ordinates.h"

#include <oneapi/tbb/global_control.h>

#include <catch2/catch.hpp>

#include "octree/base/error.h"
#include "tests/support/csv.h"
#include "tests/support/places.h"
#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/slab_ordinates.h"
#include "tests/support/slabs.h"

using namespace obscura;
using namespace obscura::test;

namespace {

std::string table(const std::string& name) { return test::data_file("reference/" + name); }

World cube(const CloudWish& wish, double sky, double sun = 0) {
  WorldContents contents = grey_contents(wish, sky);
  if (sun > 0) contents.sun = Sun{Vec3d(0.3, -0.4, 0.8).normalized(), {sun}, 0};
  return World(std::move(contents));
}

}  // namespace

TEST_CASE("slabs that scatter alike everywhere reflect and transmit what they should", "[ordinates][slab]") {
  const Csv d1(table("d1_slab_isotropic_flux.csv"));
  int compared = 0;
  for (std::size_t row = 0; row < d1.size(); ++row) {
    const double tau = d1.number(row, "tau"), albedo = d1.number(row, "w"), mu0 = d1.number(row, "mu0");
    if (tau > 20) continue;
    const SlabShares shares = slab_shares({{{tau, albedo, {}}}, mu0}, slab_settings(tau > 2 ? 160 : 64, 24));
    INFO("tau " << tau << " albedo " << albedo << " mu0 " << mu0);
    CHECK(shares.up == Approx(d1.number(row, "R")).epsilon(tau > 10 ? 2e-3 : 2e-4));
    CHECK(shares.down == Approx(d1.number(row, "T_diffuse")).epsilon(2e-4).margin(1e-7));
    CHECK(std::abs(shares.residual) < 1e-6);
    CHECK(shares.sweeps < 30);
    ++compared;
  }
  CHECK(compared >= 24);
}

TEST_CASE("slabs that scatter forward reflect and transmit what they should", "[ordinates][slab]") {
  const Csv d2(table("d2_slab_hg_flux.csv"));
  for (std::size_t row = 0; row < d2.size(); ++row) {
    const double g = d2.number(row, "g"), tau = d2.number(row, "tau"), albedo = d2.number(row, "w"),
                 mu0 = d2.number(row, "mu0");
    const bool rayleigh = d2.text(row, "phase") == "rayleigh";
    const PhaseFunction phase = rayleigh ? PhaseFunction::rayleigh() : PhaseFunction::henyey_greenstein(g);
    const SlabShares shares = slab_shares({{{tau, albedo, phase}}, mu0}, slab_settings(24, 16));
    INFO("g " << g << " tau " << tau << " albedo " << albedo << " mu0 " << mu0);
    // Delta-M at S16 has little left of g = 0.95.
    const double tolerance = g > 0.9 ? 1e-2 : g > 0.8 ? 1.5e-3 : 1e-3;
    CHECK(shares.up == Approx(d2.number(row, "R")).epsilon(tolerance).margin(1e-6));
    CHECK(shares.down == Approx(d2.number(row, "T_diffuse")).epsilon(tolerance).margin(1e-6));
  }
}

TEST_CASE("layers of different clouds add up", "[ordinates][slab]") {
  const Csv d7(table("d7_two_layer_slab.csv"));
  for (std::size_t row = 0; row < d7.size(); ++row) {
    SlabWish slab;
    const std::vector<double> tau = d7.numbers(row, "tau_list"), albedo = d7.numbers(row, "w_list"),
                              g = d7.numbers(row, "g_list");
    for (std::size_t i = 0; i < tau.size(); ++i) {
      slab.layers.push_back({tau[i], albedo[i], g[i] != 0 ? PhaseFunction::henyey_greenstein(g[i]) : PhaseFunction()});
    }
    const bool beam = d7.text(row, "illum") == "beam";
    if (!beam) continue;
    slab.mu0 = d7.number(row, "mu0");
    const SlabShares shares = slab_shares(slab, slab_settings(24 * static_cast<int>(tau.size()), 12));
    INFO(d7.text(row, "case") << " mu0 " << slab.mu0);
    CHECK(shares.up == Approx(d7.number(row, "R")).epsilon(1e-3));
    CHECK(shares.down == Approx(d7.number(row, "T")).epsilon(1e-3));
  }
}

TEST_CASE("isothermal slabs emit what they absorb", "[ordinates][slab]") {
  const Csv d3(table("d3_slab_thermal.csv"));
  for (std::size_t row = 0; row < d3.size(); ++row) {
    if (d3.number(row, "B_top") != d3.number(row, "B_bot")) continue;
    const double g = d3.number(row, "g");
    SlabWish slab{
        {{d3.number(row, "tau"), d3.number(row, "w"), g > 0 ? PhaseFunction::henyey_greenstein(g) : PhaseFunction()}}};
    slab.source = 1;
    const World world(slab_contents(slab));
    const OrdinatesSolution solution = solve_ordinates(world, 0, slab_settings(g > 0 ? 48 : 200, 16));
    INFO("tau " << d3.number(row, "tau") << " albedo " << d3.number(row, "w") << " g " << g);
    CHECK(solution.powers().left[2][1] / (64 * kPi) == Approx(d3.number(row, "Fup_over_pi")).epsilon(1e-3));
    for (const std::string cosine : {"0.1", "0.5", "0.9"}) {
      const double mu = std::stod(cosine);
      const Ray ray{Vec3d(4, 4, 12), Vec3d(std::sqrt(1 - mu * mu), 0, -mu), 0, kInfinity};
      Incoming in;
      solution.radiance({&ray, 1}, {&in, 1});
      CHECK(in.direct == Approx(d3.number(row, "up_mu" + cosine)).epsilon(1e-2));
    }
  }
}

TEST_CASE("radiance along rays is that of the slab", "[ordinates][slab][radiance]") {
  const Csv d1(table("d1_slab_isotropic_intensity.csv"));
  const auto check = [](const Csv& csv, std::size_t row, const OrdinatesSolution& solution, double phi,
                        double tolerance) {
    const double mu = csv.number(row, "mu"), sine = std::sqrt(1 - mu * mu);
    // The light travels the other way; the sun's goes along +x.
    const Vec3d across(sine * std::cos(phi), sine * std::sin(phi), 0);
    const Ray rays[2] = {{Vec3d(4, 4, 12), -across - Vec3d(0, 0, mu), 0, kInfinity},
                         {Vec3d(4, 4, -4), -across + Vec3d(0, 0, mu), 0, kInfinity}};
    Incoming in[2];
    solution.radiance(rays, in);
    INFO("mu " << mu << " phi " << phi);
    CHECK(in[0].direct == Approx(csv.number(row, "I_up_top")).epsilon(tolerance));
    CHECK(in[1].direct == Approx(csv.number(row, "I_down_bottom")).epsilon(tolerance));
  };
  for (std::size_t row = 0; row < d1.size();) {
    const double tau = d1.number(row, "tau"), albedo = d1.number(row, "w"), mu0 = d1.number(row, "mu0");
    std::size_t end = row;
    while (end < d1.size() && d1.number(end, "tau") == tau && d1.number(end, "w") == albedo &&
           d1.number(end, "mu0") == mu0)
      ++end;
    if (mu0 == 0.5 && tau <= 10) {
      const World world(slab_contents({{{tau, albedo, {}}}, mu0}));
      const OrdinatesSolution solution = solve_ordinates(world, 0, slab_settings(32, 16));
      INFO("tau " << tau << " albedo " << albedo);
      for (; row < end; ++row) check(d1, row, solution, 0, 1e-3);
    }
    row = end;
  }
  const Csv d2(table("d2_slab_hg_intensity.csv"));
  const World world(slab_contents({{{2, 0.9, PhaseFunction::henyey_greenstein(0.75)}}, 0.5}));
  const OrdinatesSolution solution = solve_ordinates(world, 0, slab_settings(16, 16));
  int compared = 0;
  for (std::size_t row = 0; row < d2.size(); ++row) {
    if (d2.text(row, "phase") != "hg" || d2.number(row, "g") != 0.75 || d2.number(row, "tau") != 2 ||
        d2.number(row, "w") != 0.9 || d2.number(row, "mu0") != 0.5)
      continue;
    check(d2, row, solution, d2.number(row, "phi_deg") * kPi / 180, 1e-2);
    ++compared;
  }
  CHECK(compared == 16);
}

TEST_CASE("thick slabs that absorb nothing diffuse, in thick cells too", "[ordinates][slab]") {
  const Csv d5(table("d5_thick_conservative_isotropic.csv"));
  for (std::size_t row = 0; row < d5.size(); ++row) {
    const double tau = d5.number(row, "tau"), mu0 = d5.number(row, "mu0");
    if (tau < 100 || tau > 1e5 || mu0 < 0) continue;
    INFO("tau " << tau << " mu0 " << mu0);
    // Cells of 2 to 20,000 mean free paths.
    const SlabShares shares = slab_shares({{{tau, 1, {}}}, mu0}, slab_settings(48, 16));
    CHECK(shares.down == Approx(d5.number(row, "T_asymptotic")).epsilon(1e-2));
    CHECK(shares.sweeps < 40);
    if (tau > 100) continue;
    CHECK(slab_shares({{{tau, 1, {}}}, mu0}, slab_settings(800, 16)).down ==
          Approx(d5.number(row, "T_asymptotic")).epsilon(1e-4));
  }
}

TEST_CASE("the error falls at least with the square of the cells' size", "[ordinates][slab]") {
  const auto up = [](int cells) {
    OrdinatesSettings settings = slab_settings(cells, 12);
    settings.tolerance = 1e-10;
    return slab_shares({{{2, 0.9, {}}}, 0.5}, settings).up;
  };
  const double limit = up(256);
  const double coarse = std::abs(up(8) - limit), fine = std::abs(up(32) - limit);
  CHECK(coarse < 3e-4 * limit);
  CHECK(std::log2(coarse / fine) / 2 > 1.8);
}

TEST_CASE("what is absorbed is right when it is a billionth", "[ordinates][slab]") {
  const Csv h3(table("h3_near_conservative_slab.csv"));
  for (std::size_t row = 0; row < h3.size(); ++row) {
    const double g = h3.number(row, "g"), tau = h3.number(row, "tau"), mu0 = h3.number(row, "mu0");
    if (mu0 != 0.5 || g > 0.8) continue;
    const PhaseFunction phase = g > 0 ? PhaseFunction::henyey_greenstein(g) : PhaseFunction();
    const double albedo = 1 - h3.number(row, "one_minus_w");
    // The albedo is a double: what it leaves of 1e-12 has four digits.
    const double exact = (1 - albedo) * h3.number(row, "mean_collisions");
    const SlabShares shares = slab_shares({{{tau, albedo, phase}}, mu0}, slab_settings(g > 0      ? 24
                                                                                       : tau > 20 ? 400
                                                                                                  : 64,
                                                                                       g > 0 ? 12 : 16));
    INFO("g " << g << " tau " << tau << " 1 - w " << h3.number(row, "one_minus_w"));
    CHECK(shares.absorbed == Approx(exact).epsilon(1.5e-3));
  }
}

TEST_CASE("in a furnace everything is black", "[ordinates][furnace]") {
  CloudWish wish = rough_wish(0.6, 0.5, 2.5);
  OrdinatesSettings settings;
  settings.cells = Vec3i(8);
  settings.order = 4;
  const World world = cube(wish, 2.5);
  const OrdinatesSolution solution = solve_ordinates(world, 0, settings);
  for (std::size_t cell = 0; cell < solution.grid().size(); ++cell) {
    REQUIRE(solution.fluence(cell) == Approx(4 * kPi * 2.5).epsilon(1e-6));
    REQUIRE(solution.flux(cell).length() < 1e-5);
  }
  const Ray ray{Vec3d(-3, 0.4, 0.3), Vec3d(0.9, 0.3, 0.2).normalized(), 0, kInfinity};
  Incoming in;
  solution.radiance({&ray, 1}, {&in, 1});
  CHECK(in.direct == Approx(2.5).epsilon(1e-6));
  // A colder sky is told apart.
  CHECK(solve_ordinates(cube(wish, 2.4), 0, settings).fluence(0) < 4 * kPi * 2.4999);
}

TEST_CASE("what does not absorb lets all light out again", "[ordinates][furnace]") {
  OrdinatesSettings settings;
  settings.cells = Vec3i(8);
  settings.order = 4;
  const OrdinatesSolution solution = solve_ordinates(cube(rough_wish(1, 0.3), 1, 5), 0, settings);
  const OrdinatesPowers& powers = solution.powers();
  CHECK(std::abs(powers.residual()) < 1e-6);
  CHECK(std::abs(powers.absorbed) < 1e-9 * powers.entered);
  double out = 0;
  for (const auto& sides : powers.left) out += sides[0] + sides[1];
  CHECK(out == Approx(powers.entered + powers.first_scattered).epsilon(1e-6));
}

TEST_CASE("fluence is positive beside thick and thin, lit from one side", "[ordinates][positive]") {
  CloudWish wish = rough_wish(0.5);
  wish.extinction = 300;
  OrdinatesSettings settings;
  settings.cells = Vec3i(16);
  settings.order = 6;
  settings.quadrature = AngularQuadrature::level_symmetric;
  const OrdinatesSolution solution = solve_ordinates(cube(wish, 0, 1), 0, settings);
  for (std::size_t cell = 0; cell < solution.grid().size(); ++cell) REQUIRE(solution.fluence(cell) >= 0);
  CHECK(std::abs(solution.powers().residual()) < 1e-6);
}

TEST_CASE("any number of threads gives the same bits", "[ordinates][threads]") {
  const World world = cube(rough_wish(0.9, 0.4, 1), 0.5, 2);
  OrdinatesSettings settings;
  settings.cells = Vec3i(16);
  settings.order = 4;
  const auto run = [&](std::size_t threads) {
    oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism, threads);
    const OrdinatesSolution solution = solve_ordinates(world, 0, settings);
    std::vector<double> values;
    for (std::size_t cell = 0; cell < solution.grid().size(); ++cell) {
      values.push_back(solution.fluence(cell));
      values.push_back(solution.flux(cell).x);
    }
    return values;
  };
  const std::vector<double> one = run(1);
  CHECK(run(2) == one);
  CHECK(run(3) == one);
}

TEST_CASE("a nearly white thick cloud converges in tens of sweeps", "[ordinates][iterations]") {
  CloudWish wish;
  wish.voxels = Vec3i(16);
  wish.extinction = 100.0 / 16;
  wish.albedo = 0.9999;
  OrdinatesSettings settings;
  settings.cells = Vec3i(16);
  settings.order = 4;
  const OrdinatesSolution solution = solve_ordinates(cube(wish, 1, 1), 0, settings);
  CHECK(solution.iterations() <= 30);
  CHECK(std::abs(solution.powers().residual()) < 1e-6);
}

TEST_CASE("in a furnace surfaces are black too, whatever they reflect", "[ordinates][surfaces]") {
  WorldContents contents = grey_contents(rough_wish(0.6, 0.4, 2), 2);
  contents.materials.push_back(grey_material(0.3));
  contents.objects.push_back(grey_object(box_mesh(Vec3d(0.8, 0.8, 1.2), Vec3d(2.0, 1.6, 2.0), false), 0, 2));
  contents.objects.push_back(grey_object(parallelogram(Vec3d(-1, -1, 0), Vec3d(6, 0, 0), Vec3d(0, 6, 0)), 0, 2));
  contents.objects.back().double_sided = true;
  const World world(std::move(contents));
  OrdinatesSettings settings;
  settings.cells = Vec3i(8);
  settings.order = 4;
  const OrdinatesSolution solution = solve_ordinates(world, 0, settings);
  for (const Ray& ray :
       {Ray{Vec3d(-3, 0.4, 0.3), Vec3d(0.9, 0.3, 0.2).normalized()}, Ray{Vec3d(1.5, 1.4, 5), Vec3d(0, 0, -1)},
        Ray{Vec3d(0.2, 0.2, 5), Vec3d(0.1, 0, -1).normalized()}}) {
    Incoming in;
    solution.radiance({&ray, 1}, {&in, 1});
    CHECK(in.direct == Approx(2).epsilon(1e-5));
  }
  CHECK(std::abs(solution.powers().residual()) < 1e-6);
  CHECK(solution.fluence_at(Vec3d(0.3, 0.3, 2.9)).value == Approx(8 * kPi).epsilon(1e-5));
}

TEST_CASE("a chalky floor under a sun reflects what it should, and darkens behind a box", "[ordinates][surfaces]") {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.extinction = 1e-9;
  wish.albedo = 0.5;
  WorldContents contents = grey_contents(wish);
  contents.sun = Sun{Vec3d(0.6, 0, 0.8), {10}, 0};
  contents.materials.push_back(grey_material(0.25));
  contents.objects.push_back(grey_object(parallelogram(Vec3d(-2, -2, 0), Vec3d(12, 0, 0), Vec3d(0, 12, 0)), 0, 0));
  contents.objects.push_back(grey_object(box_mesh(Vec3d(3, 3, 1), Vec3d(5, 5, 3), false), 0, 0));
  const World world(std::move(contents));
  OrdinatesSettings settings;
  settings.cells = Vec3i(8);
  const OrdinatesSolution solution = solve_ordinates(world, 0, settings);
  const auto look_down = [&](double x, double y) {
    const Ray ray{Vec3d(x, y, 0.5), Vec3d(0, 0, -1)};
    Incoming in;
    solution.radiance({&ray, 1}, {&in, 1});
    CHECK(in.distance == Approx(0.5));
    return in.direct;
  };
  // Far from the box hardly anything but the sun; in its shadow only what the box and the floor exchange.
  CHECK(look_down(-1, -1) == Approx(0.75 * 8 / kPi).epsilon(0.02));
  CHECK(look_down(2.5, 4) < 0.3 * 0.75 * 8 / kPi);
  CHECK(std::abs(solution.powers().residual()) < 1e-3);
}

TEST_CASE("a floor gives back its share of the sun's power", "[ordinates][surfaces]") {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.extinction = 1e-9;
  WorldContents contents = grey_contents(wish);
  contents.sun = Sun{Vec3d(0.6, 0, 0.8), {10}, 0};
  contents.materials.push_back(grey_material(0.25));
  contents.objects.push_back(grey_object(parallelogram(Vec3d(0, 0, 0), Vec3d(8, 0, 0), Vec3d(0, 8, 0)), 0, 0));
  const World world(std::move(contents));
  OrdinatesSettings settings;
  settings.cells = Vec3i(4);
  const OrdinatesPowers powers = solve_ordinates(world, 0, settings).powers();
  CHECK(powers.surfaces == Approx(0.75 * 8 * 64).epsilon(1e-6));
  double out = 0;
  for (const auto& sides : powers.left) out += sides[0] + sides[1];
  CHECK(out == Approx(0.75 * 8 * 64).epsilon(1e-6));
}

TEST_CASE("a warm plate in a cloud gives its power off to cloud and faces", "[ordinates][surfaces]") {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.extinction = 0.3;
  wish.albedo = 0.5;
  WorldContents contents = grey_contents(wish);
  contents.materials.push_back(grey_material(1));
  contents.objects.push_back(grey_object(parallelogram(Vec3d(2, 2, 4), Vec3d(4, 0, 0), Vec3d(0, 4, 0)), 0, 1));
  const World world(std::move(contents));
  OrdinatesSettings settings;
  settings.cells = Vec3i(8);
  const OrdinatesSolution solution = solve_ordinates(world, 0, settings);
  const OrdinatesPowers& powers = solution.powers();
  double out = powers.absorbed;
  for (const auto& sides : powers.left) out += sides[0] + sides[1];
  CHECK(out == Approx(powers.surfaces).epsilon(1e-6));
  // Of pi times 16 m2 some comes back.
  CHECK(powers.surfaces < 16 * kPi);
  CHECK(powers.surfaces > 0.8 * 16 * kPi);
  // The front looks up: more leaves there.
  CHECK(powers.left[2][1] > 5 * powers.left[2][0]);
  Ray ray{Vec3d(4, 4, 10), Vec3d(0, 0, -1)};
  Incoming in;
  solution.radiance({&ray, 1}, {&in, 1});
  CHECK(in.transmission == Approx(std::exp(-0.3 * 4)));
  CHECK(in.direct > std::exp(-1.2));
  CHECK(in.direct < 1);
}

TEST_CASE("fluence far away through voids is that of the published benchmark", "[ordinates][fluence]") {
  // Kobayashi's first problem without scattering: a source of 10 cm in a void of 50 cm in a shield, mirrored.
  const Csv e5(table("e5_kobayashi.csv"));
  CloudWish wish;
  wish.voxels = Vec3i(20);
  wish.voxel_m = 10;
  wish.corner_m = Vec3d(-100);
  const auto place = [](const Vec3i& v) {
    const auto from_middle = [](int i) { return i < 10 ? 9 - i : i - 10; };
    return std::max({from_middle(v.x), from_middle(v.y), from_middle(v.z)});
  };
  wish.density = [&](const Vec3i& v) { return place(v) >= 1 && place(v) < 5 ? 1e-4 : 0.1; };
  WorldContents contents = grey_contents(wish);
  CloudWish source = wish;
  source.density = [&](const Vec3i& v) { return place(v) == 0 ? 1.0 : 0.0; };
  Cloud lamp = make_cloud(source);
  lamp.media[0].extinction = {1e-12};
  lamp.emission = {1 / (4 * kPi)};
  contents.clouds.push_back(lamp);
  const World world(std::move(contents));
  OrdinatesSettings settings;
  settings.cells = Vec3i(20);
  settings.order = 4;
  const OrdinatesSolution solution = solve_ordinates(world, 0, settings);
  CHECK(solution.powers().emitted == Approx(8000).epsilon(1e-9));
  for (std::size_t row = 0; row < e5.size(); ++row) {
    if (e5.number(row, "problem") != 1 || e5.text(row, "case") != "i" || row % 5 != 0) continue;
    const OrdinatesEstimate fluence =
        solution.fluence_at(Vec3d(e5.number(row, "x"), e5.number(row, "y"), e5.number(row, "z")));
    INFO("row " << row << " value " << fluence.value << " error " << fluence.error);
    CHECK(fluence.value == Approx(e5.number(row, "flux")).epsilon(1e-3));
    CHECK(std::abs(fluence.value - e5.number(row, "flux")) < 3 * fluence.error);
  }
}

TEST_CASE("an empty cloud changes nothing, and a World without clouds has its sky", "[ordinates]") {
  CloudWish wish;
  wish.density = [](const Vec3i&) { return 0.0; };
  OrdinatesSettings settings;
  settings.order = 2;
  for (const bool cloud : {true, false}) {
    WorldContents contents = grey_contents(wish, 3);
    if (!cloud) contents.clouds.clear();
    const World world(std::move(contents));
    const OrdinatesSolution solution = solve_ordinates(world, 0, settings);
    const Ray ray{Vec3d(8, -5, 8), Vec3d(0, 1, 0)};
    Incoming in;
    solution.radiance({&ray, 1}, {&in, 1});
    CHECK(in.direct == 3);
    CHECK(in.transmission == 1);
    CHECK(solution.fluence_at(Vec3d(1, 2, 3)).value == Approx(12 * kPi).epsilon(1e-12));
  }
}

TEST_CASE("the grid has whole voxels in its cells where it can, and reproduces them", "[ordinates][grid]") {
  CloudWish wish;
  wish.voxels = Vec3i(40, 20, 10);
  wish.extinction = 2;
  wish.albedo = 0.25;
  wish.source = 3;
  wish.density = [](const Vec3i& v) { return voxel_noise(3, Vec3i(v.x / 2, v.y / 2, v.z / 2)); };
  const World world = cube(wish, 0);
  const OrdinatesGrid grid(world, 0, Vec3i(0), std::nullopt);
  CHECK(grid.cells() == Vec3i(20, 10, 5));
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    const double extinction = 2 * static_cast<double>(static_cast<float>(voxel_noise(3, grid.cell_at(cell))));
    REQUIRE(grid.extinction[cell] == Approx(extinction).epsilon(1e-12));
    REQUIRE(grid.scattering[cell] == Approx(0.25 * extinction).epsilon(1e-12));
    REQUIRE(grid.emission[cell] == Approx(0.75 * 3 * extinction).epsilon(1e-12));
  }
}

TEST_CASE("too much memory and what cannot be solved are refused by name", "[ordinates][errors]") {
  CloudWish wish;
  OrdinatesSettings settings;
  settings.cells = Vec3i(64);
  settings.memory_MiB = 10;
  CHECK_THROWS_AS(solve_ordinates(cube(wish, 1), 0, settings), ResourceError);
  settings = {};
  settings.order = 5;
  CHECK_THROWS_AS(solve_ordinates(cube(wish, 1), 0, settings), InputError);
  WorldContents contents = grey_contents(wish, 1);
  contents.sources.push_back({Vec3d(30, 0, 0), 1, {1.0}});
  const World world(std::move(contents));
  CHECK_THROWS_AS(solve_ordinates(world, 0, {}), NumericalError);
  for (const double emissivity : {1.0, 0.5}) {
    WorldContents lit = grey_contents(wish, 1);
    lit.beams.push_back({Vec3d(8, 8, 20), Vec3d(0, 0, -1), 1, {1.0}});
    lit.materials.emplace_back().emissivity = {emissivity};
    lit.objects.push_back(grey_object(parallelogram(Vec3d(0, 0, 8), Vec3d(16, 0, 0), Vec3d(0, 16, 0)), 0, 0));
    const World on_plate(std::move(lit));
    settings = {};
    settings.cells = Vec3i(4);
    if (emissivity < 1) {
      CHECK_THROWS_AS(solve_ordinates(on_plate, 0, settings), NumericalError);
    } else {
      CHECK_NOTHROW(solve_ordinates(on_plate, 0, settings));
    }
  }
}
