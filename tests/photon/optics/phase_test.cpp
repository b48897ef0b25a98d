// Phase functions against the reference tables f1 to f3, and every sampler against its density.
#include "photon/optics/phase.h"

#include <catch2/catch.hpp>

#include "octree/base/error.h"
#include "octree/base/math.h"
#include "octree/base/random.h"
#include "photon/optics/quadrature.h"
#include "tests/support/chi_square.h"
#include "tests/support/places.h"
#include "tests/support/verified.h"

using namespace obscura;
using test::Csv;

namespace {

const std::string kFolder = test::data_file("reference/");

PhaseFunction from_row(const Csv& csv, std::size_t i) {
  const std::string& type = csv.text(i, "type");
  if (type == "rayleigh") return PhaseFunction::rayleigh();
  if (type == "hg") return PhaseFunction::henyey_greenstein(csv.number(i, "g1"));
  REQUIRE(type == "dhg");
  return PhaseFunction::double_henyey_greenstein(csv.number(i, "g1"), csv.number(i, "g2"), csv.number(i, "f"));
}

// Bin edges in 1 - cosine, even and near both peaks geometric.
std::vector<double> edges() {
  std::vector<double> result{0, 2};
  for (int i = 1; i < 40; ++i) result.push_back(0.05 * i);
  for (double c = 0.04; c > 1e-12; c *= 0.5) {
    result.push_back(c);
    result.push_back(2 - c);
  }
  std::sort(result.begin(), result.end());
  return result;
}

// Integral of the density over 1 - cosine from a to b.
double probability(const PhaseFunction& p, double a, double b) {
  static const GaussLegendre rule(32);
  double sum = 0;
  for (std::size_t i = 0; i < rule.node.size(); ++i) {
    sum += rule.weight[i] * p.value(1 - (a + (b - a) * rule.node[i]));
  }
  return 2 * kPi * (b - a) * sum;
}

test::ChiSquare chi_square_of(const PhaseFunction& sampled, const PhaseFunction& density, std::uint64_t history) {
  Stream stream(1, history, 0);
  return test::chi_square_numbers(
      [&] {
        const double u1 = stream.uniform();
        const double u2 = stream.uniform();
        return sampled.sample_one_minus(u1, u2);
      },
      edges(), [&](double a, double b) { return probability(density, a, b); }, 200000, 20);
}

// A table with a forward peak, a gap without scattering and a rainbow; unnormalised.
PhaseFunction ragged(double* change = nullptr) {
  return PhaseFunction::table({0, 1, 5, 30, 60, 90, 135, 140, 150, 180}, {500, 300, 20, 1, 0, 0, 0.4, 2, 0.3, 0},
                              change);
}

}  // namespace

TEST_CASE("phase function values are right, near the peaks too", "[photon][phase]") {
  const Csv csv(kFolder + "f1_phase_function_values.csv");
  REQUIRE(csv.size() > 90);
  test::Verified verified("f1_phase_function_values.csv", "phase functions", "value of every row", "1e-12");
  for (std::size_t i = 0; i < csv.size(); ++i) {
    INFO(csv.text(i, "type") << " " << csv.text(i, "g1") << " mu " << csv.text(i, "mu"));
    const double reference = csv.number(i, "p_per_sr");
    verified.within(from_row(csv, i).value(csv.number(i, "mu")), reference, 1e-12);
    CHECK(std::abs(from_row(csv, i).value(csv.number(i, "mu")) - reference) < 1e-12 * reference);
  }
}

TEST_CASE("phase function moments are right", "[photon][phase]") {
  const Csv csv(kFolder + "f2_phase_function_moments.csv");
  test::Verified verified("f2_phase_function_moments.csv", "phase functions", "moments 0 to 4 of every row, absolute",
                          "1e-13");
  for (std::size_t i = 0; i < csv.size(); ++i) {
    INFO(csv.text(i, "type") << " " << csv.text(i, "g1"));
    const PhaseFunction p = from_row(csv, i);
    for (int l = 0; l <= 4; ++l) {
      verified.within(p.moment(l), csv.number(i, "chi" + std::to_string(l)), 1e-13, 1);
      CHECK(p.moment(l) == Approx(csv.number(i, "chi" + std::to_string(l))).epsilon(1e-13));
    }
    CHECK(p.mean_cosine() == Approx(csv.number(i, "chi1")).epsilon(1e-13));
    // The density integrates to 1, and over the backward half to the table's share.
    const std::vector<double> bins = edges();
    double whole = 0, back = 0;
    for (std::size_t k = 1; k < bins.size(); ++k) {
      const double part = probability(p, bins[k - 1], bins[k]);
      whole += part;
      if (bins[k - 1] >= 1 - 1e-12) back += part;
    }
    CHECK(whole == Approx(1).epsilon(1e-8));
    CHECK(back == Approx(csv.number(i, "frac_back_hemisphere")).epsilon(1e-8));
  }
}

