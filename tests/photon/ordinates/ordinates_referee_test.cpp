// The error that discrete ordinates state of themselves, against references.
#include "photon/ordinates/ordinates_referee.h"

#include <catch2/catch.hpp>

#include "tests/support/csv.h"
#include "tests/support/places.h"
#include "tests/support/slabs.h"

using namespace obscura;
using namespace obscura::test;

namespace {

std::string table(const std::string& name) {
  std::string path = test::data_file("reference/");
  path += name;
  return path;
}

/// Within twice the stated error, which is small enough to say something.
void check(const std::string& what, const OrdinatesEstimate& estimate, double reference, double reference_error,
           double resolution) {
  INFO(what << ": " << estimate.value << " +- " << estimate.error << " against " << reference);
  CHECK(std::abs(estimate.value - reference) < 2 * std::hypot(estimate.error, reference_error));
  CHECK(estimate.error < resolution * reference);
}

double e2(const Csv& csv, const std::string& name, const std::string& quantity, double* error) {
  for (std::size_t row = 0; row < csv.size(); ++row) {
    if (csv.text(row, "case") != name || csv.text(row, "quantity") != quantity) continue;
    *error = csv.number(row, "stderr");
    return csv.number(row, "value");
  }
  throw std::runtime_error("no " + name + " " + quantity);
}

/// A sphere of radius R mean free paths with one photon born per unit of volume.
World glowing_sphere(double radius, double albedo, int voxels) {
  CloudWish wish;
  wish.voxels = Vec3i(voxels);
  wish.voxel_m = 2 * radius / voxels;
  wish.albedo = albedo;
  wish.source = 1 / (4 * kPi * (1 - albedo));
  wish.density = [=](const Vec3i& v) {
    constexpr int kParts = 8;
    int inside = 0;
    for (int n = 0; n < kParts * kParts * kParts; ++n) {
      const Vec3d part(n % kParts, n / kParts % kParts, n / (kParts * kParts));
      inside += ((Vec3d(v) + (part + Vec3d(0.5)) / kParts) * wish.voxel_m - Vec3d(radius)).length2() < radius * radius;
    }
    return inside / static_cast<double>(kParts * kParts * kParts);
  };
  return World(grey_contents(wish));
}

}  // namespace

TEST_CASE("slabs are within the error that the referee states", "[ordinates][referee]") {
  const Csv d1(table("d1_slab_isotropic_flux.csv"));
  int compared = 0;
  for (std::size_t row = 0; row < d1.size(); ++row) {
    const double tau = d1.number(row, "tau"), albedo = d1.number(row, "w"), mu0 = d1.number(row, "mu0");
    if (mu0 != 0.5 || tau > 20) continue;
    const World world(slab_contents({{{tau, albedo, {}}}, mu0}));
    OrdinatesSettings settings;
    settings.cells = Vec3i(1, 1, tau > 2 ? 64 : 32);
    settings.order = 12;
    const OrdinatesReferee referee({world, 0}, settings);
    const auto share = [&](OrdinatesEstimate e) {
      return OrdinatesEstimate{e.value / (64 * mu0), e.error / (64 * mu0)};
    };
    const std::string what = "tau " + std::to_string(tau) + " albedo " + std::to_string(albedo);
    check(what + " R", share(referee.left(2, 1)), d1.number(row, "R"), 0, 0.015);
    if (d1.number(row, "T_diffuse") > 1e-6)
      check(what + " T", share(referee.left(2, 0)), d1.number(row, "T_diffuse"), 0, 0.03);
    if (albedo < 1) check(what + " A", share(referee.absorbed()), d1.number(row, "A"), 0, 0.015);
    ++compared;
  }
  CHECK(compared >= 8);
}

