// Slabs of the reference tables by the path tracer: fluxes, radiances and, by Kirchhoff, absorption.
#include <catch2/catch.hpp>

#include "tests/support/path_measures.h"
#include "tests/support/reference_rules.h"
#include "tests/support/reference_worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

constexpr double kWide = 1000;  // m, of the periodic cell
const char* const kMethod = "path tracer";

World lit(const std::vector<Layer>& layers, double mu0) { return World(stack_contents({layers, kWide, mu0, 0})); }

/// The same layers with a Planck radiance of 1: what they send along a direction is what they absorb of light
/// that comes against it.
World glowing(std::vector<Layer> layers) {
  for (Layer& layer : layers) layer.source = 1;
  return World(stack_contents({layers, kWide, 0, 0}));
}

/// Light of radiance 1 from above alone: below lies a black layer. What leaves upward at a cosine is then the
/// reflection of a beam that comes in at it, and what leaves downward the transmission, by reciprocity.
World evenly_lit(std::vector<Layer> layers) {
  layers.push_back({60, 0, PhaseFunction::isotropic(), 0});
  return World(stack_contents({layers, kWide, 0, 1}));
}
Ray seen_above(double mu) { return view(3, true, mu, 0); }
Ray seen_below(double mu) {
  Ray ray = view(0, false, mu, 0);
  ray.origin.z = 1;
  return ray;
}

AgreeOptions rule(double reference, double error, double comparisons) {
  return held_to(reference, error, comparisons, kPathBatches);
}

BatchMean scaled(const BatchMean& mean, double factor) { return {mean.mean * factor, mean.standard_error * factor}; }

}  // namespace

TEST_CASE("d1, d2: paths find every slab's reflection, transmission and absorption", "[physics][reference][slab]") {
  for (const char* file : {"d1_slab_isotropic_flux.csv", "d2_slab_hg_flux.csv"}) {
    const Csv csv = reference_table(file);
    Verified sunlit(file, kMethod, "R and diffuse T of sunlight, g <= 0.75",
                    "SE < 3 % of the light each, 0.3 % together");
    Verified even(file, kMethod, "R and T by even light, A by Kirchhoff, every row",
                  "SE < 1 % of the light each, 0.1 % together");
    for (std::size_t row = 0; row < csv.size(); ++row) {
      const auto number = [&](const char* column) { return csv.number(row, column); };
      const double tau = number("tau"), mu0 = number("mu0"), comparisons = 3 * static_cast<double>(csv.size());
      INFO(file << ", row " << row << ": tau " << tau << ", w " << number("w") << ", mu0 " << mu0);
      const Layer layer{tau, number("w"), row_phase(csv, row), 0};
      // Less comes from so few paths that its error is not known.
      const auto check_sunlit = [&](const BatchMean& share, double reference) {
        if (reference < 0.004) return;
        CHECK(sunlit.mean(share, reference, rule(reference, 0.03, comparisons)));
      };
      const auto check_even = [&](const BatchMean& share, double reference) {
        if (reference < 0.02 || reference > 0.98) return;
        CHECK(even.mean(share, reference, rule(reference, 0.01, comparisons)));
      };
      const World world = lit({layer}, mu0);
      if (number("g") <= 0.75) {
        check_sunlit(scaled(path_exitance(world, 1, true, 4800, 3 * row), kPi / mu0), number("R"));
        check_sunlit(scaled(path_exitance(world, 1, false, 4800, 3 * row + 1), kPi / mu0), number("T_diffuse"));
      }
      const World above = evenly_lit({layer});
      check_even(path_radiance_along(above, seen_above(mu0), 4800, 3 * row), number("R"));
      check_even(path_radiance_along(above, seen_below(mu0), 4800, 3 * row + 1),
                 number("T_direct") + number("T_diffuse"));
      if (number("w") < 1)
        check_even(path_radiance_along(glowing({layer}), view(1, true, mu0, 0), 2400, 3 * row + 2), number("A"));
    }
    check_common(sunlit, 0.003);
    check_common(even, 0.0012);
  }
}

