// What happens to the power that is emitted, told in several ways.
#include <catch2/catch.hpp>

#include "tests/support/agree.h"
#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

BatchMean of(BatchTally tally) {
  for (double& value : tally) value *= kBatches;
  return batch_mean(tally);
}

BatchMean difference(const BatchTally& a, const BatchTally& b) {
  BatchTally result;
  for (std::size_t k = 0; k < result.size(); ++k) result[k] = a[k] - b[k];
  return of(result);
}

/// Power that the clouds absorb, by the map: the sum over leaves of k_a phi V, each batch for itself.
BatchTally absorbed_by_fluence(const World& world, const PhotonMap& map) {
  BatchTally absorbed{};
  const Octree& octree = *world.clouds()[0].octree;
  const CloudOptics& optics = SpectralWorld(world, 0).optics(0);
  GatherSettings gather;
  gather.nearest = 40;  // a narrow kernel: less blur, and the sum needs no quiet single values
  octree.for_each_leaf([&](const Cell& cell, std::span<const float> values) {
    const LocalOptics local = optics.at([&](int channel) { return values[static_cast<std::size_t>(channel)]; });
    const double side = 0.1 * std::exp2(cell.level);
    const Vec3d middle = 0.1 * (Vec3d(cell.corner) + Vec3d(0.5 * std::exp2(cell.level)));
    const Estimate fluence = estimate(
        map, transform_point(world.world_to_map(), middle),
        [&](const Vec3d& y) noexcept { return SpectralWorld(world, 0).extinction_in_map(y); },
        [](const Vec3d&) noexcept { return 1.0; }, gather);
    for (std::size_t b = 0; b < absorbed.size(); ++b) {
      absorbed[b] += (local.extinction - local.scattering) * fluence.batch[b] * side * side * side / kBatches;
    }
  });
  return absorbed;
}

}  // namespace

TEST_CASE("emitted power is absorbed, escaped, on surfaces or cut off, and nothing else",
          "[physics][energy][surfaces]") {
  const CloudWish wish = rough_wish(0.8, 0.6, 2);
  WorldContents contents = grey_contents(wish, 0.7);
  contents.sun = Sun{Vec3d(0, 0, 1), {5}, 0.01};
  contents.sources.push_back({Vec3d(1.6, 1.6, 5), 0.5, {30}});
  contents.beams.push_back({Vec3d(1.6, 1.6, -2), Vec3d(0, 0, 1), 0.2, {4}});
  const World world(std::move(contents));
  TraceSettings settings;
  settings.photons = 200000;
  settings.scattering_depth = 5;
  const Light light = trace_light(world, settings);
  const EnergyTally& energy = light.bands[0].energy;
  for (std::size_t b = 0; b < energy.emitted.size(); ++b) {
    const double sum = energy.absorbed[b] + energy.surface[b] + energy.escaped[b] + energy.truncated[b];
    CHECK(sum == Approx(energy.emitted[b]).epsilon(1e-10));
    CHECK(energy.surface[b] > 0);
    CHECK(energy.truncated[b] > 0);
  }
  // The power is that of the sources, which are known.
  const double emitted = of(energy.emitted).mean;
  CHECK(emitted == Approx(PhotonEmitter({world, 0}).power()).epsilon(1e-3));
}

TEST_CASE("a sun's photons carry its irradiance over the disc that covers the bounds", "[physics][energy]") {
  WorldContents contents = grey_contents(rough_wish(0.5));
  contents.sun = Sun{Vec3d(1, 2, 2).normalized(), {5}, 0.0093};
  const World world(std::move(contents));
  const double radius = 0.5 * std::sqrt(3.0) * kRoughSide * 0.1;
  CHECK(PhotonEmitter({world, 0}).power() == Approx(5 * kPi * radius * radius).epsilon(1e-12));
}

