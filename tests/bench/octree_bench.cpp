// The octree against what a user would take instead, on the same data, in one run: rays a second, bytes,
// peak memory and build time as one table of ratios. Every row is printed, won or lost.
//
//   octree_bench [--size 256] [--rays 20000] [--rounds 7] [--only NAME]
#define NANOVDB_USE_TBB
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <malloc.h>
#include <nanovdb/util/OpenToNanoVDB.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <optional>

#include "octree/build/build.h"
#include "octree/tree/batch_walk.h"
#include "octree/tree/walk.h"
#include "tests/bench/baselines.h"
#include "tests/bench/fields.h"
#include "tests/support/places.h"

using namespace obscura;
using namespace obscura::bench;

namespace {

struct Options {
  int size = 256;
  int rays = 20000;
  int rounds = 7;
  std::string only;
};

using Clock = std::chrono::steady_clock;
double seconds(const std::function<void()>& work) {
  const Clock::time_point start = Clock::now();
  work();
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Medians of several works, taken in turns so that a busy machine hits all of them alike.
std::vector<double> medians(int rounds, const std::vector<std::function<void()>>& works) {
  std::vector<std::vector<double>> times(works.size());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t w = 0; w < works.size(); ++w) times[w].push_back(seconds(works[w]));
  }
  std::vector<double> result;
  for (auto& t : times) {
    std::sort(t.begin(), t.end());
    result.push_back(t[t.size() / 2]);
  }
  return result;
}

double status_mib(const char* name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind(name, 0) == 0) return std::stod(line.substr(std::strlen(name) + 1)) / 1024;
  }
  return 0;
}

// Memory that a piece of work needs at its peak beyond what was there before.
double peak_mib(const std::function<void()>& work) {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5";
  const double before = status_mib("VmRSS");
  work();
  return status_mib("VmHWM") - before;
}

// Lines through two random points of the box.
std::vector<Ray> chords(const Box3i& box, int count) {
  std::vector<Ray> rays(static_cast<std::size_t>(count));
  const Vec3d low(box.min), size = Vec3d(box.max) - Vec3d(box.min);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Stream random(99, i, 0);
    const auto point = [&] {
      const double x = random.uniform(), y = random.uniform(), z = random.uniform();
      return low + Vec3d(x * size.x, y * size.y, z * size.z);
    };
    const Vec3d a = point(), b = point();
    const Vec3d d = (b - a).normalized();
    rays[i] = Ray{a - 2 * size.length() * d, d};
  }
  return rays;
}

struct Row {
  std::string name, what;
  double ratio, goal;
  bool more_is_better;
};
std::vector<Row> rows;
void row(const std::string& field, const std::string& what, double ratio, double goal, bool more_is_better) {
  rows.push_back({field, what, ratio, goal, more_is_better});
}

