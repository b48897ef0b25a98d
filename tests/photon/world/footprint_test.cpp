// Rays with a footprint: what coarse cells change stays below its bound, nothing changes without them.
#include "photon/world/footprint.h"

#include <catch2/catch.hpp>

#include "photon/paths/direct_light.h"
#include "photon/paths/radiance.h"
#include "photon/world/world_walk.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

constexpr int kSide = 64;

/// Density and kelvin of a voxel.
using HotField = std::function<std::pair<double, double>(const Vec3i&)>;

std::pair<double, double> plume(const Vec3i& v) {
  const double x = v.x - 30.0 - 0.1 * v.z, y = v.y - 33.0, width = 6 + 0.15 * v.z,
               q = (x * x + y * y) / (width * width);
  return q < 9 ? std::pair(std::exp(-0.5 * q), 400 + 500 * std::exp(-0.25 * q)) : std::pair(0.0, 0.0);
}

std::pair<double, double> rough(const Vec3i& v) {
  const double brick = voxel_noise(7, Vec3i(v.x >> 3, v.y >> 3, v.z >> 3));
  const double density = brick < 0.3 ? 0.0 : (brick < 0.6 ? 0.01 : 1.0) * std::max(0.0, voxel_noise(8, v) - 0.2);
  return {density, density > 0 ? 300 + 700 * voxel_noise(9, v) : 0.0};
}

std::pair<double, double> nearly_even(const Vec3i& v) {
  return {1 + 0.02 * voxel_noise(3, v), 600 + 10 * voxel_noise(4, v)};
}

struct HotWish {
  HotField field = plume;
  double extinction = 0.02, albedo = 0, voxel_m = 1, sky = 0;
  std::array<double, 2> period_m{0, 0};
  Vec3d corner_m{0, 0, 0};
};

Cloud hot_cloud(const HotWish& wish) {
  VoxelStream stream =
      field_stream(Box3i(Vec3i(0), Vec3i(kSide)), {"density", "temperature"}, [&](int channel, const Vec3i& v) {
        const auto [density, kelvin] = wish.field(v);
        return static_cast<float>(channel == 0 ? density : kelvin);
      });
  stream.index_to_local.makeIdentity();
  for (int i = 0; i < 3; ++i) stream.index_to_local[i][i] = wish.voxel_m;
  BuildSettings lossless;
  lossless.tolerance = 0;
  Cloud cloud;
  cloud.name = "hot";
  cloud.octree = std::make_shared<const Octree>(build_octree(stream, lossless).first);
  cloud.local_to_world = placement(wish.corner_m, Vec3d(0), 1);
  cloud.media.push_back({0, {wish.extinction}, {wish.albedo}, PhaseFunction::isotropic()});
  cloud.temperature.channel = 1;
  cloud.period_m = wish.period_m;
  return cloud;
}

World hot_world(const std::vector<HotWish>& wishes) {
  WorldContents contents;
  contents.bands.emplace_back("LWIR", 8.0, 12.0, 1, Spectrum::constant(1));
  for (const HotWish& wish : wishes) contents.clouds.push_back(hot_cloud(wish));
  contents.sky = {wishes.front().sky};
  return World(std::move(contents));
}

Ray random_ray(std::uint64_t i) {
  Stream random(11, i, 0);
  const auto point = [&] {
    const double x = random.uniform(), y = random.uniform(), z = random.uniform();
    return Vec3d(kSide * x, kSide * y, kSide * z);
  };
  const Vec3d a = point(), along = (point() - a).normalized();
  return {a - 300.0 * along, along};
}

struct Seen {
  double depth = 0, light = 0;
};

Seen seen(const World& world, const Ray& ray, CoarseCells* cells) {
  Seen result;
  result.light = detail::light_along({world, 0}, ray, cells);
  WorldWalk walk({world, 0}, ray);
  if (cells) {
    result.depth = cells->depth();
  } else {
    while (walk.next()) result.depth += walk.optics().extinction * (walk.end() - walk.begin());
  }
  return result;
}

