// What effects that are off cost: instructions of the program on scenes that lack them against minimal loops, written
// by hand, that have never heard of them but use the same walks, ray queries and random numbers. tests/bench/effects.sh
// runs it under callgrind and prints the table; alone it prints ratios of CPU time.
#include <tbb/global_control.h>

#include <cstdio>
#include <ctime>
#include <string>

#include "octree/build/build.h"
#include "photon/paths/radiance.h"
#include "photon/trace/trace.h"
#include "tests/bench/minimal_loops.h"
#include "tests/bench/noise.h"
#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/voxel_fields.h"

#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>
#else
#define CALLGRIND_START_INSTRUMENTATION
#define CALLGRIND_STOP_INSTRUMENTATION
#define CALLGRIND_ZERO_STATS
#define CALLGRIND_DUMP_STATS_AT(name) static_cast<void>(name)
#define RUNNING_ON_VALGRIND 0
#endif

using namespace obscura;
using namespace obscura::bench;

namespace {

constexpr int kVoxels = 128;

/// A cloud that is rough down to the voxel, of one metre each, with a temperature that varies as much.
std::shared_ptr<const Octree> fractal(bool temperature) {
  std::vector<std::string> channels = {"density"};
  if (temperature) channels.emplace_back("temperature");
  const VoxelStream stream =
      test::field_stream(Box3i(Vec3i(0), Vec3i(kVoxels)), channels, [](int channel, const Vec3i& v) {
        const float density = bench::fractal_density(kVoxels, v.x, v.y, v.z);
        if (channel == 0 || !(density > 0)) return density;
        return 280 + 200 * static_cast<float>(bench::value_noise(99, 0.1 * v.x, 0.1 * v.y, 0.1 * v.z));
      });
  BuildSettings settings;
  settings.tolerance = 0;
  settings.measure.optical_weight = {kExtinction, 0};
  settings.measure.optical_weight.resize(channels.size());
  return std::make_shared<const Octree>(build_octree(stream, settings).first);
}

Cloud cloud_of(std::shared_ptr<const Octree> octree, double albedo) {
  Cloud cloud;
  cloud.octree = std::move(octree);
  cloud.local_to_world = placement({100, 200, 300}, {0.1, 0.2, 0.3}, 1);
  cloud.media.push_back({0, {kExtinction}, {albedo}, PhaseFunction::henyey_greenstein(0.6)});
  return cloud;
}

/// Rays from a far sensor through the cloud.
std::vector<Ray> camera_rays() {
  const Affine placed = placement({100, 200, 300}, {0.1, 0.2, 0.3}, 1);
  const Vec3d middle = transform_point(placed, Vec3d(0.5 * kVoxels));
  const Vec3d origin = middle + Vec3d(0, -400, 60);
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < kRays; ++i) {
    Stream random(1, i, 1);
    Vec3d offset;
    do {
      offset = Vec3d(random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5);
    } while (offset.length() > 0.42);
    rays.push_back({origin, (middle + 0.9 * kVoxels * offset - origin).normalized(), 0, kInfinity});
  }
  return rays;
}

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

class Bench {
 public:
  explicit Bench(std::string only) : only_(std::move(only)) {}

  /// @param work  what instructions are told per
  /// @param same  largest deviation allowed, relative to the mean
  void compare(const std::string& name, double work, double same, const Radiances& program, const Radiances& minimal) {
    if (!only_.empty() && name.find(only_) == std::string::npos) return;
    std::vector<double> a(kRays), b(kRays);
    const double seconds = measure(name + " | program", program, a), least = measure(name + " | minimal", minimal, b);
    double off = 0, mean = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      off = std::max(off, std::abs(a[i] - b[i]));
      mean += std::abs(b[i]) / static_cast<double>(b.size());
    }
    const bool agree = off <= same * mean && mean > 0;
    std::printf("%s | %.0f | %.3f | %s\n", name.c_str(), work, seconds / least, agree ? "same" : "DIFFERENT");
    if (!agree) std::printf("  largest deviation %g of a mean of %g\n", off, mean);
    failed_ = failed_ || !agree;
    std::fflush(stdout);
  }
  bool failed() const { return failed_; }

 private:
  double measure(const std::string& name, const Radiances& loop, std::vector<double>& radiance) {
    loop(radiance);  // tables and caches are made
    if (RUNNING_ON_VALGRIND) {
      CALLGRIND_START_INSTRUMENTATION;
      CALLGRIND_ZERO_STATS;
      loop(radiance);
      CALLGRIND_STOP_INSTRUMENTATION;
      CALLGRIND_DUMP_STATS_AT(name.c_str());
      return 1;
    }
    double best = kInfinity;
    for (int repeat = 0; repeat < 7; ++repeat) {
      const double begin = cpu_seconds();
      for (int i = 0; i < 4; ++i) loop(radiance);
      best = std::min(best, cpu_seconds() - begin);
    }
    return best;
  }

  std::string only_;
  bool failed_ = false;
};

