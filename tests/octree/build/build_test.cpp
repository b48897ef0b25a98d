// The builder: errors within the tolerance, by rays of the test's own; mass, zeros, several channels, refusals.
#include "octree/build/build.h"

#include <tbb/global_control.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "octree/base/error.h"
#include "octree/build/compress.h"
#include "octree/tree/walk.h"
#include "tests/support/voxel_fields.h"

using namespace obscura;
using namespace obscura::test;

namespace {

// Billows on three scales with voids between them; extinction in 1/m with voxels of 0.5 m.
Field rough_cloud() {
  return [](int channel, const Vec3i& v) {
    if (channel == 1) return static_cast<float>(600 + 5.0 * v.z);
    double sum = 0;
    for (int level = 0; level <= 4; ++level) {
      sum += std::ldexp(
          voxel_noise(31, Vec3i(v.x >> level, v.y >> level, v.z >> level), static_cast<std::uint32_t>(level)) - 0.5,
          level);
    }
    return static_cast<float>(std::max(0.0, 0.02 * sum));
  };
}

Field smooth_plume() {
  return [](int, const Vec3i& v) {
    const double r2 = std::pow((v.x - 40.3) / 12, 2) + std::pow((v.y - 32.1) / 14, 2) + std::pow((v.z - 35.7) / 16, 2);
    const double k = 0.4 * std::exp(-r2);
    return k < 1e-4 ? 0.0f : static_cast<float>(k);
  };
}

Affine half_metre() {
  Affine map;
  map.setScale(Vec3d(0.5));
  map[3][0] = 100;
  return map;
}

double worst_transmission_error(const Octree& a, const Octree& b, std::span<const double> weights, int rays) {
  double worst = 0;
  for (int i = 0; i < rays; ++i) {
    Ray ray = awkward_ray(a.domain(), 77, static_cast<std::uint64_t>(i));
    ray.direction /= transform_direction(a.index_to_local(), ray.direction).length();
    worst = std::max(worst,
                     std::abs(std::exp(-optical_depth(a, ray, weights)) - std::exp(-optical_depth(b, ray, weights))));
  }
  return worst;
}

}  // namespace

TEST_CASE("the transmission error stays within the tolerance and under the bound", "[octree][build]") {
  const bool smooth = GENERATE(false, true);
  const double tolerance = GENERATE(1e-2, 1e-3, 1e-4);
  const Box3i domain(Vec3i(0), Vec3i(80, 64, 72));
  const VoxelStream stream = field_stream(domain, {"k"}, smooth ? smooth_plume() : rough_cloud(), half_metre());
  BuildSettings settings;
  settings.tolerance = 0;
  const Octree exact = build_octree(stream, settings).first;
  settings.tolerance = tolerance;
  settings.measure.optical_weight = {1.0};
  const auto [tree, report] = build_octree(stream, settings);
  CHECK(report.error_measured <= tolerance);
  CHECK(report.error_measured > 0.2 * tolerance);  // it is spent, not hoarded
  CHECK(report.error_bound >= report.error_measured);
  CHECK(report.rays == 100000);
  const double mine = worst_transmission_error(exact, tree, settings.measure.optical_weight, 20000);
  INFO("smooth " << smooth << ", tolerance " << tolerance << ", measured " << report.error_measured << ", here " << mine
                 << ", bound " << report.error_bound << ", bytes " << tree.statistics().bytes << " of "
                 << exact.statistics().bytes << ", merged " << report.merged_share << ", quantised "
                 << report.quantised_share << ", bits " << tree.statistics().bits_per_value[0]);
  CHECK(mine <= 1.2 * tolerance);  // rays that the builder did not see, awkward ones among them
  CHECK(mine <= report.error_bound);
  CHECK(tree.statistics().bytes < (tolerance > 5e-4 ? 0.35 : 0.6) * static_cast<double>(exact.statistics().bytes));
  // Mass of every brick, and zeros that stay zero.
  double worst_mass = 0;
  std::uint64_t zeros_lost = 0;
  for (int z = 0; z < 72; z += 8) {
    for (int y = 0; y < 64; y += 8) {
      for (int x = 0; x < 80; x += 8) {
        double a = 0, b = 0;
        const bool same_block = tree.bounds(0, {{x, y, z}, 3}).max > 0;
        for (int i = 0; i < 512; ++i) {
          const Vec3d p(x + (i & 7) + 0.5, y + ((i >> 3) & 7) + 0.5, z + (i >> 6) + 0.5);
          a += static_cast<double>(exact.value(0, p));
          b += static_cast<double>(tree.value(0, p));
          zeros_lost += report.merging_error == 0 && exact.value(0, p) == 0 && tree.value(0, p) != 0;
        }
        if (same_block && report.merging_error == 0)
          worst_mass = std::max(worst_mass, std::abs(a - b) / std::max(a, 1e-30));
      }
    }
  }
  CHECK(worst_mass <= 1e-6);
  CHECK(zeros_lost == 0);
  CHECK(static_cast<double>(tree.bounds(0).mean) == Approx(static_cast<double>(exact.bounds(0).mean)).epsilon(1e-6));
}

