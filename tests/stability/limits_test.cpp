// Hard cases that have an answer of their own, for every estimator: closed forms, limits and symmetries.
#include "tests/stability/limits.h"

#include <catch2/catch.hpp>

#include "photon/ordinates/ordinates.h"
#include "tests/support/estimators.h"
#include "tests/support/planck_band.h"

using namespace obscura;
using namespace obscura::test;

namespace {

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
      const LocalOptics inside = SpectralWorld(world, 0).at(Vec3d(4.5) * voxel);
      CHECK(inside.extinction * 8 * voxel == Approx(depth).epsilon(1e-12));
      double batched = 0;
      SpectralWorld(world, 0).optical_depths({&ray, 1}, {&batched, 1});
      CHECK(batched == Approx(depth).epsilon(1e-5));
      OrdinatesSettings ordinates;
      ordinates.cells = Vec3i(4);
      ordinates.order = 2;
      std::vector<Incoming> in(1);
      solve_ordinates({world, 0}, ordinates).radiance({&ray, 1}, in);
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
        solve_ordinates({world, 0}, ordinates).radiance({&ray, 1}, in);
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
    solve_ordinates({world, 0}, ordinates).radiance({&along, 1}, in);
    CHECK(in[0].direct == Approx(layer_alone(cold)).epsilon(1e-5));
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