/// Checks every ray against its own bound; returns what the walks did.
FootprintCounts require_bounds(const World& world, const Footprint& footprint, double tolerance, int rays) {
  const double source = SpectralWorld(world, 0).largest_source();
  FootprintCounts counts;
  double largest_use = 0;
  for (int i = 0; i < rays; ++i) {
    const Ray ray = random_ray(static_cast<std::uint64_t>(i));
    CoarseCells cells(footprint, tolerance, source);
    const Seen coarse = seen(world, ray, &cells), exact = seen(world, ray, nullptr);
    const double bound = cells.counts().error_bound;
    const double transmission = std::abs(std::exp(-coarse.depth) - std::exp(-exact.depth));
    const double light = std::abs(coarse.light - exact.light) / source;
    CAPTURE(i, bound, transmission, light);
    REQUIRE(bound <= tolerance);
    REQUIRE(transmission <= bound + 1e-12);
    REQUIRE(light <= bound + 1e-8);  // Planck's table
    REQUIRE(std::abs(coarse.depth - exact.depth) <= cells.depth_doubt() + 1e-12);
    counts += cells.counts();
    if (bound > 0) largest_use = std::max(largest_use, std::max(transmission, light) / bound);
  }
  // A bound that is never near is one that forbids for nothing.
  if (counts.coarse > 0) CHECK(largest_use > 0.02);
  return counts;
}

}  // namespace

TEST_CASE("what coarse cells change stays below each ray's bound", "[footprint]") {
  struct Case {
    const char* name;
    HotField field;
    double extinction;
  };
  const Case c = GENERATE(Case{"plume", plume, 0.02}, Case{"thin plume", plume, 1e-3}, Case{"rough", rough, 0.05},
                          Case{"nearly even", nearly_even, 0.05});
  const double tolerance = GENERATE(1e-3, 3e-2, 0.5);
  const double width = GENERATE(8.0, 40.0);
  INFO(c.name << ", tolerance " << tolerance << ", spot " << width);
  HotWish wish;
  wish.field = c.field;
  wish.extinction = c.extinction;
  const FootprintCounts counts = require_bounds(hot_world({wish}), {width, 0}, tolerance, 400);
  CHECK(counts.rays == 400);
  CHECK(counts.error_bound > 0);
  CHECK(counts.coarse > 0);
  CHECK(counts.coarse <= counts.segments);
}

TEST_CASE("coarse cells of overlapping, distant and periodic clouds share one bound", "[footprint]") {
  HotWish a, b;
  b.field = rough;
  b.extinction = 5e-3;
  b.corner_m = {20, -10, 15};
  b.voxel_m = 0.7;
  CHECK(require_bounds(hot_world({a, b}), {30, 0}, 0.02, 500).coarse > 0);
  HotWish cell;
  cell.extinction = 2e-3;
  cell.period_m = {kSide, kSide};
  CHECK(require_bounds(hot_world({cell}), {10, 0.01}, 0.02, 300).coarse > 0);
}

TEST_CASE("the bound counts with the light that is left in front of a cell", "[footprint]") {
  // An even brick of depth 2, then one of empty and full columns: the ray looks through an empty one.
  HotWish wish;
  wish.field = [](const Vec3i& v) {
    const double density = v.z < 8 ? 0.25 : v.z < 16 && v.x % 2 == 1 ? 0.05 : 0.0;
    return std::pair(density, density > 0 ? 600.0 : 0.0);
  };
  wish.extinction = 1;
  const World world = hot_world({wish});
  const Ray ray{{32.5, 32.5, -10}, {0, 0, 1}};
  CoarseCells cells({8, 0}, 1, 0);  // of the transmission alone
  const Seen coarse = seen(world, ray, &cells);
  const double front = std::exp(-2.0), bound = cells.counts().error_bound;
  CHECK(cells.counts().coarse == 1);
  CHECK(coarse.depth == Approx(2.2));
  const double error = front - std::exp(-coarse.depth);
  CHECK(bound == Approx(0.2 * front));
  CHECK(error > 0.9 * bound);
  CHECK(error <= bound);
}