TEST_CASE("sampling inverts the cumulative distribution without loss near forward", "[photon][phase]") {
  const Csv csv(kFolder + "f3_phase_function_sampling.csv");
  test::Verified verified("f3_phase_function_sampling.csv", "phase functions",
                          "1 - mu of every row; xi itself is rounded by 2e-16 / (1 - xi)", "1e-13 beside that");
  for (std::size_t i = 0; i < csv.size(); ++i) {
    INFO(csv.text(i, "type") << " " << csv.text(i, "g") << " xi " << csv.text(i, "xi"));
    const PhaseFunction p =
        csv.text(i, "type") == "hg" ? PhaseFunction::henyey_greenstein(csv.number(i, "g")) : PhaseFunction::rayleigh();
    const double xi = csv.number(i, "xi");
    // xi itself is rounded: what that makes of 1 - xi is allowed.
    const double tolerance = 1e-13 + 2e-16 / (1 - xi);
    const double one_minus = csv.number(i, "one_minus_mu");
    CHECK(std::abs(p.sample_one_minus(xi, 0.5) - one_minus) <= tolerance * one_minus);
    if (1 - xi > 1e-3) verified.within(p.sample_one_minus(xi, 0.5), one_minus, 1e-12);
    CHECK(std::abs(p.sample(xi, 0.5) - csv.number(i, "mu")) <= tolerance * one_minus + 1e-15);
  }
}

TEST_CASE("small scattering angles keep their digits", "[photon][phase]") {
  // Near forward, 1 - mu is (1 - u) / (2 pi p(1)), with a relative remainder of the order of 1 - u.
  const double v = 0x1p-45;
  for (const PhaseFunction& p :
       {PhaseFunction::isotropic(), PhaseFunction::rayleigh(), PhaseFunction::henyey_greenstein(0.6), ragged()}) {
    const double expected = v / (2 * kPi * p.value(1));
    CHECK(std::abs(p.sample_one_minus(1 - v, 0) / expected - 1) < 1e-10);
  }
}

TEST_CASE("every sampler follows its density", "[photon][phase]") {
  std::vector<PhaseFunction> all{PhaseFunction::isotropic(), PhaseFunction::rayleigh(), ragged()};
  for (const double g : {0.0, 1e-6, 0.5, -0.5, 0.85, 0.99, 0.9999, -0.9999}) {
    all.push_back(PhaseFunction::henyey_greenstein(g));
  }
  all.push_back(PhaseFunction::double_henyey_greenstein(0.85, -0.4, 0.9));
  all.push_back(PhaseFunction::double_henyey_greenstein(0.95, 0.1, 0.7));
  for (std::size_t i = 0; i < all.size(); ++i) {
    INFO("phase function " << i);
    CHECK(chi_square_of(all[i], all[i], i));
  }
}

TEST_CASE("the chi-square test sees a sampler that is slightly wrong", "[photon][phase]") {
  const auto hg = PhaseFunction::henyey_greenstein;
  const auto dhg = PhaseFunction::double_henyey_greenstein;
  CHECK_FALSE(chi_square_of(hg(0.85), hg(0.84), 1));
  CHECK_FALSE(chi_square_of(hg(-0.5), hg(0.5), 2));
  CHECK_FALSE(chi_square_of(hg(0.9999), hg(0.9998), 3));
  CHECK_FALSE(chi_square_of(hg(0.02), PhaseFunction::isotropic(), 4));
  CHECK_FALSE(chi_square_of(PhaseFunction::isotropic(), PhaseFunction::rayleigh(), 5));
  CHECK_FALSE(chi_square_of(dhg(0.85, -0.4, 0.9), dhg(0.85, -0.4, 0.89), 6));
  CHECK_FALSE(chi_square_of(ragged(), hg(ragged().mean_cosine()), 7));
}