TEST_CASE("absorbed power is the same by roulette, by the map's fluence and by what escapes", "[physics][energy]") {
  const CloudWish wish = rough_wish(0.7, 0.6, 2);
  const World world(grey_contents(wish));
  TraceSettings settings;
  settings.photons = 2000000;
  const Light light = trace_light(world, settings);
  const EnergyTally& energy = light.bands[0].energy;
  const BatchMean by_roulette = of(energy.absorbed);
  const BatchMean by_escape = difference(energy.emitted, energy.escaped);
  // Emission is a source of photons, not of fluence: the map holds collisions of emitted light alone.
  const BatchMean by_fluence = of(absorbed_by_fluence(world, light.maps[0].volume));
  INFO("roulette " << by_roulette.mean << " +- " << by_roulette.standard_error << ", escape " << by_escape.mean
                   << ", fluence " << by_fluence.mean << " +- " << by_fluence.standard_error);
  CHECK(agree(by_escape.mean, by_escape.standard_error, by_roulette.mean,
              {.resolution = 0.02, .reference_error = by_roulette.standard_error, .degrees_of_freedom = 15}));
  // The kernel blurs across voxels whose extinction differs; that may cost 1 %.
  CHECK(std::abs(by_fluence.mean - by_roulette.mean) <
        3 * std::hypot(by_fluence.standard_error, by_roulette.standard_error) + 0.01 * by_roulette.mean);
  CHECK(by_fluence.standard_error < 0.01 * by_roulette.mean);
}

TEST_CASE("parts of the light that are switched off one by one add up to the whole", "[physics][parts]") {
  const CloudWish wish = rough_wish(0.8, 0.6, 2);
  WorldContents contents = grey_contents(wish, 0.7);
  contents.sun = Sun{Vec3d(0.3, -0.5, 0.8).normalized(), {5}, 0.01};
  contents.sources.push_back({Vec3d(4, 1.6, 1.6), 0.3, {30}});
  contents.materials = {grey_material(0.6, 0.3)};
  contents.objects = {grey_object(parallelogram({-3, -3, -0.5}, {9, 0, 0}, {0, 9, 0}), 0, 4)};
  const World world(std::move(contents));
  TraceSettings trace;
  trace.photons = 100000;
  const Light light = trace_light(world, trace);
  // Through a thin part of the cloud to the floor.
  const Ray ray{{-2, 0.7, 2.9}, Vec3d(1, 0.1, -0.7).normalized(), 0, kInfinity};
  RadianceSettings settings;
  const double whole = ray_radiance(world, light, ray, 200, settings).mean;
  double sum = 0;
  for (bool RadianceParts::*part :
       {&RadianceParts::background, &RadianceParts::emission, &RadianceParts::sun, &RadianceParts::sky,
        &RadianceParts::surfaces, &RadianceParts::spheres, &RadianceParts::map}) {
    RadianceSettings one = settings;
    one.parts = {false, true, false, false, false, false, false, false};
    one.parts.*part = true;
    const double value = ray_radiance(world, light, ray, 200, one).mean;
    CHECK(value > 0);
    sum += value;
  }
  // Streams of random numbers shift when a part is off, so the sums agree within the noise of rays.
  CHECK(sum == Approx(whole).epsilon(0.02));
}

TEST_CASE("photons of sources that are switched off one by one add up to all photons' power", "[physics][parts]") {
  const CloudWish wish = rough_wish(0.8, 0.6, 2);
  WorldContents contents = grey_contents(wish, 0.7);
  contents.sun = Sun{Vec3d(0.3, -0.5, 0.8).normalized(), {5}, 0.01};
  contents.sources.push_back({Vec3d(4, 1.6, 1.6), 0.3, {30}});
  contents.particles.push_back({Vec3d(-1, 1.6, 1.6), 0.1, {30}});
  contents.beams.push_back({Vec3d(1.6, 1.6, -2), Vec3d(0, 0, 1), 0.2, {4}});
  contents.materials = {grey_material(0.6, 0.3)};
  contents.objects = {grey_object(parallelogram({-3, -3, -3}, {9, 0, 0}, {0, 9, 0}), 0, 4)};
  const World world(std::move(contents));
  const auto absorbed = [&](const SourceSelection& sources) {
    TraceSettings settings;
    settings.photons = 200000;
    settings.sources = sources;
    return of(trace_light(world, settings).bands[0].energy.absorbed);
  };
  const BatchMean whole = absorbed({});
  double sum = 0, error2 = 0;
  for (bool SourceSelection::*source :
       {&SourceSelection::emission, &SourceSelection::sun, &SourceSelection::sky, &SourceSelection::spheres,
        &SourceSelection::particles, &SourceSelection::beams, &SourceSelection::surfaces}) {
    SourceSelection one{false, false, false, false, false, false, false};
    one.*source = true;
    const BatchMean part = absorbed(one);
    CHECK(part.mean > 0);
    sum += part.mean;
    error2 += part.standard_error * part.standard_error;
  }
  CHECK(agree(sum, std::sqrt(error2), whole.mean, {.resolution = 0.05, .reference_error = whole.standard_error}));
}
