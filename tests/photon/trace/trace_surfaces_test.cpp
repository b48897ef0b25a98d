// Tracing among surfaces: where power lands, what nets and air let through, and that the balance holds.
#include <catch2/catch.hpp>

#include "photon/trace/trace.h"
#include "tests/support/agree.h"
#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

double sum(const BatchTally& tally) { return pairwise_sum(tally); }

/// Everything emitted is found again, batch by batch.
EnergyTally balanced(const TraceResult& result) {
  const EnergyTally& e = result.energy;
  CHECK(result.anomalies == 0);
  for (std::size_t b = 0; b < e.emitted.size(); ++b) {
    CHECK(e.absorbed[b] + e.surface[b] + e.escaped[b] + e.truncated[b] == Approx(e.emitted[b]).epsilon(1e-9));
  }
  return e;
}

/// Share of the emitted, in batches.
BatchMean share(const BatchTally& part, const BatchTally& emitted) {
  BatchTally ratio;
  for (std::size_t b = 0; b < ratio.size(); ++b) ratio[b] = part[b] / emitted[b];
  return batch_mean(ratio);
}

/// Power of photons at surfaces over the emitted.
BatchMean landed(const TraceResult& result) {
  BatchTally power{};
  for (const Photon& photon : result.surface_photons) power[photon.batch] += static_cast<double>(photon.power);
  return share(power, result.energy.emitted);
}

TraceSettings of_count(std::uint64_t count) {
  TraceSettings settings;
  settings.photons = count;
  return settings;
}

}  // namespace

TEST_CASE("in a closed box all light ends on its walls, and lands as often as they reflect",
          "[photon][trace][surfaces]") {
  // Light of faces is stored from its second landing on: r + r^2 + ... of what is emitted.
  for (const double specular : {0.0, 1.0, 0.5}) {
    WorldContents contents = empty_contents();
    contents.materials = {grey_material(0.4, specular, specular == 0.5 ? 0.2 : 0)};
    contents.objects = {grey_object(box_mesh({0, 0, 0}, {1, 2, 3}, true), 0, 5)};
    const World world(contents);
    const TraceResult result = trace_photons({world, 0}, of_count(100000));
    const EnergyTally energy = balanced(result);
    CHECK(sum(energy.emitted) == Approx(kPi * 0.4 * 5 * 22).epsilon(1e-9));
    CHECK(sum(energy.surface) == Approx(sum(energy.emitted)).epsilon(1e-9));
    CHECK(sum(energy.escaped) == 0);
    const BatchMean stored = landed(result);
    CHECK(agree(stored.mean, stored.standard_error, 1.5,
                {.resolution = 0.06, .comparisons = 3, .degrees_of_freedom = 15}));
  }
}

TEST_CASE("a beam between two mirrors lands the geometric series", "[photon][trace][surfaces]") {
  WorldContents contents = empty_contents();
  contents.materials = {grey_material(0.1, 1)};
  contents.objects = {grey_object(parallelogram({-5, -5, 0}, {10, 0, 0}, {0, 10, 0}), 0, 0),
                      grey_object(parallelogram({-5, -5, 1}, {0, 10, 0}, {10, 0, 0}), 0, 0)};
  contents.beams.push_back({{0, 0, 0.5}, {0, 0, 1}, 0.1, {5}});
  const World world(contents);
  const TraceResult result = trace_photons({world, 0}, of_count(50000));
  const EnergyTally energy = balanced(result);
  CHECK(sum(energy.surface) == Approx(5).epsilon(1e-9));
  const BatchMean stored = landed(result);  // beams are stored from the first landing on
  CHECK(agree(stored.mean, stored.standard_error, 10, {.resolution = 0.05, .degrees_of_freedom = 15}));
  int wrong = 0;
  for (const Photon& photon : result.surface_photons) {
    const Vec3d d = decode_direction(photon.direction), n = decode_normal(photon.collisions);
    const double z = transform_point(world.map_to_world(), Vec3d(photon.position)).z;
    wrong += std::abs(d.z) < 0.999999 || n.z * d.z > -0.999 || std::abs(z - (d.z > 0 ? 1 : 0)) > 1e-5;
  }
  CHECK(wrong == 0);
}

