// Hard cases that have an answer of their own, for every estimator: closed forms, limits, symmetries and the
// tables h2 and h3 of the reference.
#include <catch2/catch.hpp>

#include "octree/base/error.h"
#include "photon/ordinates/ordinates.h"
#include "photon/paths/path_tracer.h"
#include "tests/support/agree.h"
#include "tests/support/estimators.h"
#include "tests/support/planck_band.h"

using namespace obscura;
using namespace obscura::test;

namespace {

constexpr double kB = 2;

Light photons_of(const World& world, std::uint64_t count, std::uint64_t seed = 1) {
  TraceSettings trace;
  trace.photons = count;
  trace.seed = seed;
  return trace_light(world, trace);
}

double one_ray(const World& world, const Ray& ray, const MethodType& method) {
  return seen(world, {}, method, {&ray, 1}, 1).mean;
}

/// A box of these voxels that absorbs alone, 1/m, and is as bright as kB, before a sky.
World absorber(const Vec3i& voxels, double voxel_m, double extinction, double sky, const Vec3d& corner = Vec3d(0)) {
  CloudWish wish;
  wish.voxels = voxels;
  wish.voxel_m = voxel_m;
  wish.extinction = extinction;
  wish.source = kB;
  wish.corner_m = corner;
  return World(grey_contents(wish, sky));
}

double total(const BatchTally& tally) { return pairwise_sum(tally); }

BatchMean per_area(BatchTally tally, double area) {
  for (double& value : tally) value *= kBatches / area;
  return batch_mean(tally);
}

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

TEST_CASE("optical depths of 1e-10 to 1e6 emit and let through what the exponential says", "[stability][limits]") {
  for (double depth = 1e-10; depth < 2e6; depth *= 10) {
    // Voxels of a power of two metres: exact in float, from a millimetre to a hundred kilometres.
    for (const double voxel : {0x1p-10, 1.0, 0x1p17}) {
      const World world = absorber(Vec3i(8), voxel, depth / (8 * voxel), 0);
      const Ray ray{Vec3d(-3, 3.3, 4.7) * voxel, {1, 0, 0}, 0, kInfinity};
      for (const MethodType* method : kMonteCarlo) {
        INFO("depth " << depth << ", voxels of " << voxel << " m, " << method->name);
        CHECK(one_ray(world, ray, *method) == Approx(-kB * std::expm1(-depth)).epsilon(3e-6));
      }
      // The World's walk in double, and its batched walk.
      const LocalOptics inside = world.at(0, Vec3d(4.5) * voxel);
      CHECK(inside.extinction * 8 * voxel == Approx(depth).epsilon(1e-12));
      double batched = 0;
      world.optical_depths(0, {&ray, 1}, {&batched, 1});
      CHECK(batched == Approx(depth).epsilon(1e-5));
      OrdinatesSettings ordinates;
      ordinates.cells = Vec3i(4);
      ordinates.order = 2;
      std::vector<Incoming> in(1);
      solve_ordinates(world, 0, ordinates).radiance({&ray, 1}, in);
      CHECK(in[0].direct == Approx(-kB * std::expm1(-depth)).epsilon(1e-6));
    }
  }
}

TEST_CASE("through an optical depth of 1e-10 light scatters once, wherever the sun stands on an axis",
          "[stability][limits]") {
  // To first order w p(angle) E tau, whatever the sensor's direction.
  constexpr double kDepth = 1e-10, kAlbedo = 0.7, kG = 0.5, kSun = 3;
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.voxel_m = 0.125;
  wish.extinction = kDepth;
  wish.albedo = kAlbedo;
  wish.phase = PhaseFunction::henyey_greenstein(kG);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      Vec3d toward(0);
      toward[axis] = sign;
      for (const double diameter : {0.0, 0.0093}) {
        WorldContents contents = grey_contents(wish);
        contents.sun = Sun{toward, {kSun}, diameter};
        const World world(contents);
        Vec3d along(0);
        along[(axis + 1) % 3] = 1;
        const Ray ray{Vec3d(0.3, 0.4, 0.6) - 3.0 * along, along, 0, kInfinity};
        // The ray begins 2.4 to 2.7 m before the cloud and crosses all of it.
        const double expected = kAlbedo * PhaseFunction::henyey_greenstein(kG).value(0) * kSun * kDepth;
        for (const MethodType* method : kMonteCarlo) {
          INFO("axis " << axis << ", " << method->name);
          CHECK(seen(world, {}, *method, {&ray, 1}, 400).mean == Approx(expected).epsilon(diameter > 0 ? 1e-3 : 1e-5));
        }
        std::vector<Incoming> in(1);
        OrdinatesSettings ordinates;
        ordinates.cells = Vec3i(4);
        solve_ordinates(world, 0, ordinates).radiance({&ray, 1}, in);
        CHECK(in[0].direct == Approx(expected).epsilon(1e-3));
      }
    }
  }
}