TEST_CASE("the cosine and one minus the cosine are one sample", "[photon][phase]") {
  for (const PhaseFunction& p :
       {PhaseFunction::isotropic(), PhaseFunction::rayleigh(), PhaseFunction::henyey_greenstein(0.7),
        PhaseFunction::henyey_greenstein(-0.9), ragged(), PhaseFunction::double_henyey_greenstein(0.9, -0.3, 0.6)}) {
    double before = -1;
    for (const double u : {0.0, 1e-9, 0.01, 0.3, 0.5, 0.77, 0.999, 1.0}) {
      const double mu = p.sample(u, 0.1);
      CHECK(mu >= before);
      CHECK(std::abs(mu + p.sample_one_minus(u, 0.1) - 1) < 1e-14);
      before = mu;
    }
    CHECK(before == Approx(1).margin(1e-15));
  }
}

TEST_CASE("g of one is a delta: it is sampled and has no density", "[photon][phase]") {
  for (const double g : {1.0, -1.0}) {
    const PhaseFunction p = PhaseFunction::henyey_greenstein(g);
    for (const double u : {0.0, 0.3, 1.0}) CHECK(p.sample(u, 0.5) == g);
    for (const double mu : {-1.0, 0.0, 1.0}) CHECK(p.value(mu) == 0);
    CHECK(p.mean_cosine() == g);
    CHECK(p.moment(2) == 1);
    CHECK(p.moment(3) == g);
  }
}

TEST_CASE("a cosine beyond one by rounding is harmless", "[photon][phase]") {
  for (const PhaseFunction& p :
       {PhaseFunction::henyey_greenstein(0.9999), ragged(), PhaseFunction::henyey_greenstein(-0.9999)}) {
    CHECK(p.value(1 + 1e-12) == p.value(1));
    CHECK(p.value(-1 - 1e-12) == p.value(-1));
  }
}

TEST_CASE("a table is normalised and says by how much", "[photon][phase]") {
  double change = 0;
  // 1 over the sphere is 4 pi.
  const PhaseFunction one = PhaseFunction::table({0, 180}, {1, 1}, &change);
  CHECK(change == Approx(4 * kPi - 1).epsilon(1e-14));
  CHECK(one.value(0.3) == Approx(0.25 / kPi).epsilon(1e-14));
  CHECK(one.mean_cosine() == Approx(0).margin(1e-15));
  PhaseFunction::table({0, 90, 180}, {0.25 / kPi, 0.25 / kPi, 0.25 / kPi}, &change);
  CHECK(change == Approx(0).margin(1e-14));

  // Linear in the cosine: 1 + mu, times 1 / (4 pi).
  const PhaseFunction ramp = PhaseFunction::table({0, 180}, {2, 0});
  CHECK(ramp.value(0.5) == Approx(1.5 * 0.25 / kPi).epsilon(1e-14));
  CHECK(ramp.mean_cosine() == Approx(1.0 / 3).epsilon(1e-14));
  CHECK(ramp.moment(2) == Approx(0).margin(1e-14));
  CHECK(ramp.sample(0.25, 0) == Approx(0).margin(1e-15));  // cdf (1 + mu)^2 / 4
}

TEST_CASE("a table may be zero over angles, and never goes there", "[photon][phase]") {
  const PhaseFunction p = PhaseFunction::table({0, 10, 20, 100, 110, 180}, {0, 0, 1, 1, 0, 0});
  Stream stream(3, 0, 0);
  for (int i = 0; i < 10000; ++i) {
    const double mu = p.sample(stream.uniform(), 0);
    CHECK(p.value(mu) > 0);
  }
  CHECK(p.sample(0, 0) == Approx(std::cos(110 * kPi / 180)).epsilon(1e-14));
  CHECK(p.sample(1, 0) == Approx(std::cos(10 * kPi / 180)).epsilon(1e-14));
  CHECK(p.value(1) == 0);
}

