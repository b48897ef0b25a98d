// What effects that are off cost: instructions of the program on scenes that lack them against minimal loops, written
// by hand, that have never heard of them but use the same walks, ray queries and random numbers. tests/bench/effects.sh
// runs it under callgrind and prints the table; alone it prints ratios of CPU time.
#include <tbb/global_control.h>

#include <cstdio>
#include <ctime>
#include <functional>
#include <string>

#include "octree/base/low_discrepancy.h"
#include "octree/build/build.h"
#include "photon/optics/purpose.h"
#include "photon/optics/transfer.h"
#include "photon/paths/radiance.h"
#include "photon/trace/trace.h"
#include "photon/world/scatter.h"
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

namespace {

constexpr int kVoxels = 128;
constexpr std::size_t kRays = 4096;
constexpr double kExtinction = 0.3;  // up to an optical depth of 10 across
constexpr double kAlbedo = 0.9;
constexpr double kSky = 3, kSource = 2, kSun = 5;

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

/// Radiance of all rays by the program or by a loop.
using Radiances = std::function<void(std::vector<double>&)>;

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
    incoming_radiance(world_, 0, nullptr, settings_, rays_, histories_, incoming_);
    for (std::size_t i = 0; i < rays_.size(); ++i) radiance[i] = incoming_[i].direct;
  }

 private:
  const World& world_;
  const std::vector<Ray>& rays_;
  RadianceSettings settings_;
  std::vector<std::uint64_t> histories_;
  std::vector<Incoming> incoming_;
};

// --- Minimal loops. Each is what one would write who has only this to compute.

/// Optical depths of the one cloud.
class Depths {
 public:
  explicit Depths(const World& world)
      : octree_(*world.clouds()[0].octree), to_index_(world.frame(0).world_to_index), weights_{kExtinction, 0} {
    weights_.resize(static_cast<std::size_t>(octree_.channel_count()));
  }
  std::span<const double> operator()(std::span<const Ray> rays) {
    index_rays_.resize(rays.size());
    depths_.resize(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) index_rays_[i] = transform_ray(to_index_, rays[i]);
    optical_depths(octree_, index_rays_, weights_, depths_);
    return depths_;
  }

 private:
  const Octree& octree_;
  Affine to_index_;
  std::vector<double> weights_;
  std::vector<Ray> index_rays_;
  std::vector<double> depths_;
};

Radiances absorption(const World& world, const std::vector<Ray>& rays, double source) {
  return [&rays, source, depths = Depths(world)](std::vector<double>& radiance) mutable {
    const std::span<const double> depth = depths(rays);
    if (source > 0) {
      for (std::size_t i = 0; i < rays.size(); ++i)
        radiance[i] = std::exp(-depth[i]) * kSky + source * one_minus_exp(depth[i]);
    } else {
      for (std::size_t i = 0; i < rays.size(); ++i) radiance[i] = std::exp(-depth[i]) * kSky;
    }
  };
}

Radiances varying_temperature(const World& world, const std::vector<Ray>& rays, const PlanckTable& planck) {
  return [&world, &rays, &planck](std::vector<double>& radiance) {
    const Octree& octree = *world.clouds()[0].octree;
    const Affine& to_index = world.frame(0).world_to_index;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      double sum = 0, transmission = 1, depth = 0;
      Walk walk(octree, transform_ray(to_index, rays[i]));
      while (walk.next() && transmission > 0) {
        if (walk.empty()) continue;
        const double tau = kExtinction * static_cast<double>(walk.value(0)) * (walk.end() - walk.begin());
        sum += transmission * one_minus_exp(tau) * planck(static_cast<double>(walk.value(1)));
        depth += tau;
        transmission = std::exp(-depth);
      }
      radiance[i] = sum + transmission * kSky;
    }
  };
}