TEST_CASE("the sun along an axis lights a cloud along faces and edges of voxels as beside them",
          "[stability][limits]") {
  // Light scattered once at the depth a of the sun and seen at right angles:
  // w p E e^(-k a) (1 - e^(-k D)).
  constexpr double kExtinction = 1.5, kAlbedo = 0.8, kSun = 3, kSide = 2;
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.voxel_m = 0.25;
  wish.extinction = kExtinction;
  wish.albedo = kAlbedo;
  WorldContents contents = grey_contents(wish);
  for (int axis = 0; axis < 3; ++axis) {
    const int side = (axis + 1) % 3, other = (axis + 2) % 3;
    Vec3d toward(0);
    toward[axis] = -1;
    contents.sun = Sun{toward, {kSun}, 0};
    const World world(contents);
    for (const double depth : {0.0, 0.25, 0.6, 1.0, 1.75}) {
      for (const double place : {0.0, 0.1, 0.5, 1.75}) {
        Ray ray;
        ray.direction = Vec3d(0);
        ray.direction[side] = 1;
        ray.origin[axis] = depth;
        ray.origin[other] = place;
        ray.origin[side] = -1;
        const double expected =
            kAlbedo / (4 * kPi) * kSun * std::exp(-kExtinction * depth) * -std::expm1(-kExtinction * kSide);
        RadianceSettings once;
        once.scattering_depth = 1;
        for (const MethodType* method : kMonteCarlo) {
          INFO("axis " << axis << ", at " << depth << " and " << place << ", " << method->name);
          // Shadow rays of paths that go deep end by roulette.
          const Seen light = seen(world, {}, *method, {&ray, 1}, 800, once);
          CHECK(std::abs(light.mean - expected) <= 6 * light.error + 1e-4 * expected);
          CHECK(light.error <= 0.02 * expected);
        }
      }
    }
  }
}

TEST_CASE("a camera in a cloud, on its faces, edges and corners sees what lies ahead", "[stability][limits]") {
  const Vec3d far(1e7, -1e7, 1e7);
  for (const Vec3d& corner : {Vec3d(0), far}) {
    const World world = absorber(Vec3i(8), 0.5, 0.3, 0.5, corner);
    const double accuracy = corner == Vec3d(0) ? 3e-6 : 1e-5;
    Stream random(1, 0, 0);
    for (int i = 0; i < 300; ++i) {
      Vec3d at(4 * random.uniform(), 4 * random.uniform(), 4 * random.uniform());
      for (int axis = 0; axis < 3; ++axis) {
        const double u = random.uniform();
        if (i % 3 == 1) at[axis] = 0.5 * std::floor(2 * at[axis]);  // a voxel's corner
        if (i % 3 == 2 && u < 0.6) at[axis] = u < 0.3 ? 0.0 : 4.0;  // a face, edge or corner of the cloud
      }
      Vec3d way = random_direction(random);
      // How far it is to leave the box, by hand.
      double length = kInfinity;
      for (int axis = 0; axis < 3; ++axis) {
        length = std::min(length, way[axis] > 0 ? (4 - at[axis]) / way[axis] : at[axis] / -way[axis]);
      }
      length = std::max(0.0, length);
      const Ray ray{corner + at, way, 0, kInfinity};
      for (const MethodType* method : kMonteCarlo) {
        const double expected = 0.5 * std::exp(-0.3 * length) - kB * std::expm1(-0.3 * length);
        CHECK(one_ray(world, ray, *method) == Approx(expected).epsilon(accuracy));
        if (length == 0 && corner == Vec3d(0)) CHECK(one_ray(world, ray, *method) == 0.5);
      }
    }
  }
}

