// The path tracer against delta trackers with one global majorant, on the same cloud and camera, one thread:
// mean squared error times time, for sun and sky. Plain: absorption and shadows by chance, as Woodcock's method
// has them. Weighted: ratio tracking, survival weights and roulette. All are unbiased; the means are printed.
#include <nanovdb/NanoVDB.h>
#include <nanovdb/util/OpenToNanoVDB.h>

#include <chrono>
#include <cstdio>
#include <memory>
#include <vector>

#include "octree/build/build.h"
#include "photon/optics/phase.h"
#include "photon/optics/sampling.h"
#include "photon/paths/path_tracer.h"
#include "sensor/capture/camera.h"
#include "sensor/capture/sampler.h"
#include "tests/bench/fields.h"
#include "tests/support/places.h"

using namespace obscura;
using namespace obscura::bench;

namespace {

constexpr int kSide = 64;  // pixels
constexpr int kRays = 16;  // of a pixel and repeat
constexpr int kRepeats = 8;
constexpr double kAlbedo = 0.95, kG = 0.6, kSky = 0.3, kSun = 5;

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Cheap and good enough for a baseline: SplitMix64 (Steele et al., OOPSLA 2014).
struct Random {
  std::uint64_t state;
  double operator()() noexcept {
    std::uint64_t z = state += 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return (static_cast<double>((z ^ z >> 31) >> 11) + 0.5) * 0x1p-53;
  }
};

/// Woodcock tracking for flights; the sky where a path escapes. Weighted: ratio tracking for shadow rays (Novak et
/// al., 2014), survival weights with roulette.
template <bool weighted>
class DeltaTracker {
 public:
  DeltaTracker(const nanovdb::NanoGrid<float>& grid, double extinction, const Vec3d& toward_sun)
      : accessor_(grid.getAccessor()), extinction_(extinction), toward_(toward_sun) {
    const auto box = grid.tree().bbox();
    for (int a = 0; a < 3; ++a) {
      low_[a] = box.min()[a];
      high_[a] = box.max()[a] + 1;
    }
    majorant_ = extinction * static_cast<double>(grid.tree().root().maximum());
  }

  double radiance(Vec3d x, Vec3d d, Random& random) const {
    double weight = 1, sum = 0;
    for (;;) {
      auto [t, exit] = clip(x, d);
      double k = 0;
      do {
        t -= std::log(random()) / majorant_;
        if (t >= exit) return sum + weight * kSky;
        k = at(x + t * d);
      } while (random() * majorant_ >= k);
      x += t * d;
      if constexpr (weighted) {
        weight *= kAlbedo;
      } else {
        if (random() >= kAlbedo) return sum;
      }
      sum += weight * phase_.value(d.dot(toward_)) * kSun * transmission(x, random);
      if (weighted && weight < 0.1) {
        if (random() >= weight / 0.1) return sum;
        weight = 0.1;
      }
      const double cosine = phase_.sample(random(), 0.5);
      d = direction_about(d, cosine, 2 * kPi * random());
    }
  }

 private:
  double at(const Vec3d& p) const {
    return extinction_ * static_cast<double>(accessor_.getValue(
                             nanovdb::Coord(nanovdb::Floor(p.x), nanovdb::Floor(p.y), nanovdb::Floor(p.z))));
  }
  std::pair<double, double> clip(const Vec3d& x, const Vec3d& d) const {
    double near = 0, far = kInfinity;
    for (int a = 0; a < 3; ++a) {
      const double t0 = (low_[a] - x[a]) / d[a], t1 = (high_[a] - x[a]) / d[a];
      near = std::max(near, std::min(t0, t1));
      far = std::min(far, std::max(t0, t1));
    }
    return {near, far};
  }
  double transmission(const Vec3d& x, Random& random) const {
    auto [t, exit] = clip(x, toward_);
    double through = 1;
    for (;;) {
      t -= std::log(random()) / majorant_;
      if (t >= exit) return through;
      const double k = at(x + t * toward_);
      if constexpr (!weighted) {
        if (random() * majorant_ < k) return 0;
        continue;
      }
      through *= 1 - k / majorant_;
      if (through < 0.1) {
        if (random() >= through / 0.1) return 0;
        through = 0.1;
      }
    }
  }

  nanovdb::DefaultReadAccessor<float> accessor_;
  double extinction_;
  Vec3d toward_;
  Vec3d low_, high_;
  double majorant_;
  PhaseFunction phase_ = PhaseFunction::henyey_greenstein(kG);
};

/// Images of independent repeats: their scatter and the time of one.
struct Repeats {
  std::vector<std::vector<double>> images;
  double seconds = 0;

  /// Another image: what comes before its rays, then ray by ray.
  template <class Before, class Value>
  void add(Before&& before, Value&& value, std::size_t rays) {
    auto& image = images.emplace_back(kSide * kSide);
    const double start = now();
    before();
    for (std::size_t r = 0; r < rays; ++r) image[r / kRays] += value(r) / kRays;
    seconds += (now() - start) / kRepeats;
  }
  double cost() const { return squared_error() * seconds; }