TEST_CASE("d1, d2: paths resolve 0.1 %", "[physics][reference][slab]") {
  for (const auto& [file, row] :
       {std::pair("d1_slab_isotropic_flux.csv", 19), std::pair("d1_slab_isotropic_flux.csv", 31),
        std::pair("d2_slab_hg_flux.csv", 5), std::pair("d2_slab_hg_flux.csv", 10)}) {
    const Csv csv = reference_table(file);
    const std::size_t i = static_cast<std::size_t>(row);
    const auto number = [&, &csv = csv](const char* column) { return csv.number(i, column); };
    char name[80];
    std::snprintf(name, sizeof name, "R, T, A at tau %g, w %g, g %g, mu0 %g", number("tau"), number("w"), number("g"),
                  number("mu0"));
    Verified verified(file, kMethod, name, "3 SE, SE < 0.1 % of the light");
    const double mu0 = number("mu0");
    INFO(file << ", " << name);
    const Layer layer{number("tau"), number("w"), row_phase(csv, i), 0};
    const World above = evenly_lit({layer}), glow = glowing({layer});
    for (const auto& [found, reference] :
         {std::pair(path_radiance_along(above, seen_above(mu0), 300000, 1), number("R")),
          std::pair(path_radiance_along(above, seen_below(mu0), 300000, 2), number("T_direct") + number("T_diffuse")),
          std::pair(path_radiance_along(glow, view(1, true, mu0, 0), 100000, 3), number("A"))}) {
      if (reference < 1e-6) continue;  // nothing absorbs
      CHECK(verified.mean(found, reference, rule(reference, 0.001, 12)));
      CHECK(std::abs(found.mean - reference) < 3 * found.standard_error);
    }
  }
}

TEST_CASE("d1, d2: paths find the radiance in every direction", "[physics][reference][slab]") {
  for (const char* file : {"d1_slab_isotropic_intensity.csv", "d2_slab_hg_intensity.csv"}) {
    const Csv csv = reference_table(file);
    Verified verified(file, kMethod, "every radiance above 1e-3, g <= 0.85", "SE < 20 % or 0.04 each, 0.2 % together");
    for (std::size_t row = 0; row < csv.size(); ++row) {
      const auto number = [&](const char* column) { return csv.number(row, column); };
      const double tau = number("tau"), mu = number("mu"), phi = csv.has("phi_deg") ? number("phi_deg") * kPi / 180 : 0;
      INFO(file << ", row " << row << ": tau " << tau << ", w " << number("w") << ", mu0 " << number("mu0") << ", mu "
                << mu);
      const World world = lit({{tau, number("w"), row_phase(csv, row), 0}}, number("mu0"));
      const int count = tau > 5 ? 480 : 960;
      for (const bool up : {true, false}) {
        const double reference = number(up ? "I_up_top" : "I_down_bottom");
        if (reference < 1e-3 || number("g") > 0.9) continue;
        const BatchMean found = path_radiance_along(world, view(1, up, mu, phi), count, 2 * row + up, 2);
        CHECK(verified.mean(found, reference,
                            rule(reference, std::max(0.2 * reference, 0.04), 2 * static_cast<double>(csv.size()))));
      }
    }
    check_common(verified, 0.002);
  }
}

