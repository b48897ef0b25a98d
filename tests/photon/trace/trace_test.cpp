// Tracing: what is stored of each class of light, where power goes, and numbers known on paper.
#include "photon/trace/trace.h"

#include <catch2/catch.hpp>
#include <set>

#include "tests/support/agree.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

/// A slab of 1 m, wide enough to be infinite for a beam along z through its middle.
CloudWish slab(double extinction, double albedo) {
  CloudWish wish;
  wish.voxels = {64, 64, 1};
  wish.extinction = extinction;
  wish.albedo = albedo;
  return wish;
}

World beam_world(const CloudWish& wish, double power = 5) {
  WorldContents contents = grey_contents(wish);
  const Vec3d middle = 0.5 * wish.voxel_m * Vec3d(wish.voxels);
  contents.beams.push_back({{middle.x, middle.y, -1}, {0, 0, 1}, 0.1, {power}});
  return World(std::move(contents));
}

BatchMean of(BatchTally tally) {
  for (double& value : tally) value *= kBatches;
  return batch_mean(tally);
}

/// Stored power by the number of collisions before, in batches.
struct Stored {
  std::array<BatchTally, 8> power{};
  BatchTally all{};
  std::size_t first = 0;  // photons at their history's first collision
};
Stored stored(const TraceResult& result) {
  Stored s;
  for (const Photon& photon : result.photons) {
    s.all[photon.batch] += static_cast<double>(photon.power);
    s.first += photon.collisions == 0;
    if (photon.collisions < s.power.size())
      s.power[photon.collisions][photon.batch] += static_cast<double>(photon.power);
  }
  return s;
}

/// View factor between unit spheres whose centres are `distance` apart: the emitted light that a ring of
/// the first at the angle `a` from the axis sends to the second, by quadrature over the second's disc of
/// directions.
double view_factor(double distance) {
  double sum = 0;
  constexpr int kSteps = 120;
  for (int i = 0; i < kSteps; ++i) {
    const double z = -1 + 2 * (i + 0.5) / kSteps;
    const Vec3d normal(std::sqrt(1 - z * z), 0, z);
    const Vec3d toward = Vec3d(0, 0, distance) - normal;
    const double sine2 = 1 / toward.length2();
    const auto [a, b] = orthonormal_basis(toward.normalized());
    // Over the cone to the second sphere, in equal shares of sin^2: d(omega) = pi sine2 / cos.
    double irradiance = 0;
    for (int j = 0; j < kSteps; ++j) {
      for (int k = 0; k < kSteps; ++k) {
        const double s2 = sine2 * (j + 0.5) / kSteps, phi = 2 * kPi * (k + 0.5) / kSteps;
        const double cosine = std::sqrt(1 - s2);
        const Vec3d d = cosine * toward.normalized() + std::sqrt(s2) * (std::cos(phi) * a + std::sin(phi) * b);
        irradiance += std::max(0.0, d.dot(normal)) * kPi * sine2 / cosine / (kSteps * kSteps);
      }
    }
    sum += irradiance / kPi / kSteps;
  }
  return sum;
}

}  // namespace

TEST_CASE("light of the direct set is stored from the second collision, all other light from the first",
          "[photon][trace]") {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.voxel_m = 0.5;
  wish.albedo = 0.8;
  wish.source = 2;
  WorldContents contents = grey_contents(wish, 0.7);
  contents.sun = Sun{{0, 0, 1}, {5}, 0.01};
  contents.sources.push_back({{2, 2, 6}, 0.5, {30}});
  contents.particles.push_back({{2, -3, 2}, 0.5, {30}});
  contents.beams.push_back({{2, 2, -2}, {0, 0, 1}, 0.2, {4}});
  const World world(std::move(contents));
  const auto trace = [&](bool SourceSelection::*source) {
    TraceSettings settings;
    settings.photons = 20000;
    settings.sources = {false, false, false, false, false, false, false};
    settings.sources.*source = true;
    return trace_photons({world, 0}, settings);
  };
  for (bool SourceSelection::*source :
       {&SourceSelection::emission, &SourceSelection::particles, &SourceSelection::beams}) {
    const TraceResult result = trace(source);
    CHECK(stored(result).first > 500);
    CHECK(result.photons.size() > stored(result).first);
  }
  for (bool SourceSelection::*source : {&SourceSelection::sun, &SourceSelection::sky, &SourceSelection::spheres}) {
    const TraceResult result = trace(source);
    CHECK(stored(result).first == 0);
    CHECK(result.photons.size() > 500);
    CHECK(std::any_of(result.photons.begin(), result.photons.end(), [](const Photon& p) { return p.collisions == 1; }));
  }
}

