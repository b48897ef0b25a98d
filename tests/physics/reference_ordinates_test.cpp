// The reference tables by discrete ordinates, each number with the error that the method states itself.
#include <catch2/catch.hpp>

#include "photon/ordinates/ordinates_referee.h"
#include "tests/support/reference_rules.h"
#include "tests/support/reference_worlds.h"
#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/slab_ordinates.h"

using namespace obscura;
using namespace obscura::test;

namespace {

constexpr double kSide = 1;  // m, of the periodic cell
const char* const kMethod = "discrete ordinates";

World lit(const std::vector<Layer>& layers, double mu0) { return World(stack_contents({layers, kSide, mu0, 0})); }

/// Holds estimates to a tolerance, and to what they say of themselves.
class Held {
 public:
  Held(std::string file, std::string what, std::string asked, double tolerance)
      : verified_(std::move(file), kMethod, std::move(what), std::move(asked)), tolerance_(tolerance) {}
  /// Values below `least` are no part of the demand.
  void check(const OrdinatesEstimate& found, double unit, double reference, double least = 1e-3) {
    const double value = found.value / unit, error = found.error / unit;
    if (reference < least) return;
    INFO("value " << value << " +- " << error << " against " << reference << ", off by " << value / reference - 1);
    CHECK(verified_.within(value, reference, tolerance_));
    ++count_;
    inside_ += std::abs(value - reference) <= error;
    CHECK(std::abs(value - reference) <= 3 * error + 1e-6 * reference);
  }
  ~Held() {
    // Its own error holds nearly always.
    CHECK(inside_ >= std::floor(0.9 * count_));
    char text[120];
    std::snprintf(text, sizeof text, "worst %.1e; within its own error %d of %d", verified_.worst(), inside_, count_);
    verified_.note(text);
  }

 private:
  Verified verified_;
  double tolerance_;
  int count_ = 0, inside_ = 0;
};

}  // namespace

TEST_CASE("d1, d2: ordinates find what slabs reflect, transmit and absorb", "[physics][reference][ordinates]") {
  for (const char* file : {"d1_slab_isotropic_flux.csv", "d2_slab_hg_flux.csv"}) {
    const Csv csv = reference_table(file);
    const bool isotropic = file[1] == '1';
    Held held(file, isotropic ? "R, diffuse T and A of every row" : "R, diffuse T and A, g <= 0.85", "2e-3", 2e-3);
    for (std::size_t row = 0; row < csv.size(); ++row) {
      const auto number = [&](const char* column) { return csv.number(row, column); };
      if (number("g") > 0.9) continue;  // S16 holds little of it
      INFO(file << ", row " << row << ": tau " << number("tau") << ", w " << number("w") << ", mu0 " << number("mu0"));
      const World world = lit({{number("tau"), number("w"), row_phase(csv, row), 0}}, number("mu0"));
      const OrdinatesReferee referee({world, 0}, slab_settings(isotropic ? (number("tau") > 2 ? 128 : 48) : 32, 16));
      held.check(referee.left(2, 1), number("mu0"), number("R"));
      held.check(referee.left(2, 0), number("mu0"), number("T_diffuse"));
      held.check(referee.absorbed(), number("mu0"), number("A"));
    }
  }
}

TEST_CASE("d1, d2: ordinates find radiances", "[physics][reference][ordinates]") {
  for (const char* file : {"d1_slab_isotropic_intensity.csv", "d2_slab_hg_intensity.csv"}) {
    const Csv csv = reference_table(file);
    const bool isotropic = file[1] == '1';
    Held held(file, isotropic ? "radiances above 1e-3" : "radiances above 1e-2, g <= 0.75", isotropic ? "3e-3" : "2e-2",
              isotropic ? 3e-3 : 2e-2);
    for (std::size_t row = 0; row < csv.size();) {
      const auto key = [&](std::size_t i) {
        return std::tuple(csv.number(i, "g"), csv.number(i, "tau"), csv.number(i, "w"), csv.number(i, "mu0"),
                          csv.has("phase") ? csv.text(i, "phase") : "");
      };
      std::size_t end = row;
      while (end < csv.size() && key(end) == key(row)) ++end;
      const auto number = [&](const char* column) { return csv.number(row, column); };
      if (number("g") <= 0.75) {
        INFO(file << ", tau " << number("tau") << ", w " << number("w") << ", mu0 " << number("mu0") << ", g "
                  << number("g"));
        const World world = lit({{number("tau"), number("w"), row_phase(csv, row), 0}}, number("mu0"));
        const OrdinatesReferee referee({world, 0}, slab_settings(isotropic ? (number("tau") > 2 ? 160 : 64) : 32, 16));
        std::vector<Ray> rays;
        for (std::size_t i = row; i < end; ++i) {
          const double mu = csv.number(i, "mu"), phi = csv.has("phi_deg") ? csv.number(i, "phi_deg") * kPi / 180 : 0;
          const double sine = std::sqrt(1 - mu * mu);
          for (const double up : {1.0, -1.0}) {
            const Vec3d travels(sine * std::cos(phi), sine * std::sin(phi), up * mu);
            rays.push_back({{0.5, 0.5, up > 0 ? 1.5 : -0.5}, -travels, 0, kInfinity});
          }
        }
        std::vector<OrdinatesEstimate> found(rays.size());
        referee.radiance(rays, found);
        for (std::size_t i = row; i < end; ++i) {
          INFO("mu " << csv.number(i, "mu"));
          held.check(found[2 * (i - row)], 1, csv.number(i, "I_up_top"), isotropic ? 1e-3 : 1e-2);
          held.check(found[2 * (i - row) + 1], 1, csv.number(i, "I_down_bottom"), isotropic ? 1e-3 : 1e-2);
        }
      }
      row = end;
    }
  }
}

