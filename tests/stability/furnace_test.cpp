// A cloud as bright as its surroundings is invisible, whatever it is made of (reference h4): the right answer to
// most hard cases at once, for every estimator of radiance, fluence and flux.
#include <catch2/catch.hpp>

#include "photon/ordinates/ordinates.h"
#include "photon/paths/path_tracer.h"
#include "tests/support/agree.h"
#include "tests/support/estimators.h"

using namespace obscura;
using namespace obscura::test;

namespace {

constexpr double kB = 2;  // of the cloud and all around it
constexpr int kComparisons = 1000;
constexpr double kMapError = 0.13;  // most that the map's standard error may be, relative
constexpr double kRounding = 1e-6;  // of the batched walk, relative

struct Furnace {
  std::uint64_t photons = 40000;
  int nearest = 64;
  double map_error = kMapError;
  bool photon_flux = true;  // whether enough photons pass the rectangle
  bool far = false;         // so far away that rounding decides on which side of a voxel's face a ray runs
};

/// A cube of 8^3 voxels whose longest side has this depth.
CloudWish cube(double depth, double albedo, double g = 0) {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.voxel_m = 0.125;
  wish.extinction = depth;
  wish.albedo = albedo;
  wish.source = albedo < 1 ? kB : 0;
  if (g != 0) wish.phase = PhaseFunction::henyey_greenstein(g);
  return wish;
}

/// Rays of every kind that one may take through a box: slanted, along faces and edges of voxels, through corners,
/// from inside, from a face of the box.
std::vector<Ray> rays_through(const Box3d& box) {
  const Vec3d size = box.size();
  const auto at = [&](double x, double y, double z) { return box.min + Vec3d(x * size.x, y * size.y, z * size.z); };
  const auto from_to = [](const Vec3d& a, const Vec3d& b) { return Ray{a, (b - a).normalized(), 0, kInfinity}; };
  return {from_to(at(-1, 0.43, 0.51), at(2, 0.7, 0.3)), from_to(at(-1, 0.5, 0.51), at(1, 0.5, 0.51)),
          from_to(at(0.5, 0.5, 3), at(0.5, 0.5, 0)),    from_to(at(-1, -1, -1), at(1, 1, 1)),
          from_to(at(0.5, 0.5, 0.5), at(0, 1, 0.7)),    from_to(at(0.3, 0, 0.3), at(0.4, 1, 0.6)),
          from_to(at(0.3, 0.7, 1), at(0.3, 0.7, 0)),    from_to(at(0, 0, 0.5), at(1, 1, 0.5))};
}

bool runs_along_faces(const Ray& ray) { return ray.direction.x == 0 || ray.direction.y == 0 || ray.direction.z == 0; }

void check_furnace(const std::string& name, const WorldContents& contents, const Furnace& furnace = {}) {
  INFO(name);
  const World world(contents);
  const Box3d& box = world.bounds();
  const Vec3d size = box.size();
  const std::vector<Ray> rays = rays_through(box);

  // Flux through a rectangle across the middle: pi B A either way.
  const FluxRectangle rectangle{box.center() + 0.01 * size, {1.3 * size.x, 0, 0}, {0, 1.3 * size.y, 0}};
  const double flux = kPi * kB * 1.69 * size.x * size.y;
  TraceSettings trace;
  trace.photons = furnace.photons;
  Box3d around_rectangle(box);
  for (const double side : {-0.5, 0.5})
    around_rectangle.extendBy(rectangle.center + side * (rectangle.side_u + rectangle.side_v));
  const TraceResult traced = trace_photons(PhotonEmitter({world, 0}, {}, around_rectangle), trace, {&rectangle, 1});
  CHECK(traced.anomalies == 0);
  for (BatchTally tally : {traced.flux[0].forward, traced.flux[0].backward}) {
    if (!furnace.photon_flux) break;
    for (double& batch : tally) batch *= kBatches;
    const BatchMean found = batch_mean(tally);
    CHECK(agree(found.mean, found.standard_error, flux,
                {.resolution = 1.2, .comparisons = kComparisons, .degrees_of_freedom = 15}));
  }
  const PathFlux by_paths = path_flux({world, 0}, {}, rectangle, 900, 3);
  for (const BatchMean& found : {by_paths.forward, by_paths.backward}) {
    CHECK(agree(found.mean, found.standard_error, flux,
                {.resolution = 0.25, .reference_error = kRounding * flux, .comparisons = kComparisons}));
  }

  const Light light = trace_light(world, trace);
  CHECK(light.anomalies == 0);

  OrdinatesSettings ordinates;
  ordinates.cells = Vec3i(8);
  ordinates.order = 4;
  const OrdinatesSolution solution = solve_ordinates({world, 0}, ordinates);
  std::vector<Incoming> incoming(rays.size());
  solution.radiance(rays, incoming);
  for (std::size_t i = 0; i < incoming.size(); ++i) {
    if (furnace.far && runs_along_faces(rays[i])) continue;
    CHECK(incoming[i].total() == Approx(kB).epsilon(1e-4));
  }
  for (std::size_t cell = 0; cell < 512; cell += 37)
    CHECK(solution.fluence(cell) == Approx(4 * kPi * kB).epsilon(1e-4));
  CHECK(solution.flux(77).length() < 1e-4 * kB);

  for (const MethodType* method : kMonteCarlo) {
    const bool map = method->photons;
    INFO(method->name);
    RadianceSettings settings;
    settings.gather.nearest = furnace.nearest;
    const Seen radiance = seen(world, light, *method, rays, 60, settings);
    const BatchMean around =
        fluence_by(world, light, *method, box.min + Vec3d(0.3 * size.x, 0.4 * size.y, 0.9 * size.z), 400);
    CHECK(radiance.anomalies == 0);
    INFO("radiance " << radiance.mean << " +- " << radiance.error << " (bias " << radiance.bias << "), fluence / 4 pi "
                     << around.mean / (4 * kPi) << " +- " << around.standard_error / (4 * kPi));
    if (map) {
      // The kernel's bias and sixteen batches' error.
      CHECK(std::abs(radiance.mean - kB) <= 5 * radiance.error + 0.04 * kB);
      CHECK(radiance.error <= furnace.map_error * kB);
      CHECK(std::abs(around.mean - 4 * kPi * kB) <= 5 * around.standard_error + 0.04 * 4 * kPi * kB);
      CHECK(around.standard_error <= 2.5 * furnace.map_error * 4 * kPi * kB);
    } else {
      CHECK(agree(radiance.mean, radiance.error, kB,
                  {.resolution = 0.1, .reference_error = kRounding * kB, .comparisons = kComparisons}));
      CHECK(agree(around.mean, around.standard_error, 4 * kPi * kB,
                  {.resolution = 0.2, .reference_error = kRounding * 4 * kPi * kB, .comparisons = kComparisons}));
    }
  }
}

void check_furnace(const std::string& name, const CloudWish& wish, const Furnace& furnace = {}) {
  check_furnace(name, grey_contents(wish, kB), furnace);
}

}  // namespace

