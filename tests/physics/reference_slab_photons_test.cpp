// Slabs of the reference tables by photons that cross planes: reflection, transmission, absorption and
// thermal emission without a density estimate, so without its bias.
#include <catch2/catch.hpp>

#include "tests/support/photon_measures.h"
#include "tests/support/reference_rules.h"
#include "tests/support/reference_worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

constexpr double kWide = 1000;  // m, of the periodic cell: flights rarely leave it
const char* const kMethod = "photon tracing";

SlabLight lit(const std::vector<Layer>& layers, double mu0, std::uint64_t photons, std::uint64_t seed) {
  const Stack stack{layers, kWide, mu0, 0};
  return slab_light(World(stack_contents(stack)), stack.top(), kWide, mu0, photons, seed);
}

AgreeOptions rule(double reference, double error, double comparisons) {
  return held_to(reference, error, comparisons, kManyBatches);
}

}  // namespace

TEST_CASE("d1, d2: photons are reflected, transmitted and absorbed by every slab", "[physics][reference][slab]") {
  for (const char* file : {"d1_slab_isotropic_flux.csv", "d2_slab_hg_flux.csv"}) {
    const Csv csv = reference_table(file);
    Verified verified(file, kMethod, "R, T and A of every row", "SE < 0.4 % of the light each, 0.1 % together");
    for (std::size_t row = 0; row < csv.size(); ++row) {
      const auto number = [&](const char* column) { return csv.number(row, column); };
      const PhaseFunction phase = row_phase(csv, row);
      INFO(file << ", row " << row << ": tau " << number("tau") << ", w " << number("w") << ", mu0 " << number("mu0"));
      const SlabLight found = lit({{number("tau"), number("w"), phase, 0}}, number("mu0"), 30000, row);
      const double transmitted = number("T_direct") + number("T_diffuse");
      const auto check = [&](const BatchMean& share, double reference) {
        // So few photons that their number is no mean with a normal error are left to the whole.
        if (reference < 0.01) return;
        CHECK(verified.mean(share, reference, rule(reference, 0.004, 3 * static_cast<double>(csv.size()))));
      };
      check(found.up, number("R"));
      check(found.down, transmitted);
      if (number("w") < 1) {
        check(found.absorbed, number("A"));
      } else {
        CHECK(found.absorbed.mean == 0);
      }
    }
    check_common(verified, 0.001);
  }
}

TEST_CASE("d3: isothermal and linear slabs emit what the table says", "[physics][reference][slab]") {
  const Csv csv = reference_table("d3_slab_thermal.csv");
  Verified verified("d3_slab_thermal.csv", kMethod, "fluxes of every row; linear B in 32 voxels",
                    "SE < 4 % each, 0.3 % together");
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const auto number = [&](const char* column) { return csv.number(row, column); };
    INFO("row " << row << ": tau " << number("tau") << ", w " << number("w") << ", g " << number("g") << ", B "
                << number("B_top") << " to " << number("B_bot"));
    const Layer layer{number("tau"), number("w"), hg(number("g")), number("B_top")};
    const World world(number("B_top") == number("B_bot")
                          ? stack_contents({{layer}, kWide, 0, 0})
                          : linear_source_contents(layer, number("B_top"), number("B_bot"), 32, kWide));
    const SlabLight found = slab_light(world, 1, kWide, kPi, number("tau") > 10 ? 6000 : 20000, row);
    for (const auto& [flux, column] : {std::pair(found.up, "Fup_over_pi"), std::pair(found.down, "Fdn_over_pi")}) {
      CHECK(verified.mean(flux, number(column),
                          rule(number(column), 0.04 * number(column), 2 * static_cast<double>(csv.size()))));
    }
  }
  check_common(verified, 0.003);
}

TEST_CASE("d5: photons find their way through thick slabs that do not absorb", "[physics][reference][slab]") {
  const Csv csv = reference_table("d5_thick_conservative_isotropic.csv");
  Verified verified("d5_thick_conservative_isotropic.csv", kMethod, "T for a beam, tau 10 and 100", "SE < 12 % each");
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const double tau = csv.number(row, "tau"), mu0 = csv.number(row, "mu0"), reference = csv.number(row, "T_doubling");
    if (tau > 100 || mu0 < 0) continue;  // thicker is work for the ordinates
    INFO("tau " << tau << ", mu0 " << mu0);
    const SlabLight found = lit({{tau, 1, hg(0), 0}}, mu0, tau > 50 ? 10000 : 40000, row);
    CHECK(verified.mean(found.down, reference, rule(reference, 0.12 * reference, 4)));
  }
}