TEST_CASE("a beam through an absorbing slab collides, is absorbed and escapes as the exponential says",
          "[photon][trace]") {
  const World world = beam_world(slab(1, 0));
  TraceSettings settings;
  settings.photons = 400000;
  const FluxRectangle behind{{32, 32, 2}, {1, 0, 0}, {0, 1, 0}};
  const FluxRectangle before{{32, 32, -0.5}, {1, 0, 0}, {0, 1, 0}};
  const FluxRectangle within{{32, 32, 0.5}, {1, 0, 0}, {0, 1, 0}};
  const FluxRectangle rectangles[] = {behind, before, within};
  const TraceResult result = trace_photons({world, 0}, settings, rectangles);
  CHECK(result.emitted == 400000);
  CHECK(result.anomalies == 0);
  const AgreeOptions options{.resolution = 0.04, .comparisons = 4, .degrees_of_freedom = 15};
  const auto check = [&](const BatchTally& tally, double expected) {
    const BatchMean mean = of(tally);
    CHECK(agree(mean.mean, mean.standard_error, expected, options));
  };
  check(result.energy.absorbed, 5 * (1 - std::exp(-1.0)));
  check(result.energy.escaped, 5 * std::exp(-1.0));
  check(result.flux[0].forward, 5 * std::exp(-1.0));
  check(result.flux[2].forward, 5 * std::exp(-0.5));
  CHECK(of(result.flux[1].forward).mean == Approx(5));
  CHECK(of(result.flux[0].backward).mean == 0);
  // Every absorption is a collision that was stored, with its power; all are equal.
  CHECK(of(stored(result).all).mean == Approx(of(result.energy.absorbed).mean).epsilon(1e-5));
  for (const Photon& photon : result.photons) {
    REQUIRE(photon.power == result.photons.front().power);
    REQUIRE(photon.collisions == 0);
    REQUIRE((decode_direction(photon.direction) - Vec3d(0, 0, 1)).length() < 1e-4);
  }
  // A slab of another extinction gives other numbers.
  const BatchMean wrong = of(trace_photons({beam_world(slab(1.1, 0)), 0}, settings).energy.absorbed);
  CHECK(!agree(wrong.mean, wrong.standard_error, 5 * (1 - std::exp(-1.0)), options));
}

TEST_CASE("in a thick medium the power of the n-th collision is the albedo's n-th power", "[photon][trace]") {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.extinction = 20;  // 160 mean free paths
  wish.albedo = 0.6;
  WorldContents contents = grey_contents(wish);
  contents.beams.push_back({{4, 4, 4}, {0, 0, 1}, 0.01, {5}});  // starts in the middle
  const World world(std::move(contents));
  TraceSettings settings;
  settings.photons = 200000;
  const TraceResult result = trace_photons({world, 0}, settings);
  const Stored s = stored(result);
  for (std::size_t n = 0; n < 4; ++n) {
    const BatchMean mean = of(s.power[n]);
    const double expected = 5 * std::pow(0.6, n);
    if (n == 0) {
      CHECK(mean.mean == Approx(expected).epsilon(1e-5));
    } else {
      CHECK(agree(mean.mean, mean.standard_error, expected,
                  {.resolution = 0.06, .comparisons = 4, .degrees_of_freedom = 15}));
    }
  }
  // All collisions: 1 / (1 - albedo); photons survive with their power, or not at all.
  const BatchMean all = of(s.all);
  CHECK(agree(all.mean, all.standard_error, 5 / (1 - 0.6), {.resolution = 0.05, .degrees_of_freedom = 15}));
  for (const Photon& photon : result.photons) REQUIRE(photon.power == result.photons.front().power);
  CHECK(of(result.energy.absorbed).mean == Approx(5).epsilon(1e-9));
  CHECK(of(result.energy.escaped).mean == 0);
}