TEST_CASE("250 K beside 3000 K: each ray has its voxels' own Planck radiance", "[stability][limits]") {
  // Layers along x, hot and cold in turn, of one absorbing cloud in a real band.
  for (const double extinction : {1e-6, 0.5, 1e5}) {
    VoxelStream stream = field_stream(Box3i(Vec3i(0), Vec3i(8)), {"density", "K"}, [](int channel, const Vec3i& v) {
      return channel == 0 ? 1.0f : v.x % 2 ? 3000.0f : 250.0f;
    });
    BuildSettings lossless;
    lossless.tolerance = 0;
    Cloud cloud;
    cloud.name = "hot and cold";
    cloud.octree = std::make_shared<const Octree>(build_octree(stream, lossless).first);
    cloud.media.push_back({0, {extinction}, {0.0}, {}});
    cloud.temperature.channel = 1;
    WorldContents contents;
    contents.bands.emplace_back("mwir", 3.0, 5.0, 1, Spectrum::constant(1));
    contents.clouds.push_back(cloud);
    const World world(contents);
    const double cold = test::planck_band(3, 5, 250), hot = test::planck_band(3, 5, 3000);
    CHECK(hot > 1e5 * cold);
    const auto layers = [&](bool cold_first) {
      double radiance = 0, transmission = 1;
      for (int i = 0; i < 8; ++i) {
        radiance += transmission * -std::expm1(-extinction) * ((i % 2 == 0) == cold_first ? cold : hot);
        transmission *= std::exp(-extinction);
      }
      return radiance;
    };
    const auto layer_alone = [&](double black) { return -black * std::expm1(-8 * extinction); };
    for (const MethodType* method : kMonteCarlo) {
      INFO("extinction " << extinction << ", " << method->name);
      CHECK(one_ray(world, {{-1, 3.3, 4}, {1, 0, 0}, 0, kInfinity}, *method) == Approx(layers(true)).epsilon(1e-5));
      CHECK(one_ray(world, {{9, 3.3, 4}, {-1, 0, 0}, 0, kInfinity}, *method) == Approx(layers(false)).epsilon(1e-5));
      // Along the layers; in a face between two of them it is the upper one's.
      CHECK(one_ray(world, {{4.5, 3.3, -1}, {0, 0, 1}, 0, kInfinity}, *method) ==
            Approx(layer_alone(cold)).epsilon(1e-5));
      CHECK(one_ray(world, {{4.999999, 3.3, -1}, {0, 0, 1}, 0, kInfinity}, *method) ==
            Approx(layer_alone(cold)).epsilon(1e-5));
      CHECK(one_ray(world, {{4, 3, -1}, {0, 0, 1}, 0, kInfinity}, *method) == Approx(layer_alone(cold)).epsilon(1e-5));
      CHECK(one_ray(world, {{5, 3, 9}, {0, 0, -1}, 0, kInfinity}, *method) == Approx(layer_alone(hot)).epsilon(1e-5));
    }
    std::vector<Incoming> in(1);
    const Ray along{{4.5, 3.3, -1}, {0, 0, 1}, 0, kInfinity};
    OrdinatesSettings ordinates;
    ordinates.cells = Vec3i(8);
    ordinates.order = 4;
    solve_ordinates(world, 0, ordinates).radiance({&along, 1}, in);
    CHECK(in[0].direct == Approx(layer_alone(cold)).epsilon(1e-5));
  }
}

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
      const TraceResult traced = trace_photons(lit, 0, trace, planes);
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
    const TraceResult traced = trace_photons(world, 0, trace, planes);
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
    const PathFlux reflected = path_flux(world, 0, {}, planes[0], 9000, 1),
                   transmitted = path_flux(world, 0, {}, planes[1], 9000, 2);
    CHECK(agree(reflected.forward.mean, reflected.forward.standard_error, row.reflected,
                {.resolution = 0.9, .comparisons = 20}));
    CHECK(agree(transmitted.backward.mean, transmitted.backward.standard_error, row.transmitted,
                {.resolution = 0.4, .comparisons = 20}));
  }
}