class Program {
 public:
  Program(const World& world, const std::vector<Ray>& rays, RadianceSettings settings = {})
      : world_(world), rays_(rays), settings_(settings), incoming_(rays.size()) {
    for (std::size_t i = 0; i < rays.size(); ++i) histories_.push_back(i);
  }
  void operator()(std::vector<double>& radiance) {
    incoming_radiance({world_, 0}, nullptr, settings_, rays_, histories_, incoming_);
    for (std::size_t i = 0; i < rays_.size(); ++i) radiance[i] = incoming_[i].direct;
  }

 private:
  const World& world_;
  const std::vector<Ray>& rays_;
  RadianceSettings settings_;
  std::vector<std::uint64_t> histories_;
  std::vector<Incoming> incoming_;
};

}  // namespace

int main(int argc, char** argv) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  Bench bench(argc > 1 ? argv[1] : "");
  const std::vector<Ray> rays = camera_rays();
  const auto octree = fractal(false);
  std::printf("case | per | program / minimal, CPU | results\n");

  const auto grey = [&](bool cloud, double albedo, double source) {
    WorldContents contents = test::empty_contents(kSky);
    if (cloud) {
      contents.clouds.push_back(cloud_of(octree, albedo));
      if (source > 0) contents.clouds.back().source = {source};
    }
    return contents;
  };
  const auto add_surfaces = [](WorldContents& contents) {
    contents.materials = {test::grey_material(1)};
    const auto hills = test::sheet_mesh(128, [](std::uint32_t i, std::uint32_t j) {
      return Vec3d(6.0 * i - 250, 6.0 * j - 250, 300 + 30 * bench::value_noise(7, 0.1 * i, 0.1 * j, 0));
    });
    contents.objects = {test::grey_object(hills, 0, 4)};
  };
  {
    const World world(grey(true, 0, 0));
    bench.compare("a  absorption before a sky", kRays, 1e-12, Program(world, rays), absorption(world, rays, 0));
  }
  {
    const World world(grey(true, 0, kSource));
    bench.compare("b1 absorption and emission, one temperature", kRays, 1e-12, Program(world, rays),
                  absorption(world, rays, kSource));
  }
  {
    WorldContents contents;
    contents.bands.emplace_back("ir", 8.0, 12.0);
    contents.sky = {kSky};
    contents.clouds.push_back(cloud_of(fractal(true), 0));
    contents.clouds.back().temperature.channel = 1;
    const World world(std::move(contents));
    const PlanckTable planck(world.bands()[0], 0, 270, 490);
    bench.compare("b2 absorption and emission, temperatures", kRays, 1e-4, Program(world, rays),
                  varying_temperature(world, rays, planck));
  }
  {
    WorldContents contents = grey(false, 0, 0);
    add_surfaces(contents);
    const World world(std::move(contents));
    bench.compare("c  surfaces, no cloud", kRays, 1e-12, Program(world, rays), surfaces_only(world, rays));
  }
  {
    WorldContents contents = grey(true, kAlbedo, 0);
    contents.sun = Sun{Vec3d(0.3, -0.4, 0.8).normalized(), {kSun}, 0};
    const World world(std::move(contents));
    RadianceSettings settings;
    settings.parts.sky = false;
    bench.compare("d  sunlight scattered once, no surfaces", kRays, 1e-3, Program(world, rays, settings),
                  single_scattering(world, rays, settings.points));
  }
  {
    WorldContents contents = grey(true, kAlbedo, 0);
    contents.sky = {0};
    contents.sun = Sun{Vec3d(0.3, -0.4, 0.8).normalized(), {kSun}, 0};
    const World world(std::move(contents));
    const PhotonEmitter emitter({world, 0});
    TraceSettings settings;
    settings.photons = 16 * 2048;
    // What is compared is how many are stored.
    const auto spread = [](const std::vector<Photon>& photons, std::vector<double>& radiance) {
      std::fill(radiance.begin(), radiance.end(), 0.0);
      radiance[0] = static_cast<double>(photons.size());
    };
    bench.compare(
        "e  photons of a sun, no surfaces", static_cast<double>(settings.photons), 1e-3,
        [&](std::vector<double>& radiance) { spread(trace_photons(emitter, settings).photons, radiance); },
        [&](std::vector<double>& radiance) {
          double absorbed;
          spread(minimal_photons(world, emitter, settings.photons, absorbed), radiance);
        });
  }
  {
    WorldContents contents = grey(true, 0, kSource);
    add_surfaces(contents);
    const World world(std::move(contents));
    bench.compare("f  cloud before surfaces, no air", kRays, 1e-12, Program(world, rays),
                  cloud_and_surfaces(world, rays));
  }
  return bench.failed() ? 1 : 0;
}