TEST_CASE("packing keeps mean, zeros, range and half a step", "[octree][build]") {
  Stream random(3, 0, 0);
  for (int trial = 0; trial < 2000; ++trial) {
    const int level = static_cast<int>(random.bits() % 3u);
    std::vector<float> values(std::size_t{512} >> (3 * level));
    const double scale = std::pow(10.0, 12 * random.uniform() - 6),
                 zeros = random.uniform() < 0.5 ? random.uniform() : -1;
    const double base = random.uniform() < 0.5 ? 0.0 : 3.0;
    for (float& v : values)
      v = random.uniform() < zeros ? 0.0f : static_cast<float>(scale * (base + std::pow(random.uniform(), 4)));
    values[5] = static_cast<float>(scale * (base + 1));
    const double step = scale * std::pow(10.0, -4 * random.uniform());
    std::vector<std::byte> bytes(16);
    const detail::ChannelHeader header = detail::pack(values, level, step, bytes, 0);
    bytes.resize(bytes.size() + 8);
    const double top = std::ldexp(1.0, header.bits()) - 1;
    double sum = 0, exact = 0, worst = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const float v = detail::unpack(bytes.data(), header, static_cast<unsigned>(i));
      sum += static_cast<double>(v);
      exact += static_cast<double>(values[i]);
      worst = std::max(worst, std::abs(static_cast<double>(v) - static_cast<double>(values[i])));
      REQUIRE((values[i] != 0 || v == 0));
      REQUIRE(v >= 0);
      REQUIRE(static_cast<double>(v) <=
              static_cast<double>(header.offset) + static_cast<double>(header.scale) * top * (1 + 1e-6));
    }
    INFO("trial " << trial << " bits " << header.bits() << " step " << step);
    REQUIRE(sum == Approx(exact).epsilon(1e-6));
    REQUIRE(worst <= 1.01 * step);
  }
}

TEST_CASE("the result is the same for 1, 2 and 7 threads", "[octree][build]") {
  std::vector<std::vector<float>> leaves;
  std::vector<double> errors;
  for (const std::size_t threads : {1u, 2u, 7u}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    BuildSettings settings;
    settings.measure.optical_weight = {1.0};
    const auto [tree, report] =
        build_octree(field_stream(Box3i(Vec3i(0), Vec3i(64, 48, 40)), {"k"}, rough_cloud(), half_metre()), settings);
    leaves.emplace_back();
    tree.for_each_leaf([&](const Cell& cell, std::span<const float> values) {
      leaves.back().insert(leaves.back().end(),
                           {static_cast<float>(cell.corner.x), static_cast<float>(cell.corner.y),
                            static_cast<float>(cell.corner.z), static_cast<float>(cell.level), values[0]});
    });
    errors.push_back(report.error_measured);
  }
  CHECK(leaves[0] == leaves[1]);
  CHECK(leaves[0] == leaves[2]);
  CHECK(errors[0] == errors[1]);
  CHECK(errors[0] == errors[2]);
}

TEST_CASE("temperature merges weighted by density and keeps the emitted radiance", "[octree][build]") {
  const Box3i domain(Vec3i(0), Vec3i(64));
  // A hot core: thin smooth smoke, temperature falls off steeply; warm air without smoke around it.
  const Field field = [](int channel, const Vec3i& v) {
    const double r2 = (Vec3d(v) - Vec3d(31.5)).length2() / 400;
    if (channel == 1) return static_cast<float>(300 + 1200 * std::exp(-3 * r2));
    return r2 < 1 ? static_cast<float>(0.05 * (1 - r2)) : 0.0f;
  };
  BuildSettings settings;
  settings.tolerance = 1e-3;
  settings.measure.optical_weight = {1.0, 0.0};
  settings.measure.emission = [](std::span<const float> v) {
    return static_cast<double>(v[0]) * std::pow(static_cast<double>(v[1]) / 1500, 6);  // as steep as Planck at 4 um
  };
  const VoxelStream stream = field_stream(domain, {"k", "T"}, field);
  const auto [tree, report] = build_octree(stream, settings);
  CHECK(report.error_measured <= 1e-3);
  CHECK(report.emission_error_measured <= 1e-3);
  CHECK(report.emission_error_measured > 0);
  // A cell without density has no temperature; where there is smoke it is right.
  std::uint64_t wrong = 0;
  double emitted = 0, expected = 0;
  for (int i = 0; i < 64 * 64 * 64; ++i) {
    const Vec3i v(i & 63, (i >> 6) & 63, i >> 12);
    const Vec3d p = Vec3d(v) + Vec3d(0.5);
    const float k[2] = {tree.value(0, p), tree.value(1, p)}, exact[2] = {field(0, v), field(1, v)};
    if (k[0] == 0) wrong += k[1] != 0;
    if (exact[0] > 1e-2f) wrong += std::abs(k[1] - exact[1]) > 0.02f * exact[1];
    emitted += settings.measure.emission(k);
    expected += settings.measure.emission(exact);
  }
  CHECK(wrong == 0);
  CHECK(emitted == Approx(expected).epsilon(1e-3));
}

