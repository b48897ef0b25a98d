// Rays with a footprint against rays without, on hot clouds seen from afar: how far coarse cells may go under their
// bound, what they save, what they are off. Every row is printed, won or lost.
//
//   footprint_bench [--size 256] [--spots 60] [--rounds 5] [--depth 1] [--tolerance 1e-3] [--only NAME]
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <functional>

#include "octree/build/build.h"
#include "photon/limits/build_measure.h"
#include "photon/optics/transfer.h"
#include "photon/paths/direct_light.h"
#include "photon/world/world_walk.h"
#include "tests/bench/fields.h"
#include "tests/support/places.h"

using namespace obscura;
using namespace obscura::bench;

namespace {

struct Options {
  int size = 256, spots = 60, rounds = 5;
  double depth = 1, tolerance = 1e-3;
  std::string only;
};

constexpr int kSide = 8;  // rays of a spot are kSide x kSide

// Of this thread: others that work on the machine hardly count.
double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}
double seconds(const std::function<void()>& work) {
  const double start = cpu_seconds();
  work();
  return cpu_seconds() - start;
}

// The grid's density, and a temperature that goes with its square root from 400 to 1200 K.
VoxelStream hot_stream(const openvdb::FloatGrid::Ptr& grid, float largest) {
  VoxelStream density = grid_stream(grid);
  VoxelStream stream = density;
  stream.channels = {"density", "temperature"};
  stream.pour = [density, largest](VoxelSink& sink) {
    const auto kelvin = [largest](float v) { return v > 0 ? 400 + 800 * std::sqrt(v / largest) : 0.0f; };
    VoxelSink both(
        [&](const Vec3i& corner, const float* const* values) {
          float warm[512];
          for (int i = 0; i < 512; ++i) warm[i] = kelvin(values[0][i]);
          const float* channels[] = {values[0], warm};
          sink.brick(corner, channels);
        },
        [&](const Vec3i& corner, int level, std::span<const float> values) {
          const float channels[] = {values[0], kelvin(values[0])};
          sink.tile(corner, level, channels);
        });
    density.pour(both);
  };
  return stream;
}

// Rays across a square spot about a line through a random place of the box, in a random direction.
std::vector<Ray> spot_rays(const Box3d& box, std::uint64_t spot, double width) {
  Stream random(5, spot, 0);
  const Vec3d size = box.max - box.min;
  const double x = random.uniform(), y = random.uniform(), z = random.uniform();
  const double cosine = 2 * random.uniform() - 1, angle = 2 * kPi * random.uniform(),
               sine = std::sqrt(1 - cosine * cosine);
  const Vec3d along(sine * std::cos(angle), sine * std::sin(angle), cosine);
  const Vec3d from = box.min + Vec3d(x * size.x, y * size.y, z * size.z) - 2 * size.length() * along;
  const auto [u, v] = orthonormal_basis(along);
  std::vector<Ray> rays;
  for (int i = 0; i < kSide * kSide; ++i) {
    const double a = (i % kSide + 0.5) / kSide - 0.5, b = (i / kSide + 0.5) / kSide - 0.5;
    rays.push_back({from + width * (a * u + b * v), along});
  }
  return rays;
}

// Depth by the rule that lets cells be taken while half the squared spreads, (max - mean)(mean - min) (weight chord)^2
// each (Bhatia and Davis, Amer. Math. Monthly 107, 2000), add up to less than the tolerance: no bound, for comparison.
struct BySquares {
  double weight, tolerance;
  int coarsest;
  double depth = 0, sum = 0;
  std::uint64_t segments = 0;

  int level(double) const noexcept { return coarsest; }
  bool take(const CellBounds& bounds, double begin, double end) noexcept {
    const Bounds b = bounds(0);
    const double chord = weight * (end - begin);
    const double half = 0.5 * static_cast<double>(b.max - b.mean) * static_cast<double>(b.mean - b.min) * chord * chord;
    if (!(std::exp(-depth) * (sum + half) <= tolerance)) return false;
    sum += half;
    return true;
  }
  void walk(const Octree& tree, const Ray& ray) noexcept {
    Walk segment(tree, ray);
    while (segment.next(*this)) {
      if (segment.empty()) continue;
      depth += weight * static_cast<double>(segment.value(0)) * (segment.end() - segment.begin());
      ++segments;
    }
  }
};