TEST_CASE("d3: paths find what isothermal and linear slabs emit", "[physics][reference][slab]") {
  const Csv csv = reference_table("d3_slab_thermal.csv");
  Verified fluxes("d3_slab_thermal.csv", kMethod, "fluxes of every row; linear B in 64 voxels",
                  "SE < 8 % each, 0.1 % together");
  Verified radiances("d3_slab_thermal.csv", kMethod, "radiances of every row; linear B in 64 voxels",
                     "SE < 20 % each, 0.1 % together");
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const auto number = [&](const std::string& column) { return csv.number(row, column); };
    const double tau = number("tau"), top = number("B_top"), bottom = number("B_bot");
    INFO("row " << row << ": tau " << tau << ", w " << number("w") << ", g " << number("g") << ", B " << top << " to "
                << bottom);
    const Layer layer{tau, number("w"), hg(number("g")), top};
    const World world(top == bottom ? stack_contents({{layer}, kWide, 0, 0})
                                    : linear_source_contents(layer, top, bottom, 64, kWide));
    for (const bool up : {true, false}) {
      const double flux = number(up ? "Fup_over_pi" : "Fdn_over_pi");
      CHECK(fluxes.mean(path_exitance(world, 1, up, tau > 10 ? 1920 : 2880, 2 * row + up), flux,
                        rule(flux, 0.08 * flux, 72)));
      for (const char* mu : {"0.1", "0.3", "0.5", "0.7", "0.9", "1"}) {
        const double radiance = number(std::string(up ? "up_mu" : "dn_mu") + mu);
        const BatchMean found = path_radiance_along(world, view(1, up, std::atof(mu), 0), 240, 2 * row + up, 4);
        CHECK(radiances.mean(found, radiance, rule(radiance, 0.2 * radiance, 432)));
      }
    }
  }
  check_common(fluxes, 0.001);
  check_common(radiances, 0.001);
}

TEST_CASE("d3: voxels of a linear source converge at second order by paths", "[physics][reference][slab]") {
  // The same random numbers for every number of voxels: their noise is common and drops out of differences.
  const Csv csv = reference_table("d3_slab_thermal.csv");
  const std::size_t row = 4;  // tau 1, w 0.9, B from 0 to 1
  REQUIRE(csv.number(row, "tau") == 1);
  Verified verified("d3_slab_thermal.csv", kMethod, "order of convergence of the flux with the voxels of linear B",
                    "2 +- 0.2");
  const Layer layer{1, 0.9, hg(0), 0};
  const auto flux = [&](int voxels) {
    return path_exitance(World(linear_source_contents(layer, 0, 1, voxels, kWide)), 1, true, 48000, 5).mean;
  };
  const double fine = flux(64);
  std::vector<double> errors;
  for (const int voxels : {1, 2, 4, 8}) errors.push_back(flux(voxels) - fine);
  for (std::size_t i = 1; i < errors.size(); ++i) {
    const double order = std::log2(errors[i - 1] / errors[i]);
    INFO(errors[i - 1] << " to " << errors[i]);
    CHECK(verified.within(order, 2, 0.1));
  }
}

TEST_CASE("d4: paths find what half-infinite media reflect and emit", "[physics][reference][slab]") {
  const Csv csv = reference_table("d4_semi_infinite_isotropic.csv");
  Verified verified("d4_semi_infinite_isotropic.csv", kMethod,
                    "radiances and emissivity, at tau 30 (w < 0.99), 100 and 200", "SE < 25 % each, 0.3 % together");
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const auto number = [&](const char* column) { return csv.number(row, column); };
    const double w = number("w"), mu0 = number("mu0"), tau = w < 0.99 ? 30 : w < 0.999 ? 100 : 200;
    INFO("w " << w << ", mu0 " << mu0);
    const Layer layer{tau, w, hg(0), 0};
    if (w > 0) {
      const World world = lit({layer}, mu0);
      for (const char* mu : {"0.1", "0.5", "1"}) {
        double reference = number((std::string("I_mu") + mu).c_str());
        // What a slab without absorption lets through is missing: mu0 H(mu0) H(mu) / (4 pi (tau + 2 q)), by
        // balance with the transmission of file d5 and the shape H of what leaves (Hopf).
        if (w == 1) {
          const std::size_t first = row - row % 6;  // six cosines for each albedo
          const double other = csv.number(first + (mu[0] == '1' ? 5 : mu[2] == '1' ? 0 : 2), "H");
          reference -= mu0 * number("H") * other / (4 * kPi * (tau + 2 * 0.7104460895987637));
        }
        const BatchMean found =
            path_radiance_along(world, view(1, true, std::atof(mu), 0), w > 0.99 ? 96 : 384, row, 4);
        CHECK(verified.mean(found, reference, rule(reference, 0.25 * reference, 120)));
      }
    }
    if (w < 1) {
      const BatchMean found =
          path_radiance_along(glowing({layer}), view(1, true, mu0, 0), w > 0.99 ? 96 : 384, row + 100, 4);
      if (w == 0) {
        CHECK(found.mean == Approx(1).epsilon(1e-12));
      } else {
        CHECK(verified.mean(found, number("emissivity"), rule(number("emissivity"), 0.25 * number("emissivity"), 120)));
      }
    }
  }
  check_common(verified, 0.003);
}

