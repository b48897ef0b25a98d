// Homogeneous slabs, spheres and voxelisations: what leaves them, by photons that cross rectangles,
// against tables of other methods (tests/data/slab_fluxes.csv, sphere_totals.csv).
#include <catch2/catch.hpp>

#include "tests/support/agree.h"
#include "tests/support/csv.h"
#include "tests/support/places.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

constexpr double kSide = 8;  // m, of the periodic cell; extinction is tau per metre of the layer

PhaseFunction phase_of(const std::string& name, double g) {
  return name == "rayleigh" ? PhaseFunction::rayleigh() : PhaseFunction::henyey_greenstein(g);
}

/// A layer of `layers` voxels over 1 m, periodic along x and y; the source is linear from top to bottom.
World slab(double tau, double albedo, const PhaseFunction& phase, double mu0, double top = 0, double bottom = 0,
           int layers = 8) {
  CloudWish wish;
  wish.voxel_m = 1.0 / layers;
  wish.voxels = Vec3i(static_cast<int>(kSide) * layers, static_cast<int>(kSide) * layers, layers);
  wish.extinction = tau;
  wish.albedo = albedo;
  wish.phase = phase;
  wish.period_m = {kSide, kSide};
  WorldContents contents;
  contents.bands.emplace_back("grey");
  if (top == bottom) {
    wish.source = top;
    contents.clouds.push_back(make_cloud(wish));
  } else {
    // One cloud a layer of voxels, with the source of its middle.
    wish.voxels.z = 1;
    for (int z = 0; z < layers; ++z) {
      wish.source = bottom + (top - bottom) * (z + 0.5) / layers;
      wish.corner_m = {0, 0, z * wish.voxel_m};
      contents.clouds.push_back(make_cloud(wish));
    }
  }
  if (mu0 > 0) contents.sun = Sun{{std::sqrt(1 - mu0 * mu0), 0, mu0}, {1}, 0};
  return World(std::move(contents));
}

struct Fluxes {
  BatchMean up, down;  // W/m2 through planes above and below the slab
};

Fluxes fluxes(const World& world, std::uint64_t photons) {
  const auto plane = [](double z) { return FluxRectangle{{kSide / 2, kSide / 2, z}, {kSide, 0, 0}, {0, kSide, 0}}; };
  const FluxRectangle rectangles[] = {plane(1.5), plane(-0.5)};
  TraceSettings settings;
  settings.photons = photons;
  const TraceResult result = trace_photons({world, 0}, settings, rectangles);
  const auto of = [](BatchTally tally) {
    for (double& value : tally) value *= kBatches / (kSide * kSide);
    return batch_mean(tally);
  };
  return {of(result.flux[0].forward), of(result.flux[1].backward)};
}

AgreeOptions options(double resolution, double comparisons) {
  return {.resolution = resolution, .comparisons = comparisons, .degrees_of_freedom = 15};
}

}  // namespace

TEST_CASE("a slab's reflection, transmission and emission are those of the tables", "[physics][slab]") {
  const Csv csv(test::data_file("slab_fluxes.csv"));
  REQUIRE(csv.size() >= 8);
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const auto number = [&](const char* column) { return csv.number(row, column); };
    const double mu0 = number("mu0");
    const Fluxes found = fluxes(slab(number("tau"), number("w"), phase_of(csv.text(row, "phase"), number("g")), mu0,
                                     number("B_top"), number("B_bot")),
                                240000);
    INFO(csv.text(row, "case"));
    // Sunlight: shares of mu0 E, E = 1; emission: over pi.
    const double unit = mu0 > 0 ? mu0 : kPi;
    // A standard error of at most 0.5 % in every one of these numbers.
    const double comparisons = 2 * static_cast<double>(csv.size());
    CHECK(agree(found.up.mean / unit, found.up.standard_error / unit, number("up"), options(0.065, comparisons)));
    CHECK(agree(found.down.mean / unit, found.down.standard_error / unit, number("down"), options(0.065, comparisons)));
  }
}

TEST_CASE("a slab of 6 % more extinction is told from the table's", "[physics][slab]") {
  // tau 2, albedo 0.9, g 0.75, overhead sun: R 0.0973946, T 0.6609577 (d2; van de Hulst).
  const Fluxes right = fluxes(slab(2, 0.9, PhaseFunction::henyey_greenstein(0.75), 1), 250000);
  const Fluxes wrong = fluxes(slab(2.12, 0.9, PhaseFunction::henyey_greenstein(0.75), 1), 250000);
  const double z = test::student_limit(1e-6, 15);
  CHECK(std::abs(right.down.mean - 0.6609577) < z * right.down.standard_error);
  CHECK(std::abs(wrong.down.mean - 0.6609577) > z * wrong.down.standard_error);
  CHECK(right.down.standard_error < 0.003 * 0.66);
}