TEST_CASE("what has been scaled by a power of two looks the same to the bit of its error", "[stability][limits]") {
  // Lengths times s, extinction over s: radiance is the same number, from 1 mm to 100 km a voxel.
  const auto look = [](double scale) {
    CloudWish wish = rough_wish(0.8, 0.5, 1);
    wish.voxel_m = 0.125 * scale;
    wish.extinction = 3 / scale;
    WorldContents contents = grey_contents(wish, 0.3);
    contents.sun = Sun{Vec3d(0.3, -0.4, 0.8).normalized(), {2}, 0.01};
    const World world(contents);
    const Light light = photons_of(world, 20000);
    const Ray ray{scale * Vec3d(-2, 1.1, 3), Vec3d(0.8, 0.2, -0.3).normalized(), 0, kInfinity};
    std::vector<double> values;
    for (const MethodType* method : kMonteCarlo) {
      values.push_back(seen(world, light, *method, {&ray, 1}, 50).mean);
      values.push_back(fluence_by(world, light, *method, scale * Vec3d(2, 2, 2), 50).mean);
    }
    return values;
  };
  const auto one = look(1);
  for (const double scale : {0x1p-7, 0x1p20}) {
    const auto scaled = look(scale);
    for (std::size_t i = 0; i < one.size(); ++i) {
      INFO("scale " << scale << ", value " << i);
      CHECK(scaled[i] == Approx(one[i]).epsilon(1e-6));
    }
  }
}

TEST_CASE("no photons leave direct light alone, one photon is all the power there is", "[stability][few]") {
  CloudWish wish = rough_wish(0.7, 0.3);
  WorldContents contents = grey_contents(wish);
  contents.sun = Sun{{0, 0, 1}, {3}, 0};
  const World world(contents);
  const Ray ray{{1.6, -2, 1.7}, {0, 1, 0}, 0, kInfinity};
  RadianceSettings direct;
  direct.parts.map = false;
  const Light none = photons_of(world, 0);
  CHECK(none.emitted == 0);
  CHECK(none.stored == 0);
  const Seen without = seen(world, none, kPhotonMap, {&ray, 1}, 20);
  CHECK(without.mean == seen(world, {}, kPhotonMap, {&ray, 1}, 20, direct).mean);
  CHECK(without.mean > 0);
  CHECK(without.anomalies == 0);
  CHECK(seen(world, none, kFinalGather, {&ray, 1}, 20).anomalies == 0);

  const double power = 3 * kPi * world.bounds().size().length2() / 4;
  double worst = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Light one = photons_of(world, 1, seed);
    const EnergyTally& energy = one.bands[0].energy;
    CHECK(one.emitted == 1);
    CHECK(total(energy.emitted) == Approx(power).epsilon(1e-6));
    CHECK(total(energy.absorbed) + total(energy.escaped) == Approx(power).epsilon(1e-6));
    const Seen with = seen(world, one, kPhotonMap, {&ray, 1}, 1);
    CHECK(with.anomalies == 0);
    worst = std::max(worst, std::abs(with.mean - without.mean));
  }
  CHECK(std::isfinite(worst));
}