TEST_CASE("the mean over a spot of dense rays is within the bound, in its place and out of it", "[footprint]") {
  HotWish wish;
  wish.extinction = 5e-3;
  const World world = hot_world({wish});
  double largest = 0;
  for (std::uint64_t spot = 0; spot < 20; ++spot) {
    const Ray middle = random_ray(spot);
    const auto [u, v] = orthonormal_basis(middle.direction);
    double exact = 0, coarse = 0, bound = 0;
    for (int i = 0; i < 256; ++i) {
      Ray ray = middle;
      ray.origin += (i % 16 + 0.5 - 8) * u + (i / 16 + 0.5 - 8) * v;  // 16 m wide
      CoarseCells cells({16, 0}, 1e-2, SpectralWorld(world, 0).largest_source());
      coarse += std::exp(-seen(world, ray, &cells).depth) / 256;
      exact += std::exp(-seen(world, ray, nullptr).depth) / 256;
      bound = std::max(bound, cells.counts().error_bound);
    }
    CHECK(std::abs(coarse - exact) <= bound);
    largest = std::max(largest, std::abs(coarse - exact));
  }
  CHECK(largest > 1e-6);
}

TEST_CASE("over whole cells coarse transmission darkens and never brightens", "[footprint]") {
  HotWish wish;
  wish.field = GENERATE(HotField(plume), HotField(rough));
  wish.extinction = 0.1;
  const World world = hot_world({wish});
  double darkest = 0;
  for (int column = 0; column < 16; ++column) {
    // Rays along z through all voxels of a column of bricks: the means of exact and coarse depths are the same.
    double exact = 0, coarse = 0, half_square = 0;
    for (int i = 0; i < 64; ++i) {
      const Ray ray{{16 + 8.0 * (column % 4) + i % 8 + 0.5, 16 + 8.0 * (column / 4) + i / 8 + 0.5, -5}, {0, 0, 1}};
      CoarseCells cells({15, 0}, 1e6, SpectralWorld(world, 0).largest_source());
      const Seen c = seen(world, ray, &cells), e = seen(world, ray, nullptr);
      REQUIRE(cells.counts().coarse + 8 >= cells.counts().segments);
      coarse += std::exp(-c.depth) / 64;
      exact += std::exp(-e.depth) / 64;
      half_square += 0.5 * cells.depth_doubt() * cells.depth_doubt() / 64 * std::exp(cells.depth_doubt() - c.depth);
    }
    CHECK(coarse <= exact * (1 + 1e-6));
    CHECK(exact - coarse <= half_square + 1e-6);
    darkest = std::max(darkest, exact - coarse);
  }
  CHECK(darkest > 1e-4);
}

TEST_CASE("a smooth plume seen from afar is walked in fewer segments", "[footprint]") {
  HotWish wish;
  wish.extinction = 1e-3;
  const World world = hot_world({wish});
  std::uint64_t segments = 0;
  FootprintCounts counts;
  for (std::uint64_t i = 0; i < 300; ++i) {
    const Ray ray = random_ray(i);
    WorldWalk walk({world, 0}, ray);
    while (walk.next()) ++segments;
    CoarseCells cells({0, 0.05}, 1e-2, SpectralWorld(world, 0).largest_source());  // 15 m wide at 300 m
    seen(world, ray, &cells);
    counts += cells.counts();
  }
  CHECK(counts.segments < 0.6 * static_cast<double>(segments));
  // The estimate of the voxels passed over: what is missing, and what lies empty in coarse cells.
  const double missing = static_cast<double>(segments - (counts.segments - counts.coarse));
  CHECK(counts.voxels > 0.8 * missing);
  CHECK(counts.voxels < 1.5 * missing);
}