void measure(const std::string& name, const openvdb::FloatGrid::Ptr& grid, const Options& options) {
  if (!grid) {
    fmt::print("{}: SKIPPED, its file is not in ../shared/data\n", name);
    return;
  }
  const Box3d box = [&] {
    const VoxelStream s = grid_stream(grid);
    return Box3d(Vec3d(s.bounds.min), Vec3d(s.bounds.max));
  }();
  float largest = 0;
  for (auto v = grid->cbeginValueOn(); v; ++v) largest = std::max(largest, *v);

  // A cloud whose thickest of some thousand rays has the wanted optical depth.
  WorldContents contents;
  contents.bands.emplace_back("LWIR", 8.0, 12.0, 1, Spectrum::constant(1));
  Cloud cloud;
  cloud.name = name;
  cloud.media.push_back({0, {1}, {0.0}, PhaseFunction::isotropic()});
  cloud.temperature.channel = 1;
  BuildSettings lossless;
  lossless.tolerance = 0;
  const VoxelStream stream = hot_stream(grid, largest);
  {
    const Octree tree = build_octree(stream, lossless).first;
    const double weights[] = {1.0, 0.0};
    double thickest = 0;
    for (std::uint64_t i = 0; i < 4000; ++i)
      thickest = std::max(thickest, optical_depth(tree, spot_rays(box, 1000000 + i, 0).front(), weights));
    cloud.media.front().extinction = {options.depth / thickest};
  }
  BuildSettings settings;
  settings.tolerance = options.tolerance;
  settings.measure = build_measure(cloud, contents.bands, stream);
  cloud.octree = std::make_shared<const Octree>(build_octree(stream, settings).first);
  contents.clouds.push_back(cloud);
  contents.sky = {0.0};
  const World world(std::move(contents));
  const double source = SpectralWorld(world, 0).largest_source();

  for (const double width : {1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0}) {
    std::vector<Ray> rays;
    for (int s = 0; s < options.spots; ++s) {
      const std::vector<Ray> spot = spot_rays(box, static_cast<std::uint64_t>(s), width);
      rays.insert(rays.end(), spot.begin(), spot.end());
    }
    const std::size_t n = rays.size();
    std::vector<double> depths(n), coarse_depths(n), light(n), coarse_light(n);
    FootprintCounts counts;
    std::uint64_t segments = 0;
    for (const Ray& ray : rays) {
      WorldWalk walk({world, 0}, ray);
      while (walk.next()) ++segments;
    }
    // In turns, the fastest of each counts.
    double batch = kInfinity, fine = kInfinity, coarse = kInfinity, coarse_depth = kInfinity;
    for (int round = 0; round < options.rounds; ++round) {
      batch = std::min(batch, seconds([&] { SpectralWorld(world, 0).optical_depths(rays, depths); }));
      fine = std::min(fine, seconds([&] {
                        for (std::size_t i = 0; i < n; ++i) light[i] = detail::light_along({world, 0}, rays[i]);
                      }));
      coarse = std::min(coarse, seconds([&] {
                          counts = {};
                          for (std::size_t i = 0; i < n; ++i) {
                            CoarseCells cells({width, 0}, options.tolerance, source);
                            coarse_light[i] = detail::light_along({world, 0}, rays[i], &cells);
                            coarse_depths[i] = cells.depth();
                            counts += cells.counts();
                          }
                        }));
      coarse_depth = std::min(coarse_depth, seconds([&] {
                                double sum = 0;
                                for (const Ray& ray : rays) {
                                  CoarseCells cells({width, 0}, options.tolerance, 0);
                                  WorldWalk walk({world, 0}, ray, &cells);
                                  while (walk.next()) {
                                    const double depth = walk.optics().extinction * (walk.end() - walk.begin());
                                    cells.passed(depth, std::exp(-cells.depth() - depth));
                                  }
                                  sum += cells.depth();
                                }
                                if (sum < 0) fmt::print("negative\n");
                              }));
    }
    // The spots' means by squared spreads.
    double squares_error = 0;
    std::uint64_t squares_segments = 0;
    for (std::size_t i = 0; i < n;) {
      double error = 0;
      for (int k = 0; k < kSide * kSide; ++k, ++i) {
        BySquares squares{world.clouds()[0].media[0].extinction[0], options.tolerance, std::ilogb(width)};
        squares.walk(*world.clouds()[0].octree, transform_ray(world.frame(0).world_to_index, rays[i]));
        squares_segments += squares.segments;
        error += (std::exp(-squares.depth) - std::exp(-depths[i])) / (kSide * kSide);
      }
      if (std::abs(error) > std::abs(squares_error)) squares_error = error;
    }
    double ray_error = 0, light_error = 0, darkest = 0, brightest = 0;
    for (std::size_t s = 0; s < static_cast<std::size_t>(options.spots); ++s) {
      double error = 0;
      for (std::size_t i = s * kSide * kSide; i < (s + 1) * kSide * kSide; ++i) {
        const double e = std::exp(-coarse_depths[i]) - std::exp(-depths[i]);
        ray_error = std::max(ray_error, std::abs(e));
        light_error = std::max(light_error, std::abs(coarse_light[i] - light[i]) / source);
        error += e / (kSide * kSide);
      }
      darkest = std::min(darkest, error);
      brightest = std::max(brightest, error);
    }
    const double r = static_cast<double>(n);
    fmt::print(
        "| {} | {} | {:.1f} | {:.1f} | {:.2f} | {:.1f} | {:.1e} | {:.1e} | {:.1e} .. {:.1e} | {:.1e} | {:.0f} | {:.0f} "
        "| {:.0f} | {:.0f} | {:.1f} | {:.1e} |\n",
        name, width, segments / r, counts.segments / r, counts.coarse / r, counts.voxels / r, counts.error_bound,
        ray_error, darkest, brightest, light_error, 1e-3 * r / batch, 1e-3 * r / (batch + fine), 1e-3 * r / coarse,
        1e-3 * r / coarse_depth, squares_segments / r, squares_error);
  }
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string key = argv[i];
    if (key == "--size") options.size = std::stoi(argv[i + 1]);
    if (key == "--spots") options.spots = std::stoi(argv[i + 1]);
    if (key == "--rounds") options.rounds = std::stoi(argv[i + 1]);
    if (key == "--depth") options.depth = std::stod(argv[i + 1]);
    if (key == "--tolerance") options.tolerance = std::stod(argv[i + 1]);
    if (key == "--only") options.only = argv[i + 1];
  }
  openvdb::initialize();
  const std::filesystem::path data = test::shared_path("data");
  const std::string n = std::to_string(options.size);
  const auto wanted = [&](const std::string& name) { return options.only.empty() || options.only == name; };
  fmt::print(
      "| field | spot, voxels | segments | with footprint | coarse cells | voxels in them | bound | error of a ray's "
      "transmission | "
      "of a spot's mean | of a ray's radiance / largest source | 1000 rays/s: depth, batch | depth and light, leaves | "
      "both, coarse | depth, coarse | "
      "segments by half squared spreads | error of a spot's mean by them |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  if (wanted("plume")) measure("plume" + n, smooth_plume(options.size), options);
  if (wanted("wdas")) measure("wdas", read_grid(data / "wdas_cloud_sixteenth/wdas_cloud_sixteenth.vdb"), options);
  if (wanted("rico")) measure("rico", read_grid(data / "les_rico_jpl/rico122x106x39.vdb"), options);
  if (wanted("rough")) measure("rough" + n, rough_fractal(options.size), options);
  return 0;
}