TEST_CASE("a fine table of Henyey and Greenstein becomes it to second order", "[photon][phase]") {
  const PhaseFunction hg = PhaseFunction::henyey_greenstein(0.8);
  const auto error = [&](int nodes) {
    std::vector<double> angles, values;
    for (int i = 0; i <= nodes; ++i) {
      angles.push_back(i == nodes ? 180.0 : 180.0 * i / nodes);
      values.push_back(hg.value(std::cos(angles.back() * kPi / 180)));
    }
    const PhaseFunction table = PhaseFunction::table(angles, values);
    double worst = 0;
    for (double mu = -1; mu <= 1; mu += 0.001) {
      worst = std::max(worst, std::abs(table.value(mu) / hg.value(mu) - 1));
    }
    CHECK(table.mean_cosine() == Approx(0.8).epsilon(worst));
    CHECK(table.moment(5) == Approx(hg.moment(5)).epsilon(10 * worst));
    return worst;
  };
  const double coarse = error(180), fine = error(720);
  CHECK(coarse / fine > 12);
  CHECK(fine < 1e-3);
}

TEST_CASE("a phase function that makes no sense is refused", "[photon][phase]") {
  CHECK_THROWS_AS(PhaseFunction::henyey_greenstein(1.01), InputError);
  CHECK_THROWS_AS(PhaseFunction::henyey_greenstein(std::nan("")), InputError);
  CHECK_THROWS_AS(PhaseFunction::double_henyey_greenstein(0, -2, 0.5), InputError);
  CHECK_THROWS_AS(PhaseFunction::double_henyey_greenstein(0, 0, 1.5), InputError);
  CHECK_THROWS_AS(PhaseFunction::table({0, 180}, {0, 0}), InputError);
  CHECK_THROWS_AS(PhaseFunction::table({0, 180}, {1, -1}), InputError);
  CHECK_THROWS_AS(PhaseFunction::table({0, 179}, {1, 1}), InputError);
  CHECK_THROWS_AS(PhaseFunction::table({1, 180}, {1, 1}), InputError);
  CHECK_THROWS_AS(PhaseFunction::table({0, 90, 90, 180}, {1, 1, 1, 1}), InputError);
  CHECK_THROWS_AS(PhaseFunction::table({0, 180}, {1}), InputError);
  CHECK_THROWS_AS(PhaseFunction::table({0}, {1}), InputError);
}

TEST_CASE("a blunted phase function has the wished height and moments that fall by one factor", "[phase]") {
  // A table with a narrow peak that holds half of the light.
  std::vector<double> angles, values;
  for (int i = 0; i <= 1800; ++i) {
    angles.push_back(0.1 * i);
    const double one_minus = 1 - std::cos(angles.back() * kPi / 180);
    values.push_back(2000 * std::exp(-one_minus / 5e-4) + 1);
  }
  for (const PhaseFunction& sharp :
       {PhaseFunction::henyey_greenstein(0.9999), PhaseFunction::henyey_greenstein(-0.99),
        PhaseFunction::henyey_greenstein(1), PhaseFunction::double_henyey_greenstein(0.98, -0.3, 0.8),
        PhaseFunction::table(angles, values)}) {
    const PhaseFunction blunt = sharp.blunted(256);
    double highest = 0, integral = 0;
    constexpr int kSteps = 40000;
    for (int i = 0; i < kSteps; ++i) {
      const double value = blunt.value(-1 + 2 * (i + 0.5) / kSteps);
      highest = std::max(highest, value);
      integral += 2 * kPi * value * 2 / kSteps;
    }
    CHECK(4 * kPi * highest < 257);
    CHECK(4 * kPi * highest > 100);
    CHECK(integral == Approx(1).epsilon(1e-3));
    const double factor = blunt.moment(1) / sharp.moment(1);
    CHECK(factor > 0.85);
    CHECK(factor < 1);
  }
  const PhaseFunction blunt = PhaseFunction::table(angles, values).blunted(256);
  const PhaseFunction sharp = PhaseFunction::table(angles, values);
  const double factor = blunt.moment(1) / sharp.moment(1);
  for (const int l : {2, 3, 7}) CHECK(blunt.moment(l) == Approx(std::pow(factor, l) * sharp.moment(l)).epsilon(5e-3));
  // What is low enough stays as it is.
  const PhaseFunction same = PhaseFunction::henyey_greenstein(0.85).blunted(256);
  for (const double mu : {-1.0, 0.3, 1.0}) CHECK(same.value(mu) == PhaseFunction::henyey_greenstein(0.85).value(mu));
}