TEST_CASE("a limit to the scatterings cuts histories off and says how much power that was", "[photon][trace]") {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.extinction = 20;
  wish.albedo = 0.6;
  WorldContents contents = grey_contents(wish);
  contents.beams.push_back({{4, 4, 4}, {0, 0, 1}, 0.01, {5}});
  const World world(std::move(contents));
  for (const int depth : {0, 1, 3}) {
    TraceSettings settings;
    settings.photons = 100000;
    settings.scattering_depth = depth;
    const TraceResult result = trace_photons({world, 0}, settings);
    int deepest = -1;
    for (const Photon& photon : result.photons) deepest = std::max<int>(deepest, photon.collisions);
    CHECK(deepest == depth - 1);  // light that has scattered `depth` times does not scatter once more into a ray
    const BatchMean cut = of(result.energy.truncated);
    CHECK(agree(cut.mean, cut.standard_error, 5 * std::pow(0.6, depth + 1),
                {.resolution = 0.15, .comparisons = 3, .degrees_of_freedom = 15}));
  }
}

TEST_CASE("photons below the threshold are not stored, and their power is told", "[photon][trace]") {
  const World world = beam_world(slab(1, 0.5));
  TraceSettings settings;
  settings.photons = 1000;
  const TraceResult kept = trace_photons({world, 0}, settings);
  const double power = static_cast<double>(kept.photons.front().power);  // 5 / 1000, but for rounding
  CHECK(kept.dropped_W == 0);
  settings.photon_power_min = 1.02 * power;
  const TraceResult dropped = trace_photons({world, 0}, settings);
  double all = 0;
  for (const Photon& photon : kept.photons) all += static_cast<double>(photon.power);
  CHECK(dropped.photons.empty());
  CHECK(dropped.dropped_W == Approx(all).epsilon(1e-5));
  CHECK(dropped.energy.absorbed == kept.energy.absorbed);
  settings.photon_power_min = 0.98 * power;
  CHECK(trace_photons({world, 0}, settings).photons.size() == kept.photons.size());
}

TEST_CASE("no photon, one photon and fewer photons than batches carry the right power", "[photon][trace]") {
  const World world = beam_world(slab(1000, 0));
  for (const std::uint64_t count : {0u, 1u, 5u, 16u, 37u}) {
    TraceSettings settings;
    settings.photons = count;
    const TraceResult result = trace_photons({world, 0}, settings);
    CHECK(result.emitted == count);
    CHECK(result.photons.size() == count);
    CHECK(of(result.energy.emitted).mean == Approx(count ? 5 : 0));
    std::array<int, kBatches> batches{};
    for (const Photon& photon : result.photons) ++batches[photon.batch];
    const auto [least, most] = std::minmax_element(batches.begin(), batches.end());
    CHECK(*most - *least <= 1);
    // Batches of unequal numbers carry equal power.
    if (count >= kBatches) {
      for (const double emitted : result.energy.emitted) CHECK(emitted == Approx(5.0 / kBatches));
    }
  }
}

TEST_CASE("a World without power, and one without clouds, trace to nothing and to escape", "[photon][trace]") {
  CHECK(trace_photons({World(grey_contents({})), 0}, {}).emitted == 0);
  WorldContents contents;
  contents.bands.emplace_back("grey");
  contents.sources.push_back({{0, 0, 0}, 1, {1}});
  contents.particles.push_back({{0, 0, 3}, 1, {1}});
  TraceSettings settings;
  settings.photons = 200000;
  const TraceResult result = trace_photons({World(std::move(contents)), 0}, settings);
  CHECK(result.photons.empty());
  // What one of two equal spheres, three radii apart, receives of the other's light.
  const double share = of(result.energy.surface).mean / of(result.energy.emitted).mean;
  CHECK(share == Approx(view_factor(3)).epsilon(0.05));
  CHECK(of(result.energy.escaped).mean + of(result.energy.surface).mean == Approx(of(result.energy.emitted).mean));
}