TEST_CASE("d3: ordinates find what isothermal and linear slabs emit", "[physics][reference][ordinates]") {
  const Csv csv = reference_table("d3_slab_thermal.csv");
  Held held("d3_slab_thermal.csv", "fluxes of every row; linear B in 32 voxels", "4e-3", 4e-3);
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const auto number = [&](const char* column) { return csv.number(row, column); };
    INFO("row " << row << ": tau " << number("tau") << ", w " << number("w") << ", g " << number("g"));
    const Layer layer{number("tau"), number("w"), hg(number("g")), number("B_top")};
    const World world(number("B_top") == number("B_bot")
                          ? stack_contents({{layer}, kSide, 0, 0})
                          : linear_source_contents(layer, number("B_top"), number("B_bot"), 32, kSide));
    const OrdinatesReferee referee({world, 0}, slab_settings(32, 16));
    held.check(referee.left(2, 1), kPi, number("Fup_over_pi"));
    held.check(referee.left(2, 0), kPi, number("Fdn_over_pi"));
  }
}

TEST_CASE("d5: ordinates pass slabs up to a depth of 100,000 that do not absorb", "[physics][reference][ordinates]") {
  const Csv csv = reference_table("d5_thick_conservative_isotropic.csv");
  Held resolved("d5_thick_conservative_isotropic.csv", "T for a beam, tau 10 and 100 in 160 cells", "1e-3", 1e-3);
  // Of thicker slabs the cells do not resolve the border where the beam ends, and the error does not see it: on
  // two grids it is missed alike.
  Verified thick("d5_thick_conservative_isotropic.csv", kMethod, "T for a beam, tau 1e3 to 1e5 in 48 cells", "1 %");
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const double tau = csv.number(row, "tau"), mu0 = csv.number(row, "mu0");
    if (mu0 < 0 || tau > 2e5) continue;
    INFO("tau " << tau << ", mu0 " << mu0);
    const World world = lit({{tau, 1, hg(0), 0}}, mu0);
    if (tau < 200) {
      const OrdinatesReferee referee({world, 0}, slab_settings(160, 16));
      resolved.check(referee.left(2, 0), mu0, csv.number(row, "T_doubling") - std::exp(-tau / mu0));
    } else {
      const OrdinatesSolution solution = solve_ordinates({world, 0}, slab_settings(48, 16));
      CHECK(thick.within(solution.powers().left[2][0] / mu0, csv.number(row, "T_asymptotic"), 0.01));
    }
  }
}

TEST_CASE("d6, d7: ordinates agree with DISORT's problems and with stacks of layers",
          "[physics][reference][ordinates]") {
  const Csv csv = reference_table("d6_disort_published.csv");
  {
    Held held("d6_disort_published.csv", "fluxes of problems 1 to 4, converged columns", "2e-3", 2e-3);
    for (std::size_t row = 0; row < csv.size(); ++row) {
      const auto number = [&](const char* column) { return csv.number(row, column); };
      if (csv.text(row, "test")[0] > '4') continue;
      INFO("problem " << csv.text(row, "test"));
      const World world = lit({{number("tau"), number("w"), disort_phase(csv.text(row, "test")[0]), 0}}, number("mu0"));
      const OrdinatesReferee referee({world, 0}, slab_settings(number("tau") > 2 ? 128 : 48, 16));
      held.check(referee.left(2, 1), 1, number("Fup") / number("F0"));
      held.check(referee.left(2, 0), 1, number("Fdn_diffuse") / number("F0"));
    }
  }
  const Csv stacks = reference_table("d7_two_layer_slab.csv");
  Held held("d7_two_layer_slab.csv", "R and diffuse T of every row in a beam; R + T in even light", "2e-3", 2e-3);
  for (std::size_t row = 0; row < stacks.size(); ++row) {
    const std::vector<Layer> layers = row_layers(stacks, row);
    const bool beam = stacks.text(row, "illum") == "beam";
    const double mu0 = stacks.number(row, "mu0");
    INFO(stacks.text(row, "case") << " " << mu0);
    const World world(stack_contents({layers, kSide, beam ? mu0 : 0, beam ? 0.0 : 1.0}));
    const OrdinatesReferee referee({world, 0}, slab_settings(32 * static_cast<int>(layers.size()), 16));
    if (beam) {
      held.check(referee.left(2, 1), mu0, stacks.number(row, "R"));
      held.check(referee.left(2, 0), mu0, stacks.number(row, "T"), 2e-3);
    } else {
      held.check(referee.left(2, 1), kPi, stacks.number(row, "R") + stacks.number(row, "T"));
    }
  }
}