TEST_CASE("a spot narrower than coarse cells, or none, changes no bit", "[footprint][radiance]") {
  HotWish wish;
  wish.extinction = 1e-3;
  wish.albedo = 0.3;
  wish.sky = 2;
  const World world = hot_world({wish});
  std::vector<Ray> rays;
  std::vector<std::uint64_t> histories;
  for (std::uint64_t i = 0; i < 200; ++i) {
    rays.push_back(random_ray(i));
    histories.push_back(i);
  }
  const auto render = [&](const World& seen_world, const Footprint& footprint, double tolerance,
                          RadianceCounts& counts) {
    RadianceSettings settings;
    settings.footprint = footprint;
    settings.footprint_tolerance = tolerance;
    std::vector<Incoming> incoming(rays.size());
    counts = incoming_radiance({seen_world, 0}, nullptr, settings, rays, histories, incoming);
    return incoming;
  };
  const auto same = [](const std::vector<Incoming>& a, const std::vector<Incoming>& b) {
    bool result = true;
    for (std::size_t i = 0; i < a.size(); ++i) {
      result = result && a[i].direct == b[i].direct && a[i].transmission == b[i].transmission;
    }
    return result;
  };
  RadianceCounts none, other;
  const std::vector<Incoming> exact = render(world, {}, 1e-2, none);
  CHECK(none.footprint.rays == 0);
  CHECK(same(exact, render(world, {7.9, 0}, 1e-2, other)));
  CHECK(other.footprint.rays == 0);
  CHECK(same(exact, render(world, {0, 0.01}, 1e-2, other)));
  CHECK(same(exact, render(world, {16, 0}, 0, other)));
  CHECK_FALSE(same(exact, render(world, {16, 0}, 1e-2, other)));
  CHECK(other.footprint.rays == rays.size());
  CHECK(other.footprint.coarse > 0);
  CHECK(other.footprint.error_bound <= 1e-2);
}

TEST_CASE("light that scatters into a ray with coarse cells is what the leaves scatter", "[footprint][radiance]") {
  HotWish wish;
  wish.extinction = 5e-3;
  wish.albedo = 0.9;
  wish.sky = 1;
  const World world = hot_world({wish});
  RadianceSettings settings;
  settings.parts.background = settings.parts.emission = false;
  const std::size_t count = 4000;
  const Ray ray{{32, 33, -300}, {0, 0, 1}};
  const std::vector<Ray> rays(count, ray);
  const auto mean = [&](const Footprint& footprint, std::uint64_t first) {
    RadianceSettings own = settings;
    own.parts.emission = true;  // else nothing is followed through the leaves
    own.footprint = footprint;
    own.footprint_tolerance = 0.2;
    std::vector<std::uint64_t> histories(count);
    for (std::size_t i = 0; i < count; ++i) histories[i] = first + i;
    std::vector<Incoming> incoming(count);
    incoming_radiance({world, 0}, nullptr, own, rays, histories, incoming);
    CoarseCells cells(footprint, own.footprint_tolerance, SpectralWorld(world, 0).largest_source());
    const double emission = detail::light_along({world, 0}, ray, footprint.exists() ? &cells : nullptr);
    if (footprint.exists()) CHECK(cells.depth_doubt() > 0.02);
    Moments moments;
    for (const Incoming& in : incoming) moments.add(in.direct - emission);
    return std::pair(moments.mean(), moments.standard_error());
  };
  const auto [exact, exact_error] = mean({}, 0);
  const auto [coarse, coarse_error] = mean({16, 0}, 1000000);
  const double error = std::hypot(exact_error, coarse_error);
  CHECK(error < 0.01 * exact);
  CHECK(std::abs(coarse - exact) < 4 * error);
}