TEST_CASE("a periodic layer in two voxelisations is one layer", "[physics][slab]") {
  const PhaseFunction phase = PhaseFunction::henyey_greenstein(0.5);
  const Fluxes fine = fluxes(slab(3, 0.8, phase, 0.7, 0, 0, 8), 200000);
  const Fluxes coarse = fluxes(slab(3, 0.8, phase, 0.7, 0, 0, 1), 200000);
  CHECK(agree(
      fine.up.mean, fine.up.standard_error, coarse.up.mean,
      {.resolution = 0.08, .reference_error = coarse.up.standard_error, .comparisons = 2, .degrees_of_freedom = 15}));
  CHECK(agree(
      fine.down.mean, fine.down.standard_error, coarse.down.mean,
      {.resolution = 0.08, .reference_error = coarse.down.standard_error, .comparisons = 2, .degrees_of_freedom = 15}));
}

TEST_CASE("a turned and moved periodic layer sends the same light and looks the same", "[physics][slab]") {
  // Smooth variation across the cell, so that a map that repeats along wrong axes would show.
  CloudWish wish;
  wish.voxels = {16, 16, 4};
  wish.voxel_m = 0.5;
  wish.extinction = 1.5;
  wish.albedo = 0.9;
  wish.density = [](const Vec3i& v) { return (v.x / 8 + v.y / 8) % 2 ? 0.2 : 1.8; };
  wish.period_m = {8, 8};
  const auto radiance = [&](const Affine& place) {
    WorldContents contents = grey_contents(wish);
    contents.clouds[0].local_to_world = place;
    contents.sun = Sun{transform_direction(place, Vec3d(0.6, 0, 0.8)).normalized(), {5}, 0};
    const World world(std::move(contents));
    TraceSettings trace;
    trace.photons = 200000;
    const Light light = trace_light(world, trace);
    RadianceSettings map_only;
    map_only.parts = {false, true, false, false, false, false, true};
    map_only.gather.nearest = 300;
    std::vector<RayRadiance> seen;
    for (const Vec3d& through : {Vec3d(2, 2, 2), Vec3d(6, 2, 2), Vec3d(0.02, 4.5, 2), Vec3d(7.8, 7.7, 2)}) {
      const Vec3d d = Vec3d(0.1, 0.2, -1).normalized();
      const Ray ray{transform_point(place, through - 5.0 * d), transform_direction(place, d), 0, kInfinity};
      seen.push_back(ray_radiance(world, light, ray, 64, map_only));
    }
    return seen;
  };
  const auto plain = radiance(placement({0, 0, 0}, {0, 0, 0}, 1));
  const auto turned = radiance(placement({30, -20, 5}, {0.3, 0.2, 0.7}, 1));
  for (std::size_t i = 0; i < plain.size(); ++i) {
    INFO(plain[i].mean << " +- " << plain[i].error << " against " << turned[i].mean << " +- " << turned[i].error);
    CHECK(std::abs(plain[i].mean - turned[i].mean) < 4 * std::hypot(plain[i].error, turned[i].error));
    CHECK(plain[i].error < 0.08 * plain[i].mean);
  }
}

TEST_CASE("spheres absorb and let out what the tables say, under even light and in a beam", "[physics][sphere]") {
  // e4_sphere_totals.csv, rows sph_A (radius 5 mean free paths, albedo 0.9, isotropic): of the light that
  // meets the sphere 0.37651542 is absorbed, 0.019990012 passes unscattered. Voxels with exact volume
  // fractions at the border stand for the sphere: they add up to its volume.
  constexpr int kVoxels = 40;
  constexpr double kRadius = 1;
  CloudWish wish;
  wish.voxels = Vec3i(kVoxels);
  wish.voxel_m = 2 * kRadius / kVoxels;
  wish.extinction = 5;
  wish.albedo = 0.9;
  wish.density = [](const Vec3i& v) {
    int inside = 0;
    constexpr int kSub = 5;
    for (int i = 0; i < kSub * kSub * kSub; ++i) {
      const Vec3d p =
          (Vec3d(v) + (Vec3d(i % kSub, i / kSub % kSub, i / (kSub * kSub)) + Vec3d(0.5)) / kSub) / (0.5 * kVoxels) -
          Vec3d(1);
      inside += p.length2() < 1;
    }
    return inside / static_cast<double>(kSub * kSub * kSub);
  };
  for (const bool sky : {true, false}) {
    WorldContents contents = grey_contents(wish, sky ? 1 : 0);
    if (!sky) contents.sun = Sun{Vec3d(1, 2, 2).normalized(), {1}, 0};
    const World world(std::move(contents));
    TraceSettings settings;
    settings.photons = 300000;
    TraceResult result = trace_photons({world, 0}, settings);
    const double met = sky ? kPi * 4 * kPi : kPi;  // pi L times the surface, or E times the disc
    for (double& batch : result.energy.absorbed) batch *= kBatches / met;
    const BatchMean absorbed = batch_mean(result.energy.absorbed);
    // The voxels' border costs up to 0.3 %.
    INFO((sky ? "sky: " : "sun: ") << absorbed.mean << " +- " << absorbed.standard_error);
    CHECK(std::abs(absorbed.mean - 0.37651542) < 3 * absorbed.standard_error + 0.003 * 0.3765);
    CHECK(absorbed.standard_error < 0.005 * 0.3765);
  }
}