TEST_CASE("stratified emission is quieter than random, regular is the same for every seed", "[photon][trace]") {
  // Through a rectangle on one side: depends on place and direction of emission.
  const FluxRectangle side{{-1, 4, 4}, {0, 8, 0}, {0, 0, 8}};
  const auto trace = [&](double extinction, Directions directions, std::uint64_t seed) {
    CloudWish wish;
    wish.voxels = Vec3i(8);
    wish.density = [](const Vec3i& v) { return v.x < 4 ? 0.2 : 1.0; };
    wish.extinction = extinction;
    wish.source = 1;
    TraceSettings settings;
    settings.photons = 32768;
    settings.directions = directions;
    settings.seed = seed;
    return trace_photons({World(grey_contents(wish)), 0}, settings, {&side, 1});
  };
  // So thin that emission alone decides.
  const auto flux = [&](Directions directions) {
    const TraceResult result = trace(1e-6, directions, 1);
    const BatchMean mean = of(result.flux[0].backward);
    return BatchMean{mean.mean / of(result.energy.emitted).mean, mean.standard_error / of(result.energy.emitted).mean};
  };
  const BatchMean random = flux(Directions::random);
  const BatchMean stratified = flux(Directions::stratified);
  CHECK(stratified.mean == Approx(random.mean).epsilon(0.05));
  CHECK(flux(Directions::regular).mean == Approx(random.mean).epsilon(0.05));
  CHECK(random.standard_error < 0.02 * random.mean);
  CHECK(stratified.standard_error < 0.7 * random.standard_error);
  // Of photons that collide at all, the directions are the same where emission is regular.
  const auto directions = [](const TraceResult& result) {
    std::set<std::uint32_t> set;
    for (const Photon& photon : result.photons) {
      if (photon.collisions == 0) set.insert(photon.direction);
    }
    return set;
  };
  const auto common = [&](Directions kind) {
    const auto a = directions(trace(10, kind, 1)), b = directions(trace(10, kind, 2));
    std::size_t both = 0;
    for (const std::uint32_t d : a) both += b.count(d);
    return static_cast<double>(both) / static_cast<double>(a.size());
  };
  CHECK(common(Directions::regular) > 0.8);
  CHECK(common(Directions::stratified) < 0.1);
  CHECK(common(Directions::random) < 0.1);
}

TEST_CASE("photons of a periodic World stay in the first cell of the map's frame", "[photon][trace]") {
  CloudWish wish;
  wish.voxels = {8, 8, 4};
  wish.extinction = 0.2;
  wish.albedo = 0.9;
  wish.period_m = {8, 10};
  WorldContents contents = grey_contents(wish, 1);
  contents.clouds[0].local_to_world = placement({30, -20, 5}, {0, 0, 0.7}, 2);
  const World world(std::move(contents));
  TraceSettings settings;
  settings.photons = 20000;
  const TraceResult result = trace_photons({world, 0}, settings);
  CHECK(result.photons.size() > 5000);
  for (const Photon& photon : result.photons) {
    const Vec3f& p = photon.position;
    INFO(p.x << " " << p.y << " " << p.z);
    REQUIRE((p.x >= -1e-4 && p.x <= 16 + 1e-4 && p.y >= -1e-4 && p.y <= 20 + 1e-4 && p.z >= -1e-4 && p.z <= 8 + 1e-4));
    REQUIRE(SpectralWorld(world, 0).extinction_in_map(
                Vec3d(p.x, p.y, std::clamp(static_cast<double>(p.z), 1e-3, 8 - 1e-3))) >= 0);
  }
}

TEST_CASE("a cancelled trace is partial", "[photon][trace]") {
  std::atomic<bool> cancelled{true};
  TraceSettings settings;
  settings.photons = 100000;
  const TraceResult result = trace_photons({beam_world(slab(1, 0.5)), 0}, settings, {}, Progress({}, &cancelled));
  CHECK(result.partial);
  CHECK(result.emitted < 100000);
  std::atomic<std::uint64_t> last{0};
  std::atomic<bool> right_total{true};
  const Progress listen(
      [&](std::string_view, std::uint64_t done, std::uint64_t total) {
        for (std::uint64_t known = last; known < done && !last.compare_exchange_weak(known, done);) {
        }
        if (total != 100000) right_total = false;
      },
      nullptr);
  CHECK(!trace_photons({beam_world(slab(1, 0.5)), 0}, settings, {}, listen).partial);
  CHECK(last == 100000);
  CHECK(right_total);
}