  double mean() const {
    double sum = 0;
    for (const auto& image : images)
      for (const double value : image) sum += value;
    return sum / static_cast<double>(images.size() * images[0].size());
  }
  /// Mean squared error of one image by the definition of the image error, from the scatter.
  double squared_error() const {
    std::vector<double> means(images[0].size());
    for (const auto& image : images)
      for (std::size_t p = 0; p < image.size(); ++p) means[p] += image[p] / static_cast<double>(images.size());
    const double top = *std::max_element(means.begin(), means.end());
    double sum = 0;
    for (const auto& image : images) {
      for (std::size_t p = 0; p < image.size(); ++p) {
        const double off = (image[p] - means[p]) / std::max(means[p], 0.05 * top);
        sum += off * off;
      }
    }
    return sum / static_cast<double>((images.size() - 1) * images[0].size());
  }
};

void compare(const char* name, const openvdb::FloatGrid::Ptr& grid, double depth) {
  const auto octree = std::make_shared<const Octree>(build_octree(grid_stream(grid),
                                                                  [] {
                                                                    BuildSettings settings;
                                                                    settings.tolerance = 0;
                                                                    settings.measure.optical_weight = {1};
                                                                    return settings;
                                                                  }())
                                                         .first);
  // The largest depth of lines along x through the middle's neighbourhood is the wished one.
  const Box3d box(Vec3d(octree->domain().min), Vec3d(octree->domain().max));
  const Vec3d middle = box.center();
  const double one = 1;
  double most = 0;
  for (double z = box.min.z + 0.5; z < box.max.z; z += 1) {
    for (double y = box.min.y + 0.5; y < box.max.y; y += 1) {
      most = std::max(most, optical_depth(*octree, Ray{{box.min.x - 1, y, z}, {1, 0, 0}, 0, kInfinity}, {&one, 1}));
    }
  }
  const double extinction = depth / most;
  const Vec3d toward = Vec3d(0.5, -0.3, 0.8).normalized();

  WorldContents contents;
  contents.bands.emplace_back("grey");
  Cloud cloud;
  cloud.octree = octree;
  cloud.media.push_back({0, {extinction}, {kAlbedo}, PhaseFunction::henyey_greenstein(kG)});
  contents.clouds.push_back(cloud);
  contents.sky = {kSky};
  contents.sun = Sun{toward, {kSun}, 0};
  const World world(std::move(contents));

  CameraSettings settings;
  settings.position_m = middle + Vec3d(0, -2.2 * box.size().y, 0.4 * box.size().z);
  settings.look_at_m = middle;
  settings.fov_deg = 32;
  settings.resolution = {kSide, kSide};
  const Camera camera(settings);

  Repeats ours, plain, weighted;
  const auto handle = nanovdb::openToNanoVDB(*grid);
  const DeltaTracker<false> plain_tracker(*handle.grid<float>(), extinction, toward);
  const DeltaTracker<true> weighted_tracker(*handle.grid<float>(), extinction, toward);
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    const Sampler sampler(camera, {.max_oversampling = kRays, .seed = static_cast<std::uint64_t>(repeat + 1)});
    std::vector<PixelRay> drawn;
    for (int p = 0; p < kSide * kSide; ++p) sampler.rays(p % kSide, p / kSide, sampler.strata(), 0, drawn);
    std::vector<Ray> rays;
    std::vector<std::uint64_t> histories;
    for (const PixelRay& ray : drawn) {
      rays.push_back(*ray.ray);
      histories.push_back(ray.history);
    }
    PathSettings paths;
    paths.paths = 2;
    paths.seed = static_cast<std::uint64_t>(repeat + 1);
    std::vector<Incoming> incoming(rays.size());
    ours.add(
        [&] {
          path_radiance({world, 0}, paths, rays, histories, incoming);
        },
        [&](std::size_t r) { return incoming[r].total(); }, rays.size());
    const auto track = [&](const auto& tracker) {
      return [&](std::size_t r) {
        Random random{(static_cast<std::uint64_t>(repeat) << 32) + r * 0x2545F4914F6CDD1Du};
        return tracker.radiance(rays[r].origin, rays[r].direction, random);
      };
    };
    plain.add([] {}, track(plain_tracker), rays.size());
    weighted.add([] {}, track(weighted_tracker), rays.size());
  }
  std::printf("%-16s %6.1f", name, depth);
  for (const Repeats* method : {&ours, &plain, &weighted}) {
    std::printf(" | %.4f %5.2f %7.3f", method->mean(), 100 * std::sqrt(method->squared_error()), method->seconds);
  }
  std::printf(" | %6.2f %6.2f\n", plain.cost() / ours.cost(), weighted.cost() / ours.cost());
}

}  // namespace

int main() {
  openvdb::initialize();
  std::printf(
      "mean, error in %%, seconds of paths | plain | weighted delta tracker | error^2 x time in units of the paths'\n");
  for (const double depth : {0.5, 10.0, 40.0}) {
    compare("rough 128^3", rough_fractal(128), depth);
    compare("plume 128^3", smooth_plume(128), depth);
  }
  if (const auto grid = read_grid(test::shared_path("data/wdas_cloud_sixteenth/wdas_cloud_sixteenth.vdb")))
    compare("wdas / 16", grid, 10);
}
