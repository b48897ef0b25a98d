#include "sensor/render.h"

#include <atomic>

#include <tbb/parallel_for.h>

namespace obscura {
namespace {

/// The rays of a tile's pixels, in pixel order.
struct TileRays {
  std::vector<Ray> rays;
  std::vector<std::uint64_t> histories;
  /// Per pixel, for each of its rays: place in `rays`, or -1 where the camera sees nothing.
  std::vector<std::vector<int>> pixels;
};

TileRays rays_of(const FilmTile& tile, const Sampler& sampler) {
  TileRays result;
  for (int y = tile.y_begin(); y < tile.y_end(); ++y) {
    for (int x = tile.x_begin(); x < tile.x_end(); ++x) {
      std::vector<int>& pixel = result.pixels.emplace_back();
      PixelRays rays = sampler.pixel(x, y);
      while (const std::optional<PixelRay> ray = rays.next()) {
        pixel.push_back(ray->ray ? static_cast<int>(result.rays.size()) : -1);
        if (!ray->ray) continue;
        result.rays.push_back(*ray->ray);
        result.histories.push_back(ray->history);
      }
    }
  }
  return result;
}

/// The object that a ray meets first: 1-based, 0 none.
std::uint32_t object_at(const World& world, const std::optional<Ray>& ray) {
  if (!ray) return 0;
  const FaceId face = world.surfaces().intersect(*ray).id;
  return face.surface < world.objects().size() ? face.surface + 1 : 0;
}

/// What the rays bring home in all bands: interval after interval, added up per band.
RadianceCounts trace(const World& world, const Estimator& estimator, const TileRays& tile,
                     std::vector<RaySample>& samples) {
  RadianceCounts counts;
  for (RaySample& sample : samples) {
    for (BandSample& band : sample.bands) band.transmission = band.transmission_atmosphere = 0;
  }
  std::vector<Incoming> incoming(tile.rays.size());
  for (int i = 0; i < world.interval_count(); ++i) {
    const IntervalIndex where = world.interval(i);
    const auto b = static_cast<std::size_t>(where.band);
    const double weight = world.bands()[b].intervals()[static_cast<std::size_t>(where.interval)].weight;
    counts += estimator(i, tile.rays, tile.histories, incoming);
    for (std::size_t r = 0; r < incoming.size(); ++r) {
      const Incoming& in = incoming[r];
      BandSample& band = samples[r].bands[b];
      band.direct += in.direct;
      for (std::size_t k = 0; k < in.map.size(); ++k) band.map[k] += in.map[k];
      band.bias += in.bias;
      band.variance += in.variance;
      band.transmission += weight * in.transmission;
      band.transmission_atmosphere += weight * in.transmission_air;
      samples[r].depth_m = in.distance;
    }
  }
  return counts;
}

}  // namespace

Rendered render(const World& world, std::span<const PhotonMaps> maps, const Camera& camera,
                const SamplerSettings& sampling, const RadianceSettings& radiance,
                const Progress& progress) {
  const auto by_map = [&](int interval, std::span<const Ray> rays, std::span<const std::uint64_t> histories,
                          std::span<Incoming> incoming) {
    const PhotonMaps* map = maps.empty() ? nullptr : &maps[static_cast<std::size_t>(interval)];
    RadianceSettings settings = radiance;
    settings.footprint = camera.footprint(1.0 / sampling.max_oversampling);
    return incoming_radiance(world, interval, map, settings, rays, histories, incoming);
  };
  return render(world, by_map, camera, sampling, progress);
}

Rendered render(const World& world, const Estimator& estimator, const Camera& camera, const SamplerSettings& sampling,
                const Progress& progress) {
  const int bands = static_cast<int>(world.bands().size());
  Film film({{camera.columns(), camera.rows()}, bands});
  const Sampler sampler(camera, sampling);
  std::vector<RadianceCounts> counts(static_cast<std::size_t>(film.tile_count()));
  std::atomic<std::uint64_t> done{0};
  tbb::parallel_for(0, film.tile_count(), [&](int index) {
    if (progress.cancelled()) return;
    FilmTile tile = film.tile(index);
    const TileRays rays = rays_of(tile, sampler);
    std::vector<RaySample> samples(rays.rays.size(), RaySample(bands));
    counts[static_cast<std::size_t>(index)] = trace(world, estimator, rays, samples);

    const RaySample nothing(bands);
    PixelSum sum(bands);
    std::size_t pixel = 0;
    for (int y = tile.y_begin(); y < tile.y_end(); ++y) {
      for (int x = tile.x_begin(); x < tile.x_end(); ++x) {
        sum.reset();
        for (const int ray : rays.pixels[pixel]) {
          sum.add(ray < 0 ? nothing : samples[static_cast<std::size_t>(ray)]);
        }
        tile.put(x, y, sum, object_at(world, sampler.centre(x, y)));
        ++pixel;
      }
    }
    film.put(std::move(tile));
    progress.report("image", ++done, static_cast<std::uint64_t>(film.tile_count()));
  });
  film.pool_errors();
  Rendered result{std::move(film), {}};
  for (const RadianceCounts& tile : counts) result.counts += tile;
  return result;
}

}  // namespace obscura