TEST_CASE("furnaces of optical depth 1e-10 to 1e6 are black", "[stability][furnace]") {
  for (const double depth : {1e-10, 1e-6, 1e-3, 1.0, 30.0, 1e3, 1e6}) {
    for (const double albedo : {0.0, 0.5}) {
      Furnace furnace;
      // In the thick ones' middle hardly a photon comes far enough to pass the rectangle.
      furnace.photon_flux = depth < 100;
      check_furnace("depth " + std::to_string(depth) + ", albedo " + std::to_string(albedo), cube(depth, albedo),
                    furnace);
    }
  }
}

TEST_CASE("furnaces of albedo 0 to 1, and 1 - 1e-9, are black", "[stability][furnace]") {
  for (const double albedo : {0.0, 0.9, 0.999, 1 - 1e-9, 1.0}) {
    for (const double depth : {1e-3, 1.0, 10.0}) {
      check_furnace("depth " + std::to_string(depth) + ", 1 - albedo " + std::to_string(1 - albedo),
                    cube(depth, albedo));
    }
  }
}

TEST_CASE("furnaces that scatter straight on or straight back are black", "[stability][furnace]") {
  for (const double g : {0.9999, -0.9999, 1.0, -1.0}) {
    for (const double depth : {1e-3, 1.0, 30.0}) {
      Furnace furnace;
      // Few photons leave the beams of others: the map knows little, and says so.
      if (depth > 1) furnace.map_error = 1;
      check_furnace("g " + std::to_string(g) + ", depth " + std::to_string(depth), cube(depth, 0.9, g), furnace);
    }
  }
}

