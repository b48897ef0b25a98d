#include "sensor/sight/sight.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>

#include "photon/optics/purpose.h"
#include "sensor/capture/sampler.h"

namespace obscura {
namespace {

/// Rays that one task follows.
constexpr std::size_t kBlock = 4096;
/// Surfaces that a line may pass through before it ends: nets behind nets.
constexpr int kMostPassed = 256;

/// The surface at the end of a line of the given length, or none: what it has passed through on its way does not count.
std::uint32_t surface_at_end(const Surfaces& surfaces, Ray ray, double length) {
  if (surfaces.empty() || !(length < kInfinity)) return FaceId::kNone;
  const double end = length * (1 - 1e-6);
  SurfaceHit hit = surfaces.intersect(ray);
  for (int passed = 0; hit.exists() && hit.t < end && passed < kMostPassed; ++passed) {
    ray.t_min = hit.t;
    hit = surfaces.intersect(ray, hit.id);
  }
  return hit.id.surface;
}

}  // namespace

std::vector<std::vector<std::pair<std::uint32_t, float>>> object_shares(const World& world, const Camera& camera,
                                                                        const Progress& progress) {
  constexpr int lines = kMaskLines * kMaskLines;
  struct Seen {
    std::uint32_t object, pixel;
    int count;
  };
  std::vector<std::vector<Seen>> found(static_cast<std::size_t>(camera.rows()));
  std::atomic<std::uint64_t> done{0};
  tbb::parallel_for(0, camera.rows(), [&](int y) {
    if (progress.cancelled()) return;
    std::vector<Seen>& row = found[static_cast<std::size_t>(y)];
    for (int x = 0; x < camera.columns(); ++x) {
      const auto pixel =
          static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(camera.columns()) + static_cast<std::uint32_t>(x);
      const std::size_t first = row.size();
      for (int k = 0; k < lines; ++k) {
        const auto ray = camera.ray(x + (k % kMaskLines + 0.5) / kMaskLines, y + (k / kMaskLines + 0.5) / kMaskLines);
        if (!ray) continue;
        const std::uint64_t line = static_cast<std::uint64_t>(pixel) * lines + static_cast<std::uint64_t>(k);
        Stream stream = StreamName{0, line, Purpose::pixel}.stream();
        const std::uint32_t surface = world.meet(*ray, {}, stream).id.surface;
        if (surface >= world.objects().size()) continue;
        const auto same = std::find_if(row.begin() + static_cast<std::ptrdiff_t>(first), row.end(),
                                       [&](const Seen& seen) { return seen.object == surface; });
        if (same == row.end()) {
          row.push_back({surface, pixel, 1});
        } else {
          ++same->count;
        }
      }
    }
    progress.report("objects", ++done, static_cast<std::uint64_t>(camera.rows()));
  });
  std::vector<std::vector<std::pair<std::uint32_t, float>>> shares(world.objects().size());
  for (const auto& row : found) {
    for (const Seen& seen : row) shares[seen.object].emplace_back(seen.pixel, static_cast<float>(seen.count) / lines);
  }
  return shares;
}

SightRays sight_rays(const Camera& camera, const ObjectMask& mask, int lines_per_pixel, std::uint64_t seed) {
  SightRays result;
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.columns; ++x) {
      const auto pixel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(mask.columns) + static_cast<std::size_t>(x);
      const bool object = mask.share[pixel] > 0;
      if (!object && !mask.ring[pixel]) continue;
      const std::int32_t slot = object ? static_cast<std::int32_t>(result.pixels++) : -1;
      Stream stream = StreamName{seed, pixel, Purpose::pixel}.stream();
      for (int k = 0; k < lines_per_pixel; ++k) {
        const Stratum cell = stratum(k, lines_per_pixel);
        const double px = x + cell.x_min + cell.width * stream.uniform();
        const double py = y + cell.y_min + cell.height * stream.uniform();
        const auto ray = camera.ray(px, py);
        if (!ray) continue;
        result.rays.push_back(*ray);
        result.histories.push_back(pixel * static_cast<std::uint64_t>(lines_per_pixel) + static_cast<std::uint64_t>(k));
        result.slots.push_back(slot);
      }
    }
  }
  return result;
}

Sight look(const World& world, const RadianceEstimator& estimator, const SightRays& rays, std::uint32_t object,
           const Progress& progress) {
  const std::size_t bands = world.bands().size(), count = rays.rays.size();
  std::vector<double> values(bands * count), biases(bands * count), transmission(bands * count);
  std::vector<std::uint8_t> on_object(count);
  const std::size_t blocks = (count + kBlock - 1) / kBlock;
  std::vector<RadianceCounts> counts(blocks);
  std::atomic<std::uint64_t> done{0};
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
    if (progress.cancelled()) return;
    const std::size_t first = block * kBlock, size = std::min(kBlock, count - first);
    const std::span<const Ray> here = std::span(rays.rays).subspan(first, size);
    std::vector<Incoming> incoming(size);
    for (int i = 0; i < world.interval_count(); ++i) {
      const IntervalIndex where = world.interval(i);
      const auto b = static_cast<std::size_t>(where.band);
      const double weight = world.bands()[b].intervals()[static_cast<std::size_t>(where.interval)].weight;
      counts[block] += estimator(i, {}, here, std::span(rays.histories).subspan(first, size), incoming);
      for (std::size_t r = 0; r < size; ++r) {
        values[b * count + first + r] += incoming[r].total();
        biases[b * count + first + r] += incoming[r].bias;
        transmission[b * count + first + r] += weight * incoming[r].transmission;
      }
    }
    for (std::size_t r = 0; r < size; ++r) {
      on_object[first + r] = surface_at_end(world.surfaces(), here[r], incoming[r].distance) == object ? 1 : 0;
    }
    progress.report("sight", ++done, blocks);
  });

  Sight sight;
  for (const RadianceCounts& block : counts) sight.counts += block;
  sight.looks.resize(bands);
  sight.transmission.resize(bands);
  for (std::size_t b = 0; b < bands; ++b) {
    Look& band = sight.looks[b];
    band.lines.resize(rays.pixels);
    band.radiance.resize(rays.pixels);
    for (std::size_t r = 0; r < count; ++r) {
      const std::int32_t slot = rays.slots[r];
      const double value = values[b * count + r];
      if (on_object[r] && slot >= 0) {
        band.lines[static_cast<std::size_t>(slot)] += 1;
        band.radiance[static_cast<std::size_t>(slot)] += value;
        band.bias += biases[b * count + r];
        sight.transmission[b].push_back(static_cast<float>(transmission[b * count + r]));
      } else if (!on_object[r] && slot < 0) {
        band.surround_lines += 1;
        band.surround_radiance += value;
        band.surround_bias += biases[b * count + r];
      }
    }
  }
  return sight;
}

}  // namespace obscura