TEST_CASE("nets let their share of photons through, and stop the rest", "[photon][trace][surfaces]") {
  WorldContents contents = empty_contents();
  Material net = grey_material(1);
  net.permeable = 0.3;
  contents.materials = {grey_material(1), net};
  contents.objects = {grey_sphere({0, 0, 0}, 1, 0, 5), grey_sphere({0.2, 0, 0}, 3, 1, 0),
                      grey_sphere({0, 0.1, 0}, 4, 1, 0)};
  const World world(contents);
  const EnergyTally energy = balanced(trace_photons({world, 0}, of_count(200000)));
  CHECK(sum(energy.emitted) == Approx(5 * kPi * 4 * kPi).epsilon(1e-9));
  const BatchMean escaped = share(energy.escaped, energy.emitted);
  CHECK(agree(escaped.mean, escaped.standard_error, 0.09, {.resolution = 0.1, .degrees_of_freedom = 15}));
  CHECK(sum(energy.absorbed) == 0);
}

TEST_CASE("air takes its share on the way from wall to wall", "[photon][trace][surfaces]") {
  WorldContents contents = empty_contents();
  contents.materials = {grey_material(1)};
  Object ball = grey_sphere({1, 2, 3}, 2, 0, 5);
  ball.double_sided = true;
  contents.objects = {ball};
  contents.atmosphere = Atmosphere{{0.3}, {0}};
  const World world(contents);
  const EnergyTally energy = balanced(trace_photons({world, 0}, of_count(200000)));
  // Outward all ends in the air; inward a chord 2 R cos t long: T = 2 (1 - e^-x (1 + x)) / x^2, x = 2 a R.
  const double x = 2 * 0.3 * 2;
  const double T = 2 * (1 - std::exp(-x) * (1 + x)) / (x * x);
  const BatchMean surface = share(energy.surface, energy.emitted);
  CHECK(agree(surface.mean, surface.standard_error, 0.5 * T, {.resolution = 0.05, .degrees_of_freedom = 15}));
  CHECK(sum(energy.escaped) == 0);
  // Light from beyond is given as it arrives: none of it is lost before it lands.
  WorldContents lit = contents;
  lit.objects[0].radiance = {0.0};
  lit.sun = Sun{{0, 0, 1}, {4}, 0.01};
  const EnergyTally sunlight = balanced(trace_photons({World(lit), 0}, of_count(20000)));
  CHECK(sum(sunlight.absorbed) == 0);
  CHECK(sum(sunlight.surface) == Approx(4 * kPi * 4).epsilon(0.02));
}

TEST_CASE("a limit to scatterings leaves reflections alone, and the balance holds", "[photon][trace][surfaces]") {
  // A closed box with a white cloud: without the limit everything ends on the walls.
  CloudWish smoke;
  smoke.voxels = Vec3i(8);
  smoke.voxel_m = 0.1;
  smoke.extinction = 5;
  smoke.albedo = 1;
  smoke.corner_m = {0.1, 0.1, 0.1};
  WorldContents contents = grey_contents(smoke);
  contents.sky = {0};
  contents.materials = {grey_material(0.3, 0.4)};
  contents.objects = {grey_object(box_mesh({0, 0, 0}, {1, 1, 1}, true), 0, 5)};
  const World world(contents);
  const EnergyTally whole = balanced(trace_photons({world, 0}, of_count(20000)));
  CHECK(sum(whole.surface) == Approx(sum(whole.emitted)).epsilon(1e-9));
  TraceSettings limited = of_count(20000);
  limited.scattering_depth = 2;
  const TraceResult cut = trace_photons({world, 0}, limited);
  const EnergyTally energy = balanced(cut);
  CHECK(sum(energy.truncated) > 0.1 * sum(energy.emitted));
  CHECK(sum(energy.surface) > 0.1 * sum(energy.emitted));
  CHECK(sum(energy.absorbed) == 0);
  int deepest = 0;
  for (const Photon& photon : cut.photons) deepest = std::max<int>(deepest, photon.collisions);
  CHECK(deepest == 1);
}

TEST_CASE("backs of one-sided surfaces swallow what meets them", "[photon][trace][surfaces]") {
  WorldContents contents = empty_contents();
  contents.materials = {grey_material(0, 1)};
  contents.objects = {grey_object(parallelogram({-5, -5, 1}, {10, 0, 0}, {0, 10, 0}), 0, 0)};  // faces up
  contents.beams.push_back({{0, 0, 0}, {0, 0, 1}, 0.1, {5}});
  for (const bool double_sided : {false, true}) {
    contents.objects[0].double_sided = double_sided;
    const TraceResult result = trace_photons({World(contents), 0}, of_count(1000));
    const EnergyTally energy = balanced(result);
    CHECK(sum(double_sided ? energy.escaped : energy.surface) == Approx(5).epsilon(1e-9));
    CHECK(result.surface_photons.size() == (double_sided ? 1000u : 0u));
  }
}