TEST_CASE("furnaces of voxels from 1 mm to 100 km, and of 1 : 100, are black", "[stability][furnace]") {
  for (const double voxel : {1e-3, 1e5}) {
    CloudWish wish = cube(5, 0.6, 0.5);
    wish.extinction = 5 / (8 * voxel);
    wish.voxel_m = voxel;
    check_furnace("voxels of " + std::to_string(voxel) + " m", wish);
  }
  for (const int axis : {0, 2}) {
    CloudWish flat = cube(5, 0.6, 0.5);
    flat.stretch[axis] = 0.01;
    Furnace few;
    few.photon_flux = false;  // such a small rectangle
    check_furnace("voxels flat along axis " + std::to_string(axis), flat, few);
    CloudWish needle = cube(5, 0.6, 0.5);
    needle.stretch = Vec3d(0.01);
    needle.stretch[axis] = 1;
    check_furnace("voxels long along axis " + std::to_string(axis), needle, few);
  }
}

TEST_CASE("a furnace 1e7 m from the origin is black", "[stability][furnace]") {
  CloudWish wish = rough_wish(0.6, 0.3, kB);
  wish.corner_m = Vec3d(1e7, -1e7, 1e7);
  Furnace furnace;
  furnace.far = true;
  check_furnace("rough cloud far away", wish, furnace);
}

TEST_CASE("thin in thick and thick in thin are black furnaces", "[stability][furnace]") {
  const auto inside = [](const Vec3i& v) { return std::min({v.x, v.y, v.z}) >= 2 && std::max({v.x, v.y, v.z}) < 6; };
  for (const bool thick_inside : {false, true}) {
    for (const double contrast : {1e-2, 1e-6, 0.0}) {
      for (const double depth : {20.0, 1e4}) {
        CloudWish wish = cube(depth, 0.5);
        wish.density = [=](const Vec3i& v) { return inside(v) == thick_inside ? 1.0 : contrast; };
        Furnace furnace;
        furnace.photon_flux = depth < 100;
        check_furnace((thick_inside ? "thick in thin " : "thin in thick ") + std::to_string(contrast) + ", depth " +
                          std::to_string(depth),
                      wish, furnace);
      }
    }
  }
}

TEST_CASE("a single voxel is a black furnace", "[stability][furnace]") {
  for (const double depth : {1e-6, 1.0, 50.0}) {
    CloudWish wish = cube(depth, 0.7);
    wish.voxels = Vec3i(1);
    wish.voxel_m = 1;
    check_furnace("single voxel of depth " + std::to_string(depth), wish);
    // One that stands alone among empty ones.
    CloudWish alone = cube(8 * depth, 0.7);
    alone.density = [](const Vec3i& v) { return v == Vec3i(3, 4, 5) ? 1.0 : 0.0; };
    check_furnace("single voxel among empty ones, depth " + std::to_string(depth), alone);
  }
}

TEST_CASE("overlapping clouds of all kinds are a black furnace", "[stability][furnace]") {
  WorldContents contents = grey_contents(cube(3, 0.5, 0.8), kB);
  CloudWish thin = cube(1e-5, 0.9, -0.5);
  thin.voxel_m = 0.25;
  thin.corner_m = {-0.5, -0.5, 0.1};
  contents.clouds.push_back(make_cloud(thin));
  CloudWish thick = cube(200, 0);
  thick.corner_m = {0.5, 0.5, 0.5};
  contents.clouds.push_back(make_cloud(thick));
  CloudWish same = cube(3, 0.2);  // in the very place of the first
  contents.clouds.push_back(make_cloud(same));
  check_furnace("four clouds", contents);
}

TEST_CASE("furnaces that are none are told: a sky or a source 10 % off", "[stability][furnace]") {
  WorldContents contents = grey_contents(cube(1, 0.5), 0.9 * kB);
  const World world(contents);
  const std::vector<Ray> rays = rays_through(world.bounds());
  TraceSettings trace;
  trace.photons = 40000;
  const Light light = trace_light(world, trace);
  for (const MethodType* method : kMonteCarlo) {
    INFO(method->name);
    const Seen radiance = seen(world, light, *method, rays, 60);
    CHECK(std::abs(radiance.mean - kB) > 5 * radiance.error + 0.02 * kB);
  }
}