void measure(const std::string& name, const openvdb::FloatGrid::Ptr& grid, const Options& options, bool rough) {
  if (!grid) {
    fmt::print("{}: SKIPPED, its file is not in ../shared/data\n", name);
    return;
  }
  if (!options.only.empty() && options.only != name) return;
  const VoxelStream stream = grid_stream(grid);

  // NanoVDB's trees, the dense array and the octrees of the same voxels.
  nanovdb::GridHandle<> nano = nanovdb::openToNanoVDB(*grid);
  const nanovdb::NanoGrid<float>& nano_grid = *nano.grid<float>();
  const nanovdb::GridHandle<> nano8 =
      nanovdb::openToNanoVDB<nanovdb::HostBuffer, openvdb::FloatTree, nanovdb::Fp8>(*grid);
  BuildSettings settings;
  settings.tolerance = 0;
  const Octree lossless = build_octree(stream, settings).first;
  DenseWalk dense(stream.bounds.min, stream.bounds.max - stream.bounds.min);
  for (std::uint32_t b = 0; b < lossless.block_count(); ++b) {
    const Block block = lossless.block(b);
    const int side = 1 << block.cell.level;
    for (int z = 0; z < side; ++z) {
      for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
          const Vec3i v = block.cell.corner + Vec3i(x, y, z);
          if (lossless.data().holds(v)) dense.value(v) = lossless.value(0, Vec3d(v));
        }
      }
    }
  }

  // Scaled so that the thickest chord has optical depth 5.
  const std::vector<Ray> rays = chords(stream.bounds, options.rays);
  const double one[] = {1.0};
  std::vector<double> exact(rays.size()), depths(rays.size());
  double thickest = 0, length = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    exact[i] = dense.depth(rays[i]);
    thickest = std::max(thickest, exact[i]);
    const auto [enter, leave] = clip(rays[i], Box3d(Vec3d(stream.bounds.min), Vec3d(stream.bounds.max)));
    length += std::max(0.0, leave - enter);
  }
  const double weights[] = {5 / thickest};
  for (double& e : exact) e *= weights[0];
  settings.tolerance = 1e-3;
  settings.measure.optical_weight = {weights[0]};
  const auto [small, report] = build_octree(stream, settings);

  // Errors against the dense walk.
  const NanoWalk nano_walk(nano_grid);
  double nano_error = 0, scalar_error = 0, batch_error = 0, small_error = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    nano_error = std::max(nano_error, std::abs(weights[0] * nano_walk.depth(rays[i]) - exact[i]));
    scalar_error = std::max(scalar_error, std::abs(optical_depth(lossless, rays[i], weights) - exact[i]));
  }
  optical_depths(lossless, rays, weights, depths);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    batch_error = std::max(batch_error, std::abs(depths[i] - exact[i]) / std::max(1e-5 * exact[i], 1e-6));
  }
  optical_depths(small, rays, weights, depths);
  for (std::size_t i = 0; i < rays.size(); ++i)
    small_error = std::max(small_error, std::abs(std::exp(-depths[i]) - std::exp(-exact[i])));

  const auto each = [&](auto&& f) {
    return [&rays, f] {
      double sum = 0;
      for (const Ray& ray : rays) sum += f(ray);
      benchmark::DoNotOptimize(sum);
    };
  };
  const std::vector<double> t =
      medians(options.rounds, {each([&](const Ray& r) { return nano_walk.depth(r); }),
                               each([&](const Ray& r) { return dense.depth(r); }),
                               each([&](const Ray& r) { return optical_depth(lossless, r, one); }),
                               [&] { optical_depths(lossless, rays, weights, depths); },
                               each([&](const Ray& r) { return optical_depth(small, r, one); }),
                               [&] { optical_depths(small, rays, weights, depths); }});

  const OctreeStatistics a = lossless.statistics(), b = small.statistics();
  const double nano_bytes = static_cast<double>(nano.size()), fp8_bytes = static_cast<double>(nano8.size());
  const double dense_bytes = static_cast<double>(dense.bytes());
  const Vec3i extent = stream.bounds.max - stream.bounds.min;
  const double active = static_cast<double>(grid->activeVoxelCount()) / (dense_bytes / 4);
  fmt::print("\n{}: {} x {} x {}, {:.1f} % active, {} bricks and {} uniform leaves ({} and {} at 1e-3)\n", name,
             extent.x, extent.y, extent.z, 100 * active, a.bricks, a.uniform_blocks, b.bricks, b.uniform_blocks);
  fmt::print(
      "  rays/s: NanoVDB {:.0f}  dense {:.0f}  scalar {:.0f}  batch {:.0f}  1e-3: scalar {:.0f}  batch {:.0f}   ({} a "
      "voxel on NanoVDB, {})\n",
      rays.size() / t[0], rays.size() / t[1], rays.size() / t[2], rays.size() / t[3], rays.size() / t[4],
      rays.size() / t[5], fmt::format("{:.1f} ns", 1e9 * t[0] / length), batch_target());
  fmt::print(
      "  MiB: dense {:.2f}  NanoVDB {:.2f}  Fp8 {:.2f}  octree {:.2f}  at 1e-3 {:.2f} ({:.2f} bits a value, leaves",
      dense_bytes / 1048576, nano_bytes / 1048576, fp8_bytes / 1048576, a.bytes / 1048576.0, b.bytes / 1048576.0,
      b.bits_per_value[0]);
  for (const std::uint64_t n : b.leaves) fmt::print(" {}", n);
  fmt::print(
      ")\n  errors: depth NanoVDB {:.1e}, scalar {:.1e}, batch {:.2f} of 1e-5 relative or 1e-6; transmission at 1e-3 "
      "{:.2e} (builder {:.2e}, bound {:.2e}, merging {:.2f}, quantising {:.2f})\n",
      nano_error, scalar_error, batch_error, small_error, report.error_measured, report.error_bound,
      report.merged_share, report.quantised_share);

  // Build: the conversion from VDB alone.
  const int build_rounds = std::max(1, options.rounds / 2);
  BuildSettings none;
  none.tolerance = 0;
  const std::vector<double> build = medians(
      build_rounds, {[&] { nanovdb::openToNanoVDB(*grid); },
                     [&] { nanovdb::openToNanoVDB<nanovdb::HostBuffer, openvdb::FloatTree, nanovdb::Fp8>(*grid); },
                     [&] { build_octree(stream, none); }, [&] { build_octree(stream, settings); }});
  const double nano_peak = peak_mib([&] { nanovdb::openToNanoVDB(*grid); });
  const double our_peak = peak_mib([&] { build_octree(stream, none); });
  const double small_peak = peak_mib([&] { build_octree(stream, settings); });
  fmt::print(
      "  build ms: NanoVDB {:.1f}  Fp8 {:.1f}  octree {:.1f}  at 1e-3 {:.1f};  peak MiB beyond the VDB: NanoVDB {:.1f} "
      " octree {:.1f}  at 1e-3 {:.1f};  process peak {:.0f} MiB\n",
      1e3 * build[0], 1e3 * build[1], 1e3 * build[2], 1e3 * build[3], nano_peak, our_peak, small_peak,
      status_mib("VmHWM"));

  row(name, "scalar walk, lossless / NanoVDB, rays a second", t[0] / t[2], 1.5, true);
  row(name, "batched walk, lossless / NanoVDB", t[0] / t[3], 5, true);
  row(name, "batched walk at 1e-3 / NanoVDB", t[0] / t[5], 5, true);
  row(name, "scalar walk / dense DDA", t[1] / t[2], 0, true);
  row(name, "batched walk / dense DDA", t[1] / t[3], 0, true);
  row(name, "scalar depth error / 1e-10", scalar_error / 1e-10, 1, false);
  row(name, "batched depth error / (1e-5 relative or 1e-6)", batch_error, 1, false);
  row(name, "transmission error at 1e-3 / 1e-3", small_error / 1e-3, 1, false);
  row(name, "bytes at 1e-3 / NanoVDB float", b.bytes / nano_bytes, rough ? 0.27 : 0, false);
  row(name, "bytes at 1e-3 / NanoVDB Fp8", b.bytes / fp8_bytes, rough ? 0.85 : 0, false);
  row(name, "bytes at 1e-3 / dense", b.bytes / dense_bytes, active < 0.15 ? 0.1 : 0, false);
  row(name, "bytes lossless / NanoVDB float", a.bytes / nano_bytes, 0, false);
  row(name, "build time, lossless / NanoVDB", build[2] / build[0], 1, false);
  row(name, "build time at 1e-3 / NanoVDB Fp8", build[3] / build[1], 0, false);
  row(name, "peak memory beyond the VDB, lossless / NanoVDB", our_peak / nano_peak, 0, false);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string key = argv[i];
    if (key == "--size") options.size = std::stoi(argv[i + 1]);
    if (key == "--rays") options.rays = std::stoi(argv[i + 1]);
    if (key == "--rounds") options.rounds = std::stoi(argv[i + 1]);
    if (key == "--only") options.only = argv[i + 1];
  }
  openvdb::initialize();
  const std::filesystem::path data = test::shared_path("data");
  const std::string n = std::to_string(options.size);
  const auto wanted = [&](const std::string& name) { return options.only.empty() || options.only == name; };
  if (wanted("wdas")) measure("wdas", read_grid(data / "wdas_cloud_sixteenth/wdas_cloud_sixteenth.vdb"), options, true);
  if (wanted("rico")) measure("rico", read_grid(data / "les_rico_jpl/rico122x106x39.vdb"), options, true);
  if (wanted("rough" + n)) measure("rough" + n, rough_fractal(options.size), options, true);
  if (wanted("plume" + n)) measure("plume" + n, smooth_plume(options.size), options, false);
  fmt::print("\n{:<10} {:<50} {:>9} {:>8}\n", "field", "ratio", "measured", "goal");
  for (const Row& r : rows) {
    const char* verdict = r.goal == 0                                                  ? ""
                          : (r.more_is_better ? r.ratio >= r.goal : r.ratio <= r.goal) ? "met"
                                                                                       : "MISSED";
    fmt::print("{:<10} {:<50} {:>9.3g} {:>8} {}\n", r.name, r.what, r.ratio,
               r.goal == 0 ? "" : fmt::format("{:.3g}", r.goal), verdict);
  }
  return 0;
}