TEST_CASE("h3: ordinates see nearly conservative slabs absorb", "[physics][reference][ordinates]") {
  const Csv csv = reference_table("h3_near_conservative_slab.csv");
  Held held("h3_near_conservative_slab.csv", "A of every row", "6e-3", 6e-3);
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const auto number = [&](const char* column) { return csv.number(row, column); };
    const double tau = number("tau"), mu0 = number("mu0");
    INFO("tau " << tau << ", 1 - w " << number("one_minus_w") << ", mu0 " << mu0 << ", g " << number("g"));
    const World world = lit({{tau, 1 - number("one_minus_w"), hg(number("g")), 0}}, mu0);
    const OrdinatesReferee referee({world, 0}, slab_settings(number("g") > 0 ? 32 : tau > 20 ? 160 : 48, 16));
    held.check(referee.absorbed(), mu0 * number("one_minus_w"), number("mean_collisions"), 0);
  }
}

TEST_CASE("b1, b2: ordinates find spheres of voxels, the closer the finer they are",
          "[physics][reference][ordinates]") {
  const auto left = [](double radius, double albedo, bool source, int cells) {
    WorldContents contents = sphere_contents(radius, albedo, hg(0), cells);
    if (source)
      contents.clouds[0].emission = {1 / (4 * kPi)};
    else
      contents.clouds[0].source = {1};
    const World world(std::move(contents));
    OrdinatesSettings settings;
    settings.cells = Vec3i(cells);
    const OrdinatesSolution solution = solve_ordinates({world, 0}, settings);
    double out = 0;
    for (const auto& sides : solution.powers().left) out += sides[0] + sides[1];
    return out / (source ? solution.powers().emitted : 4 * kPi * kPi * radius * radius);
  };
  const Csv inner = reference_table("b1_sphere_internal_source.csv"),
            thermal = reference_table("b2_sphere_isothermal_scattering.csv");
  for (const auto& [file, csv, column] : {std::tuple("b1_sphere_internal_source.csv", &inner, "P_escape"),
                                          std::tuple("b2_sphere_isothermal_scattering.csv", &thermal, "emissivity")}) {
    Verified verified(file, kMethod, std::string(column) + ", R 0.5 to 5, w 0.9; 24 cells across, S8",
                      "1 % (R = 5: 3 %)");
    for (std::size_t row = 0; row < csv->size(); ++row) {
      const double radius = csv->number(row, "R"), albedo = csv->number(row, "w");
      if (radius < 0.3 || radius > 6 || albedo != 0.9) continue;
      INFO(file << " R " << radius);
      CHECK(verified.within(left(radius, albedo, column[0] == 'P', 24), csv->number(row, column),
                            radius < 3 ? 0.01 : 0.03));
    }
  }
  Verified verified("b2_sphere_isothermal_scattering.csv", kMethod,
                    "emissivity of R = 2, w = 0.5 with 8, 16 and 32 cells across, S8", "1 % at 32, falling");
  std::size_t row = 0;
  while (thermal.number(row, "R") != 2 || thermal.number(row, "w") != 0.5) ++row;
  const double reference = thermal.number(row, "emissivity");
  std::vector<double> errors;
  for (const int cells : {8, 16, 32}) errors.push_back(left(2, 0.5, false, cells) / reference - 1);
  INFO(errors[0] << " " << errors[1] << " " << errors[2]);
  CHECK(std::abs(errors[1]) < 0.7 * std::abs(errors[0]));
  CHECK(std::abs(errors[2]) < 0.7 * std::abs(errors[1]));
  CHECK(verified.within(reference * (1 + errors[2]), reference, 0.01));
  char text[100];
  std::snprintf(text, sizeof text, "off by %+.2f, %+.2f, %+.2f %%", 100 * errors[0], 100 * errors[1], 100 * errors[2]);
  verified.note(text);
}