TEST_CASE("d5: paths pass thick slabs that do not absorb", "[physics][reference][slab]") {
  const Csv csv = reference_table("d5_thick_conservative_isotropic.csv");
  Verified verified("d5_thick_conservative_isotropic.csv", kMethod, "T for a beam, tau 10 and 100",
                    "SE < 5 % (tau 10), 20 % (tau 100)");
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const double tau = csv.number(row, "tau"), mu0 = csv.number(row, "mu0"), reference = csv.number(row, "T_doubling");
    if (tau > 100 || mu0 < 0) continue;  // thicker is work for the ordinates
    INFO("tau " << tau << ", mu0 " << mu0);
    const BatchMean found = path_exitance(lit({{tau, 1, hg(0), 0}}, mu0), 1, false, 12000, row);
    const double diffuse = reference - std::exp(-tau / mu0);
    CHECK(verified.mean(scaled(found, kPi / mu0), diffuse, rule(diffuse, (tau > 50 ? 0.2 : 0.05) * diffuse, 4)));
  }
}

TEST_CASE("d6: paths agree with DISORT's problems, converged", "[physics][reference][slab]") {
  const Csv csv = reference_table("d6_disort_published.csv");
  Verified verified("d6_disort_published.csv", kMethod, "fluxes of every row, converged columns",
                    "SE < 3 % or 2 % of the light each, 0.2 % together");
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const auto number = [&](const char* column) { return csv.number(row, column); };
    INFO("problem " << csv.text(row, "test"));
    const World world = lit({{number("tau"), number("w"), disort_phase(csv.text(row, "test")[0]), 0}}, number("mu0"));
    for (const bool up : {true, false}) {
      const double reference = number(up ? "Fup" : "Fdn_diffuse") / number("F0");
      if (reference < 1e-3) continue;
      if (number("tau") > 50) {  // a forward peak towards the sun is a rare find: even light instead
        const World above = evenly_lit({{number("tau"), number("w"), disort_phase(csv.text(row, "test")[0]), 0}});
        const double share = reference / number("mu0");
        CHECK(verified.mean(path_radiance_along(above, up ? seen_above(1) : seen_below(1), 4800, row), share,
                            rule(share, 0.01, 26)));
        continue;
      }
      const BatchMean found = path_exitance(world, 1, up, number("tau") > 20 ? 6000 : 12000, 2 * row + up);
      CHECK(verified.mean(scaled(found, kPi), reference,
                          rule(reference, std::max(0.03 * reference, 0.02 * number("mu0") / kPi), 26)));
    }
  }
  check_common(verified, 0.002);
}