TEST_CASE("with fewer photons than neighbours the furnace is black in the mean", "[stability][few]") {
  CloudWish wish;
  wish.voxels = Vec3i(4);
  wish.voxel_m = 0.25;
  wish.extinction = 1;
  wish.albedo = 0.5;
  wish.source = kB;
  const World world(grey_contents(wish, kB));
  const Ray ray{{-1, 0.4, 0.6}, {1, 0, 0}, 0, kInfinity};
  Moments maps;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const Light light = photons_of(world, 150, seed);
    CHECK(light.stored < 64);
    RadianceSettings settings;
    settings.seed = seed;
    maps.add(seen(world, light, kPhotonMap, {&ray, 1}, 4, settings).mean);
  }
  INFO(maps.mean() << " +- " << maps.standard_error());
  CHECK(std::abs(maps.mean() - kB) <= 5 * maps.standard_error() + 0.03 * kB);
  CHECK(maps.standard_error() < 0.02 * kB);
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
        const BatchMean up = per_area(trace_photons(World(contents), 0, trace, {&above, 1}).flux[0].forward, 1);
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

TEST_CASE("all photons in one place have no density, and are absorbed and escape as they should", "[stability][few]") {
  // A beam without width on 1e9 a metre, beside the middle: the map's floats are farther apart than the light gets.
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.voxel_m = 128;
  wish.extinction = 1e9;
  wish.albedo = 0.3;
  const World world([&] {
    WorldContents contents = grey_contents(wish);
    contents.beams.push_back({{612, 412, 2000}, {0, 0, -1}, 0, {5}});
    return contents;
  }());
  TraceSettings trace;
  trace.photons = 5000;
  const TraceResult traced = trace_photons(world, 0, trace);
  const BatchMean escaped = per_area(traced.energy.escaped, 5);
  // d4: a half space of albedo 0.3 reflects this much of a normal beam.
  CHECK(agree(escaped.mean, escaped.standard_error, 0.05721435060125, {.resolution = 1, .degrees_of_freedom = 15}));
  CHECK(total(traced.energy.absorbed) + total(traced.energy.escaped) == Approx(5).epsilon(1e-9));
  CHECK(traced.photons.size() > 5000);
  for (const Photon& photon : traced.photons) CHECK(photon.position == traced.photons.front().position);
  const Light light = photons_of(world, 5000);
  const Ray onto{{612, 412, 1500}, Vec3d(0.001, 0, -1).normalized(), 0, kInfinity};
  const Seen there = seen(world, light, kPhotonMap, {&onto, 1}, 20);
  CHECK(there.anomalies == 0);
  CHECK(there.mean == 0);
}

TEST_CASE("an empty cloud, in the way of every estimator, changes no bit", "[stability][limits]") {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.albedo = 0.9;
  wish.source = kB;
  for (const bool no_density : {true, false}) {
    CloudWish empty = wish;
    if (no_density)
      empty.density = [](const Vec3i&) { return 0.0; };
    else
      empty.extinction = 0;
    WorldContents contents = grey_contents(empty, 0.7);
    contents.sun = Sun{{0, 1, 0}, {3}, 0.01};
    const World world(contents);
    const Light light = photons_of(world, 1000);
    CHECK(light.stored == 0);
    Stream random(5, 0, 0);
    for (int i = 0; i < 100; ++i) {
      const Ray ray{Vec3d(8 * random.uniform(), 8 * random.uniform(), 8 * random.uniform()), random_direction(random),
                    0, kInfinity};
      if (world.suns()[0].covers(ray.direction)) continue;
      for (const MethodType* method : kMonteCarlo) CHECK(seen(world, light, *method, {&ray, 1}, 1).mean == 0.7);
    }
    const BatchMean around = fluence_by(world, light, kPathTracer, {4, 4, 4}, 50);
    CHECK(around.mean == Approx(4 * kPi * 0.7 + 3).epsilon(1e-12));
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
  const OrdinatesSolution solution = solve_ordinates(endless, 0, settings);
  const OrdinatesPowers& powers = solution.powers();
  // d5: 1.7e-6 of the sun at the zenith comes through, all the rest is reflected.
  CHECK(powers.left[2][1] == Approx(1).epsilon(1e-4));
  // Where light is absorbed in time, or goes on, nothing is refused.
  CHECK_FALSE(unfit_for_paths(layer(1e6, 0.9, PhaseFunction::isotropic(), 1)));
  CHECK_FALSE(unfit_for_paths(layer(1e6, 1, PhaseFunction::henyey_greenstein(0.9999), 1)));
}