TEST_CASE("e2: ordinates find boxes", "[physics][reference][ordinates]") {
  const Csv csv = reference_table("e2_boxes.csv");
  Verified verified("e2_boxes.csv", kMethod, "P1 and P4: every side, T, A; 24 (P4: 16) cells a side, S12", "1 %");
  const auto row_of = [&](const char* name, const char* quantity) {
    std::size_t row = 0;
    while (csv.text(row, "case") != name || csv.text(row, "quantity") != quantity) ++row;
    return csv.number(row, "value");
  };
  {
    WorldContents contents = box_contents({1, 1, 1}, 1, {{10, 0.9}}, hg(0), [](const Vec3i&) { return 0; });
    contents.sun = Sun{{0, 0, 1}, {1}, 0};
    const World world(std::move(contents));
    OrdinatesSettings settings;
    settings.cells = Vec3i(24);
    settings.order = 12;
    const OrdinatesSolution solution = solve_ordinates({world, 0}, settings);
    const OrdinatesPowers& powers = solution.powers();
    CHECK(verified.within(powers.left[2][1], row_of("box_P1", "R"), 0.01));
    CHECK(verified.within(powers.left[2][0] + std::exp(-10.0), row_of("box_P1", "T"), 0.01));
    CHECK(verified.within(powers.absorbed + powers.first_absorbed, row_of("box_P1", "A"), 0.01));
    for (const int axis : {0, 1}) {
      for (const double side : powers.left[static_cast<std::size_t>(axis)])
        CHECK(verified.within(side, row_of("box_P1", "side_xmin"), 0.01));
    }
  }
  WorldContents contents = box_contents({1, 1, 1}, 1, {{8, 0.95}}, hg(0), [](const Vec3i&) { return 0; });
  contents.clouds[0].octree = exact_octree(lattice(
      {2, 2, 2}, Vec3d(0.5), {"density"}, [](int, const Vec3i& v) { return (v.x + v.y + v.z) % 2 ? 1.0f : 0.0f; }));
  contents.clouds[0].period_m = {1, 1};
  contents.sky = {1};
  const World world(std::move(contents));
  OrdinatesSettings settings;
  settings.cells = Vec3i(16);
  settings.order = 12;
  const OrdinatesSolution solution = solve_ordinates({world, 0}, settings);
  CHECK(verified.within(solution.powers().left[2][1] / kPi, row_of("box_P4", "R") + row_of("box_P4", "T"), 0.01));
  CHECK(verified.within(solution.powers().absorbed / (2 * kPi), row_of("box_P4", "A"), 0.01));
}

TEST_CASE("e1: ordinates find the step cloud's means", "[physics][reference][ordinates]") {
  const Csv csv = reference_table("e1_i3rc_step_cloud_mean.csv");
  Verified verified("e1_i3rc_step_cloud_mean.csv", kMethod, "R and A of experiment 4; 32 x 1 x 24 cells, S12", "1 %");
  for (const int experiment : {4}) {
    const double mu0 = 0.5, albedo = 0.99;
    WorldContents contents = box_contents({1, 1, 1}, 1, {{1, albedo}}, hg(0.85), [](const Vec3i&) { return 0; });
    contents.clouds[0].octree = exact_octree(lattice({32, 1, 1}, {500.0 / 32, 500, 250}, {"density"},
                                                     [](int, const Vec3i& v) { return v.x < 16 ? 0.008f : 0.072f; }));
    contents.clouds[0].period_m = {500, 500};
    contents.sun = Sun{{-std::sqrt(1 - mu0 * mu0), 0, mu0}, {1}, 0};
    const World world(std::move(contents));
    OrdinatesSettings settings;
    settings.cells = Vec3i(32, 1, 24);
    settings.order = 12;
    const OrdinatesSolution solution = solve_ordinates({world, 0}, settings);
    const double unit = mu0 * 500 * 500;
    for (std::size_t row = 0; row < csv.size(); ++row) {
      if (static_cast<int>(csv.number(row, "exp")) != experiment) continue;
      INFO("experiment " << experiment << " " << csv.text(row, "quantity"));
      if (csv.text(row, "quantity") == "R")
        CHECK(verified.within(solution.powers().left[2][1] / unit, csv.number(row, "value"), 0.01));
      if (csv.text(row, "quantity") == "A") {
        CHECK(verified.within((solution.powers().absorbed + solution.powers().first_absorbed) / unit,
                              csv.number(row, "value"), 0.01));
      }
    }
  }
}