Radiances surfaces_only(const World& world, const std::vector<Ray>& rays) {
  return [&world, &rays](std::vector<double>& radiance) {
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const SurfaceHit hit = world.surfaces().intersect(rays[i]);
      if (hit.exists()) {
        const SurfacePoint at = world.surface_at(0, rays[i], hit);
        radiance[i] = at.emission(at.cosine);
      } else {
        radiance[i] = kSky;
      }
    }
  };
}

/// Clouds before surfaces, in clear air.
Radiances cloud_and_surfaces(const World& world, const std::vector<Ray>& rays) {
  return [&world, &rays, depths = Depths(world), ends = rays,
          behind = std::vector<double>(kRays)](std::vector<double>& radiance) mutable {
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const SurfaceHit hit = world.surfaces().intersect(rays[i]);
      ends[i].t_max = hit.t;
      behind[i] = kSky;
      if (hit.exists()) {
        const SurfacePoint at = world.surface_at(0, rays[i], hit);
        behind[i] = at.emission(at.cosine);
      }
    }
    const std::span<const double> depth = depths(ends);
    for (std::size_t i = 0; i < rays.size(); ++i)
      radiance[i] = std::exp(-depth[i]) * behind[i] + kSource * one_minus_exp(depth[i]);
  };
}

/// Sunlight scattered once: strata of the depth that a ray loses, a shadow ray from each.
Radiances single_scattering(const World& world, const std::vector<Ray>& rays, int points) {
  return [&world, &rays, points, depths = Depths(world), shadow_depths = Depths(world), own = std::vector<Flight>(),
          flights = std::vector<Flight>(), ends = std::vector<FreePath>(), weights = std::vector<double>(),
          owners = std::vector<std::size_t>(), shadows = std::vector<Ray>(),
          lights = std::vector<double>()](std::vector<double>& radiance) mutable {
    const Octree& octree = *world.clouds()[0].octree;
    const Affine& to_index = world.frame(0).world_to_index;
    const PhaseFunction& phase = world.clouds()[0].media[0].phase;
    const Vec3d toward = world.suns()[0].toward;
    const std::array<double, 1> extinction = {kExtinction};
    const double near = 2e-3 * (world.frame(0).local_bounds.max - world.frame(0).local_bounds.min).length();
    constexpr std::size_t kTogether = 4096;
    for (std::size_t first = 0; first < rays.size(); first += kTogether) {
      const auto some = std::span(rays).subspan(first, std::min(kTogether, rays.size() - first));
      const std::span<const double> depth = depths(some);
      own.clear();
      weights.clear();
      owners.clear();
      for (std::size_t i = 0; i < some.size(); ++i) {
        radiance[first + i] = std::exp(-depth[i]) * kSky;
        const double lost = one_minus_exp(depth[i]);
        if (!(lost > 0)) continue;
        const int count = std::max(1, static_cast<int>(std::ceil(lost * points)));
        Stream stream = StreamName{1, first + i, Purpose::radiance}.stream();
        const Ray ray = transform_ray(to_index, some[i]);
        for (int k = 0; k < count; ++k) {
          const double u = (k + stream.uniform()) / count;
          own.push_back({ray, std::min(-std::log1p(-u * lost), depth[i])});
          weights.push_back(kAlbedo * lost / count * kSun);
          owners.push_back(i);
        }
      }
      ends.resize(own.size());
      free_paths(octree, own, extinction, ends);
      shadows.clear();
      lights.clear();
      std::size_t kept = 0;
      for (std::size_t p = 0; p < own.size(); ++p) {
        if (!ends[p].collided) continue;
        const Ray& ray = some[owners[p]];
        // The batched walk is too coarse for the shortest.
        if (ends[p].t - own[p].ray.t_min < near)
          ends[p] = free_path(octree, own[p].ray, extinction, own[p].target_depth);
        lights.push_back(weights[p] * phase.value(toward.dot(ray.direction)));
        shadows.push_back({ray.at(ends[p].t), toward, 0, kInfinity});
        owners[kept++] = owners[p];
      }
      const std::span<const double> dark = shadow_depths(shadows);
      for (std::size_t p = 0; p < kept; ++p) radiance[first + owners[p]] += lights[p] * std::exp(-dark[p]);
    }
  };
}