TEST_CASE("a cube under a sun is within the error that the referee states", "[ordinates][referee]") {
  const Csv csv(table("e2_boxes.csv"));
  CloudWish wish;
  wish.voxels = Vec3i(16);
  wish.voxel_m = 1.0 / 16;
  wish.extinction = 10;
  wish.albedo = 0.9;
  WorldContents contents = grey_contents(wish);
  contents.sun = Sun{Vec3d(0, 0, 1), {1}, 0};
  const World world(std::move(contents));
  OrdinatesSettings settings;
  settings.cells = Vec3i(16);
  settings.order = 12;
  const OrdinatesReferee referee({world, 0}, settings);
  double error = 0;
  const double up = e2(csv, "box_P1", "R", &error);
  check("R", referee.left(2, 1), up, error, 0.01);
  const double absorbed = e2(csv, "box_P1", "A", &error);
  check("A", referee.absorbed(), absorbed, error, 0.01);
  const double side = e2(csv, "box_P1", "side_xmin", &error);
  check("side", referee.left(0, 0), side, error, 0.01);
  double direct_error = 0;
  const double down = e2(csv, "box_P1", "T", &error) - e2(csv, "box_P1", "T_direct", &direct_error);
  check("T", referee.left(2, 0), down, std::hypot(error, direct_error), 0.05);
}

TEST_CASE("voids in a cell that repeats are within the error that the referee states", "[ordinates][referee]") {
  const Csv csv(table("e2_boxes.csv"));
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.voxel_m = 0.125;
  wish.extinction = 8;
  wish.albedo = 0.95;
  wish.period_m = {1, 1};
  wish.density = [](const Vec3i& v) { return (v.x / 4 + v.y / 4 + v.z / 4) % 2 ? 1.0 : 0.0; };
  const World world(grey_contents(wish, 1));
  OrdinatesSettings settings;
  settings.cells = Vec3i(8);
  const OrdinatesReferee referee({world, 0}, settings);
  // The sky lights both faces; turned over, the cell is its own neighbour.
  const auto share = [](OrdinatesEstimate e, double of) { return OrdinatesEstimate{e.value / of, e.error / of}; };
  double error = 0, other = 0;
  const double out = e2(csv, "box_P4", "R", &error) + e2(csv, "box_P4", "T", &other);
  check("R + T", share(referee.left(2, 1), kPi), out, std::hypot(error, other), 0.03);
  const double absorbed = e2(csv, "box_P4", "A", &error);
  check("A", share(referee.absorbed(), 2 * kPi), absorbed, error, 0.03);
}

TEST_CASE("a sphere of voxels is within the error that the referee states, and within 0.7 %", "[ordinates][referee]") {
  const Csv csv(table("b1_sphere_internal_source.csv"));
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const double radius = csv.number(row, "R"), albedo = csv.number(row, "w");
    if (!(radius == 1 && albedo == 0.5) && !(radius == 5 && albedo == 0.99)) continue;
    const World world = glowing_sphere(radius, albedo, 24);
    OrdinatesSettings settings;
    settings.cells = Vec3i(24);
    settings.order = 8;
    const OrdinatesReferee referee({world, 0}, settings);
    const double volume = 4 * kPi / 3 * radius * radius * radius;
    OrdinatesEstimate mean = referee.absorbed();
    mean.value /= (1 - albedo) * volume;
    mean.error /= (1 - albedo) * volume;
    INFO("R " << radius << " albedo " << albedo);
    check("mean fluence", mean, csv.number(row, "phi_avg"), 0, 0.03);
    CHECK(mean.value == Approx(csv.number(row, "phi_avg")).epsilon(7e-3));
    check("fluence in the middle", referee.fluence_at(Vec3d(radius)), csv.number(row, "phi_0"), 0, 0.03);
  }
}

TEST_CASE("finer grids and higher orders state smaller errors", "[ordinates][referee]") {
  const World world(slab_contents({{{2, 0.8, PhaseFunction::henyey_greenstein(0.4)}}, 0.6}));
  std::vector<OrdinatesEstimate> estimates;
  for (const int n : {8, 32}) {
    OrdinatesSettings settings;
    settings.cells = Vec3i(1, 1, n);
    settings.order = n / 2;
    const OrdinatesReferee referee({world, 0}, settings);
    std::vector<Ray> rays;
    for (int i = 0; i < 8; ++i) rays.push_back({Vec3d(4, 4, 12), Vec3d(0.1 * i, 0, -1).normalized(), 0, kInfinity});
    std::vector<OrdinatesEstimate> radiance(rays.size());
    referee.radiance(rays, radiance);
    estimates.push_back(radiance[3]);
    if (n == 32) {
      for (const OrdinatesEstimate& e : radiance) CHECK(e.error < 5e-3 * e.value);
    }
  }
  CHECK(estimates[1].error < 0.3 * estimates[0].error);
  CHECK(std::abs(estimates[0].value - estimates[1].value) < 2 * std::hypot(estimates[0].error, estimates[1].error));
}