TEST_CASE("tiles of any size are poured like the voxels they stand for", "[octree][build]") {
  VoxelStream stream;
  stream.channels = {"k"};
  stream.bounds = Box3i(Vec3i(-128, -64, 3), Vec3i(130, 64, 200));
  stream.pour = [](VoxelSink& sink) {
    const float a[] = {0.5f}, b[] = {0.25f}, zero[] = {0.0f};
    sink.tile(Vec3i(-128, -64, 128), 6, a);
    sink.tile(Vec3i(-64, -64, 128), 6, a);
    sink.tile(Vec3i(64, 0, 64), 5, b);
    sink.tile(Vec3i(128, 0, 0), 3, b);  // hangs over the bounds in x and z: voxels outside are dropped
    sink.tile(Vec3i(0, 0, 64), 5, zero);
  };
  BuildSettings settings;
  settings.tolerance = 0;
  const Octree tree = build_octree(stream, settings).first;
  double mass = 0;
  tree.for_each_leaf([&](const Cell& cell, std::span<const float> v) {
    mass += static_cast<double>(v[0]) * std::ldexp(1.0, 3 * cell.level);
  });
  CHECK(mass == 2 * 262144 * 0.5 + 32768 * 0.25 + 2 * 8 * 5 * 0.25);
  CHECK(tree.value(0, Vec3d(-1, -1, 191)) == 0.5f);
  CHECK(tree.value(0, Vec3d(129.5, 0, 3)) == 0.25f);
  CHECK(tree.value(0, Vec3d(130.5, 0, 3)) == 0);
}

TEST_CASE("what cannot be built is refused by name", "[octree][build][not_finite]") {
  const Field field = rough_cloud();
  BuildSettings settings;
  settings.tolerance = 0;
  // Two clouds a million voxels apart would need a table of terabytes.
  CHECK_THROWS_AS(build_octree(field_stream(Box3i(Vec3i(0), Vec3i(1000000, 1000000, 1000000)), {"k"}, field), settings),
                  ResourceError);
  // A source that pours outside its own bounds.
  VoxelStream liar = field_stream(Box3i(Vec3i(0), Vec3i(16)), {"k"}, [](int, const Vec3i&) { return 1.0f; });
  liar.bounds = Box3i(Vec3i(0), Vec3i(12));
  CHECK_THROWS_AS(build_octree(liar, settings), InputError);
  // No transform, no measure, a tolerance that is none.
  Affine flat;
  flat.setScale(Vec3d(1, 0, 1));
  CHECK_THROWS_AS(build_octree(field_stream(Box3i(Vec3i(0), Vec3i(16)), {"k"}, field, flat), settings), InputError);
  CHECK_THROWS_AS(build_octree(field_stream(Box3i(Vec3i(0), Vec3i(16)), {}, field), settings), InputError);
  settings.tolerance = 1e-3;
  CHECK_THROWS_AS(build_octree(field_stream(Box3i(Vec3i(0), Vec3i(16)), {"k"}, field), settings), InputError);
  settings.measure.optical_weight = {-1};
  CHECK_THROWS_AS(build_octree(field_stream(Box3i(Vec3i(0), Vec3i(16)), {"k"}, field), settings), InputError);
  settings.tolerance = std::nan("");
  CHECK_THROWS_AS(build_octree(field_stream(Box3i(Vec3i(0), Vec3i(16)), {"k"}, field), settings), InputError);
  // A user who gives up.
  settings.measure.optical_weight = {1};
  settings.tolerance = 1e-3;
  const std::atomic<bool> stop = true;
  CHECK_THROWS_AS(build_octree(field_stream(Box3i(Vec3i(0), Vec3i(16)), {"k"}, field), settings, Progress({}, &stop)),
                  ResourceError);
}