TEST_CASE("d7: paths pass stacks of layers", "[physics][reference][slab]") {
  const Csv csv = reference_table("d7_two_layer_slab.csv");
  Verified verified("d7_two_layer_slab.csv", kMethod, "R and T of every row",
                    "SE < 2 % or 1 % of the light each, 0.15 % together");
  for (std::size_t row = 0; row < csv.size(); ++row) {
    std::vector<Layer> layers = row_layers(csv, row);
    INFO(csv.text(row, "case") << " " << csv.text(row, "illum") << " " << csv.text(row, "mu0"));
    const bool beam = csv.text(row, "illum") == "beam";
    // Even light from above alone comes from a black layer on top, at whose lower face the slab looks.
    if (!beam) layers.insert(layers.begin(), Layer{40, 0, hg(0), 1});
    const double mu0 = csv.number(row, "mu0"), top = static_cast<double>(layers.size());
    const World world = beam ? lit(layers, mu0) : World(stack_contents({layers, kWide, 0, 0}));
    const double unit = beam ? kPi / mu0 : 1;
    const auto check = [&](const BatchMean& found, double reference) {
      CHECK(verified.mean(scaled(found, unit), reference, rule(reference, std::max(0.02 * reference, 0.01), 40)));
    };
    check(path_exitance(world, top, false, 12000, 2 * row), csv.number(row, "T"));
    if (beam) {
      check(path_exitance(world, top, true, 12000, 2 * row + 1), csv.number(row, "R"));
    } else {
      // From just above the slab downward.
      const double face = top - 1;
      check(path_average(world, 12000, 2 * row + 1,
                         [&](const auto& u) {
                           Ray ray = view(0, true, std::sqrt(u[0]), 2 * kPi * u[1]);
                           ray.origin.z = face;
                           return WeightedRay{ray, 1};
                         }),
            csv.number(row, "R"));
    }
  }
  check_common(verified, 0.0015);
}

TEST_CASE("h2: paths go straight forward and straight back", "[physics][reference][slab]") {
  const Csv csv = reference_table("h2_rod_limits.csv");
  Verified verified("h2_rod_limits.csv", kMethod, "A by Kirchhoff, w < 1", "SE < 3 % each");
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const auto number = [&](const char* column) { return csv.number(row, column); };
    const std::string& model = csv.text(row, "model");
    INFO(model << ", w " << number("w") << ", g " << number("g") << ", t " << number("t"));
    if (number("t") > 1e3) continue;  // 1e6 collisions of every path
    const PhaseFunction phase = model[0] == 'g'
                                    ? PhaseFunction::henyey_greenstein(number("g"))
                                    : PhaseFunction::double_henyey_greenstein(1, -1, 0.5 * (1 + number("g")));
    // No path could meet a sun without size: the light is that of the rod itself, seen straight from above.
    const Layer layer{number("t"), number("w"), phase, 1};
    const double reference = number("A");
    if (number("w") == 1) continue;
    const BatchMean found = path_radiance_along(glowing({layer}), view(1, true, 1, 0), 4800, row);
    CHECK(verified.mean(found, reference, rule(reference, 0.03 * reference, 14)));
  }
}

TEST_CASE("h3: paths see nearly conservative slabs absorb", "[physics][reference][slab]") {
  const Csv csv = reference_table("h3_near_conservative_slab.csv");
  Verified verified("h3_near_conservative_slab.csv", kMethod,
                    "R and T by even light, A by Kirchhoff; of tau 100 mu0 = 1",
                    "SE < 1.5 % of the light each, A 6 % (tau 100: 25 %), 0.1 % together");
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const auto number = [&](const char* column) { return csv.number(row, column); };
    const double tau = number("tau"), mu0 = number("mu0"), absorbed = number("A");
    INFO("tau " << tau << ", 1 - w " << number("one_minus_w") << ", mu0 " << mu0 << ", g " << number("g"));
    if (tau > 50 && mu0 < 1) continue;
    const Layer layer{tau, 1 - number("one_minus_w"), hg(number("g")), 0};
    const int count = tau > 50 ? 960 : 2880;
    CHECK(verified.mean(path_radiance_along(glowing({layer}), view(1, true, mu0, 0), count, 3 * row), absorbed,
                        rule(absorbed, (tau > 50 ? 0.25 : 0.06) * absorbed, 150)));
    const World above = evenly_lit({layer});
    CHECK(verified.mean(path_radiance_along(above, seen_above(mu0), count, 3 * row + 1), number("R"),
                        rule(number("R"), 0.015, 150)));
    if (number("T") < 0.02) continue;
    CHECK(verified.mean(path_radiance_along(above, seen_below(mu0), count, 3 * row + 2), number("T"),
                        rule(number("T"), 0.015, 150)));
  }
  check_common(verified, 0.001);
}