TEST_CASE("d6: photons agree with DISORT's problems, converged", "[physics][reference][slab]") {
  const Csv csv = reference_table("d6_disort_published.csv");
  Verified verified("d6_disort_published.csv", kMethod, "fluxes of every row, converged columns",
                    "SE < 0.6 % of the light each, 0.2 % together");
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const auto number = [&](const char* column) { return csv.number(row, column); };
    const double incident = number("mu0") * number("F0");
    INFO("problem " << csv.text(row, "test"));
    const SlabLight found = lit({{number("tau"), number("w"), disort_phase(csv.text(row, "test")[0]), 0}},
                                number("mu0"), number("tau") > 50 ? 8000 : 40000, row);
    for (const auto& [flux, reference] :
         {std::pair(found.up, number("Fup")), std::pair(found.down, number("Fdn_diffuse") + number("Fdirect"))}) {
      if (reference / incident < 0.01) continue;
      CHECK(verified.mean(flux, reference / incident, rule(reference / incident, 0.006, 26)));
    }
  }
  check_common(verified, 0.002);
}

TEST_CASE("d7: photons pass stacks of layers", "[physics][reference][slab]") {
  const Csv csv = reference_table("d7_two_layer_slab.csv");
  Verified verified("d7_two_layer_slab.csv", kMethod, "R and T of every row",
                    "SE < 0.4 % of the light each (even light 1 %), 0.2 % together");
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const std::vector<Layer> layers = row_layers(csv, row);
    INFO(csv.text(row, "case") << " " << csv.text(row, "illum") << " " << csv.text(row, "mu0"));
    const double reflected = csv.number(row, "R");
    if (csv.text(row, "illum") == "beam") {
      const SlabLight found = lit(layers, csv.number(row, "mu0"), 40000, row);
      const double transmitted = csv.number(row, "T") + csv.number(row, "T_direct");
      CHECK(verified.mean(found.up, reflected, rule(reflected, 0.004, 40)));
      if (transmitted > 0.01) CHECK(verified.mean(found.down, transmitted, rule(transmitted, 0.004, 40)));
    } else {
      // Even light from above and below: what goes up is the reflection of the one and the transmission of
      // the other, which is the same from either side.
      const double both = reflected + csv.number(row, "T");
      const Stack stack{layers, kWide, 0, 1};
      const SlabLight found = slab_light(World(stack_contents(stack)), stack.top(), kWide, kPi, 40000, row);
      CHECK(verified.mean(found.up, both, rule(both, 0.01, 40)));
    }
  }
  check_common(verified, 0.002);
}

TEST_CASE("h2: straight forward and straight back are the rod", "[physics][reference][slab]") {
  const Csv csv = reference_table("h2_rod_limits.csv");
  Verified verified("h2_rod_limits.csv", kMethod, "R, T and A up to t = 1000",
                    "SE < 1 % of the light each, 0.2 % together");
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const auto number = [&](const char* column) { return csv.number(row, column); };
    const std::string& model = csv.text(row, "model");
    INFO(model << ", w " << number("w") << ", t " << number("t"));
    if (number("t") > 1e3) continue;  // 1e6 collisions of every photon
    const double forward = 0.5 * (1 + number("g"));
    const PhaseFunction phase = model[0] == 'g' ? PhaseFunction::henyey_greenstein(number("g"))
                                                : PhaseFunction::double_henyey_greenstein(1, -1, forward);
    const std::uint64_t photons = number("t") > 100 ? 1000 : 20000;
    const SlabLight found = lit({{number("t"), number("w"), phase, 0}}, 1, photons, row);
    const auto check = [&](const BatchMean& share, double reference) {
      if (reference <= 0 || reference >= 1 || reference < 100.0 / photons || reference > 1 - 100.0 / photons) {
        CHECK(share.mean == Approx(reference).margin(0.01));
      } else {
        CHECK(verified.mean(share, reference, rule(reference, 0.01, 50)));
      }
    };
    check(found.up, number("R"));
    check(found.down, number("T"));
    check(found.absorbed, number("A"));
  }
  check_common(verified, 0.003);
}

TEST_CASE("h3: nearly conservative slabs absorb by the number of collisions", "[physics][reference][slab]") {
  const Csv csv = reference_table("h3_near_conservative_slab.csv");
  Verified verified("h3_near_conservative_slab.csv", kMethod, "mean number of collisions, R and T; of tau 100 mu0 = 1",
                    "SE < 3 % each (10 % at tau 100), 0.2 % together");
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const auto number = [&](const char* column) { return csv.number(row, column); };
    const double tau = number("tau"), mu0 = number("mu0"), absorption = number("one_minus_w");
    INFO("tau " << tau << ", 1 - w " << absorption << ", mu0 " << mu0 << ", g " << number("g"));
    if (tau > 50 && mu0 < 1) continue;
    const SlabLight found = lit({{tau, 1 - absorption, hg(number("g")), 0}}, mu0, tau > 50 ? 4000 : 10000, row);
    // The first collision is sunlight's own and is not stored.
    BatchMean collisions = found.collisions;
    collisions.mean -= std::expm1(-tau / mu0);
    const double reference = number("mean_collisions");
    CHECK(verified.mean(collisions, reference, rule(reference, (tau > 50 ? 0.1 : 0.03) * reference, 150)));
    CHECK(verified.mean(found.up, number("R"), rule(number("R"), 0.01, 150)));
    if (number("T") > 0.02) CHECK(verified.mean(found.down, number("T"), rule(number("T"), 0.01, 150)));
  }
  check_common(verified, 0.002);
}