/// Photons of a parallel sun in one cloud: collisions beyond the first are stored.
std::vector<Photon> minimal_photons(const World& world, const PhotonEmitter& emitter, std::uint64_t photons,
                                    double& absorbed) {
  struct History {
    Vec3d position, direction;
    double power;
    int collisions;
    Stream stream;
  };
  const Octree& octree = *world.clouds()[0].octree;
  const Affine& to_index = world.frame(0).world_to_index;
  const PhaseFunction& phase = world.clouds()[0].media[0].phase;
  const std::array<double, 1> extinction = {kExtinction};
  const double near = 2e-3 * (world.frame(0).local_bounds.max - world.frame(0).local_bounds.min).length();
  std::vector<Photon> stored;
  std::vector<History> active;
  std::vector<Flight> flights;
  std::vector<FreePath> ends;
  PhotonEmitter::Cache cache;
  absorbed = 0;
  std::uint64_t first = 0;
  for (std::uint64_t batch = 0; batch < kBatches; ++batch) {
    const std::uint64_t count = photons / kBatches;
    const LowDiscrepancy numbers(1, static_cast<std::uint32_t>(batch));
    for (std::uint64_t begin = 0; begin < count; begin += 2048) {
      active.clear();
      for (std::uint64_t i = begin; i < std::min(begin + 2048, count); ++i) {
        const EmittedPhoton photon = emitter.emit(numbers.point(static_cast<std::uint32_t>(i)), cache);
        active.push_back({photon.position, photon.direction, photon.power / static_cast<double>(photons), 0,
                          StreamName{1, first + i, Purpose::tracing}.stream()});
      }
      while (!active.empty()) {
        flights.clear();
        for (History& h : active) {
          flights.push_back(
              {transform_ray(to_index, {h.position, h.direction, 0, kInfinity}), -std::log(h.stream.uniform())});
        }
        ends.resize(flights.size());
        free_paths(octree, flights, extinction, ends);
        std::size_t kept = 0;
        for (std::size_t i = 0; i < active.size(); ++i) {
          if (!ends[i].collided) continue;
          if (ends[i].t < near) ends[i] = free_path(octree, flights[i].ray, extinction, flights[i].target_depth);
          History& h = active[i];
          h.position += ends[i].t * h.direction;
          if (h.collisions++ > 0) {
            Photon photon;
            photon.position = Vec3f(transform_point(world.world_to_map(), h.position));
            photon.direction = encode_direction(h.direction);
            photon.power = static_cast<float>(h.power);
            photon.batch = static_cast<std::uint16_t>(batch);
            photon.collisions = static_cast<std::uint16_t>(h.collisions - 1);
            stored.push_back(photon);
          }
          if (h.stream.uniform() >= kAlbedo) {
            absorbed += h.power;
            continue;
          }
          h.stream.uniform();
          const double v = h.stream.uniform();
          h.direction = direction_about(h.direction, phase.sample(v, 0), 2 * kPi * h.stream.uniform());
          if (kept != i) active[kept] = h;
          ++kept;
        }
        active.erase(active.begin() + static_cast<std::ptrdiff_t>(kept), active.end());
      }
    }
    first += count;
  }
  return stored;
}

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
    const PhotonEmitter emitter(world, 0);
    TraceSettings settings;
    settings.photons = 16 * 2048;
    // What is compared is how many are stored.
    const auto spread = [](const std::vector<Photon>& photons, std::vector<double>& radiance) {
      std::fill(radiance.begin(), radiance.end(), 0.0);
      radiance[0] = static_cast<double>(photons.size());
    };
    bench.compare(
        "e  photons of a sun, no surfaces", static_cast<double>(settings.photons), 1e-3,
        [&](std::vector<double>& radiance) { spread(trace_photons(world, emitter, settings).photons, radiance); },
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
