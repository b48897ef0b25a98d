#include "sensor/capture/render.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>

#include "sensor/capture/pool.h"

namespace obscura {
namespace {

/// The object that a ray meets first: 1-based, 0 none.
std::uint32_t object_at(const World& world, const std::optional<Ray>& ray) {
  if (!ray) return 0;
  const FaceId face = world.surfaces().intersect(*ray).id;
  return face.surface < world.objects().size() ? face.surface + 1 : 0;
}

/// One tile on its way to the film.
class TilePass {
 public:
  TilePass(const World& world, const RadianceEstimator& estimator, const Sampler& sampler, const Refiner* refiner,
           FilmTile tile)
      : world_(world),
        estimator_(estimator),
        sampler_(sampler),
        refiner_(refiner),
        tile_(std::move(tile)),
        columns_(tile_.x_end() - tile_.x_begin()),
        pixels_(static_cast<std::size_t>(columns_ * (tile_.y_end() - tile_.y_begin()))),
        bands_(static_cast<int>(world.bands().size())) {}

  FilmTile run() {
    parts_ = refiner_ ? refiner_->split(tile_) : even_strata(world_, sampler_, tile_);
    rays += parts_.rays;
    counts += parts_.counts;
    if (refiner_ && sampler_.settings().adaptive->error) {
      by_halves();
    } else {
      for (std::size_t p = 0; p < pixels_; ++p) send(p, 0, 1);
      trace();
    }
    put();
    return std::move(tile_);
  }

  RadianceCounts counts;
  RayCounts rays;

 private:
  /// A ray of a pixel, in the order in which it was sent.
  struct Sent {
    std::size_t pixel;
    double share;   // of the pixel's samples
    double weight;  // in its mean
    std::size_t sample;
    std::size_t part;  // its stratum, among those of the tile's pixels
    int paths;
  };

  int x_of(std::size_t pixel) const noexcept { return tile_.x_begin() + static_cast<int>(pixel) % columns_; }
  int y_of(std::size_t pixel) const noexcept { return tile_.y_begin() + static_cast<int>(pixel) / columns_; }

  /// One ray into each stratum of those that the tile was split into.
  /// @param first number of the first of them among the pixel's rays
  void send(std::size_t pixel, int first, double weight) {
    sampler_.rays(x_of(pixel), y_of(pixel), parts_.of(pixel), first, rays_);
    for (std::size_t part = parts_.first[pixel]; part < parts_.first[pixel + 1]; ++part) {
      const double area = parts_.strata[part].area();
      sent_.push_back({pixel, area, weight * area, 0, part, std::max(1, sampler_.share(area * effort_).paths)});
    }
  }

  /// Traces what was sent since the last time, rays of equal share together.
  void trace() {
    std::vector<double> shares;
    for (std::size_t r = traced_; r < sent_.size(); ++r) shares.push_back(sent_[r].share);
    std::ranges::sort(shares);
    shares.erase(std::unique(shares.begin(), shares.end(), [](double a, double b) { return b - a < 1e-9 * a; }),
                 shares.end());
    std::vector<Ray> together;
    std::vector<std::uint64_t> histories;
    for (const double share : shares) {
      together.clear();
      histories.clear();
      for (std::size_t r = traced_; r < sent_.size(); ++r) {
        if (!rays_[r].ray || std::abs(sent_[r].share - share) > 1e-9 * share) continue;
        sent_[r].sample = samples_.size() + together.size();
        together.push_back(*rays_[r].ray);
        histories.push_back(rays_[r].history);
      }
      const std::size_t begin = samples_.size();
      samples_.resize(begin + together.size(), RaySample(bands_));
      counts += trace_bands(world_, estimator_, sampler_.share(share * effort_), together, histories,
                            std::span(samples_).subspan(begin));
    }
    if (refiner_) {
      for (std::size_t r = traced_; r < sent_.size(); ++r) level(r);
    }
    traced_ = sent_.size();
  }

  /// Takes the ramp of its part from a ray.
  void level(std::size_t r) {
    if (!rays_[r].ray) return;
    const Stratum& part = parts_.strata[sent_[r].part];
    const double x = (rays_[r].px - x_of(sent_[r].pixel) - part.x_min) / part.width - 0.5;
    const double y = (rays_[r].py - y_of(sent_[r].pixel) - part.y_min) / part.height - 0.5;
    for (std::size_t b = 0; b < static_cast<std::size_t>(bands_); ++b) {
      BandSample& sample = samples_[sent_[r].sample].bands[b];
      const Ramp& ramp = parts_.ramps[sent_[r].part * static_cast<std::size_t>(bands_) + b];
      sample.direct -= ramp.radiance(x, y);
      sample.transmission -= ramp.transmission(x, y);
    }
  }

  void add(PixelSum& sum, std::size_t r) {
    const Sent& sent = sent_[r];
    const auto bands = static_cast<std::size_t>(bands_);
    for (std::size_t b = 0; b < bands; ++b)
      foreseen_[b] = refiner_ ? parts_.ramps[sent.part * bands + b].mean : std::numeric_limits<double>::quiet_NaN();
    sum.add(rays_[r].ray ? samples_[sent.sample] : nothing_,
            {parts_.strata[sent.part], sent.weight, sent.paths, parts_.complex[sent.part] != 0, foreseen_});
  }

  /// Every pixel in two halves. Each asks for as many rays as the error of the other says, so that no half's
  /// number of rays knows its own values: both are unbiased, and so is their mean.
  void by_halves();

  /// The rays of each pixel, summed part by part: neighbours follow one another.
  void put() {
    std::vector<std::vector<std::size_t>> of(pixels_);
    for (std::size_t r = 0; r < sent_.size(); ++r) of[sent_[r].pixel].push_back(r);
    PixelSum sum(bands_);
    for (std::size_t p = 0; p < pixels_; ++p) {
      std::ranges::stable_sort(of[p], {}, [this](std::size_t r) { return sent_[r].part; });
      sum.reset();
      for (const std::size_t r : of[p]) add(sum, r);
      tile_.put(x_of(p), y_of(p), sum, object_at(world_, sampler_.centre(x_of(p), y_of(p))), parts_.criterion[p]);
    }
  }

  void add_spread(PixelSum& sum, std::size_t pixel, std::size_t ray) const {
    for (int b = 0; b < bands_; ++b) {
      const PixelBand band = sum.band(b);
      sum.set_spread(
          b, refiner_->spread(
                 x_of(pixel), y_of(pixel), b, rays_[ray].px, rays_[ray].py, band.radiance, band.variance,
                 parts_.ramps[sent_[ray].part * static_cast<std::size_t>(bands_) + static_cast<std::size_t>(b)]));
    }
  }

  const World& world_;
  const RadianceEstimator& estimator_;
  const Sampler& sampler_;
  const Refiner* refiner_;
  FilmTile tile_;
  int columns_;
  std::size_t pixels_;
  int bands_;
  RaySample nothing_{bands_};
  std::vector<double> foreseen_ = std::vector<double>(static_cast<std::size_t>(bands_));
  TileStrata parts_;
  double effort_ = 1;  // of a stratum's samples that each ray gets
  std::vector<PixelRay> rays_;
  std::vector<Sent> sent_;  // one for each ray
  std::size_t traced_ = 0;
  std::vector<RaySample> samples_;
};

void TilePass::by_halves() {
  effort_ = 0.5;
  const AdaptiveSettings& settings = *sampler_.settings().adaptive;
  for (std::size_t p = 0; p < pixels_; ++p) {
    for (int half = 0; half < 2; ++half) send(p, half * static_cast<int>(parts_.of(p).size()), 0.5);
  }
  rays.asked[static_cast<std::size_t>(Criterion::error)] += parts_.strata.size();
  trace();

  // What each half knows of itself: radiance and variance.
  struct Known {
    double radiance, variance;
  };
  std::array<std::vector<Known>, 2> known;
  PixelSum sum(bands_);
  std::size_t r = 0;
  for (std::size_t p = 0; p < pixels_; ++p) {
    for (std::vector<Known>& half : known) {
      sum.reset();
      const std::size_t first = r;
      for (std::size_t k = 0; k < parts_.of(p).size(); ++k, ++r) add(sum, r);
      if (parts_.of(p).size() == 1) add_spread(sum, p, first);
      for (int b = 0; b < bands_; ++b) half.push_back({sum.band(b).radiance, sum.band(b).variance});
    }
  }

  // A half's few rays know their error badly: pixels of the tile lend it to their neighbours.
  const int rows = static_cast<int>(pixels_) / columns_;
  const auto wanted = [&](const std::vector<Known>& half, std::size_t pixel) {
    const int x0 = static_cast<int>(pixel) % columns_, y0 = static_cast<int>(pixel) / columns_;
    double times = 1;
    for (int b = 0; b < bands_; ++b) {
      const double variance = detail::pooled(
          x0, y0, columns_, rows, [](int, int) { return true; },
          [&](int x, int y) { return half[static_cast<std::size_t>((y * columns_ + x) * bands_ + b)].variance; });
      const double scale =
          std::max(std::abs(half[pixel * static_cast<std::size_t>(bands_) + static_cast<std::size_t>(b)].radiance),
                   refiner_->dark(b));
      const double target = *settings.error * scale;
      if (target > 0) times = std::max(times, 0.5 * variance / (target * target));
    }
    return times;
  };

  const std::size_t before = sent_.size();
  std::vector<std::array<int, 2>> repeats(pixels_);
  for (std::size_t p = 0; p < pixels_; ++p) {
    const int parts = static_cast<int>(parts_.of(p).size());
    const int most = sampler_.settings().max_oversampling / (2 * parts);
    int number = 2 * parts;
    for (std::size_t half = 0; half < 2; ++half) {
      repeats[p][half] = static_cast<int>(
          std::clamp(std::ceil(wanted(known[1 - half], p)), 1.0, std::max(1.0, static_cast<double>(most))));
      for (int k = 1; k < repeats[p][half]; ++k, number += parts) send(p, number, 0.5);
    }
    if (number > 2 * parts && number - 2 * parts >= static_cast<int>(parts)) parts_.criterion[p] = Criterion::error;
  }
  rays.asked[static_cast<std::size_t>(Criterion::error)] += sent_.size() - before;
  trace();

  // Halves weigh the same, whatever the number of their rays.
  std::size_t first = 0, more = before;
  for (std::size_t p = 0; p < pixels_; ++p) {
    const std::size_t parts = parts_.of(p).size();
    for (std::size_t half = 0; half < 2; ++half) {
      const double share = 1.0 / repeats[p][half];
      for (std::size_t k = 0; k < parts; ++k) sent_[first++].weight *= share;
      for (std::size_t k = 0; k < parts * static_cast<std::size_t>(repeats[p][half] - 1); ++k)
        sent_[more++].weight *= share;
    }
  }
}

}  // namespace

void Rendered::merge(const Rendered& other) {
  film.merge(other.film);
  counts += other.counts;
  rays += other.rays;
}

Rendered render(const World& world, const RadianceEstimator& estimator, const Camera& camera,
                const SamplerSettings& sampling, const Progress& progress) {
  Film film({{camera.columns(), camera.rows()}, static_cast<int>(world.bands().size())});
  const Sampler sampler(camera, sampling);
  std::optional<Refiner> refiner;
  if (sampling.adaptive && sampling.max_oversampling > 1) refiner.emplace(world, estimator, sampler, progress);
  std::vector<RadianceCounts> counts(static_cast<std::size_t>(film.tile_count()));
  std::vector<RayCounts> rays(counts.size());
  std::atomic<std::uint64_t> done{0};
  std::vector<int> tiles = sampling.tiles;
  if (tiles.empty()) {
    tiles.resize(static_cast<std::size_t>(film.tile_count()));
    std::iota(tiles.begin(), tiles.end(), 0);
  }
  tbb::parallel_for(std::size_t{0}, tiles.size(), [&](std::size_t i) {
    if (progress.cancelled()) return;
    const int index = tiles[i];
    TilePass pass(world, estimator, sampler, refiner ? &*refiner : nullptr, film.tile(index));
    film.put(pass.run());
    counts[static_cast<std::size_t>(index)] = pass.counts;
    rays[static_cast<std::size_t>(index)] = pass.rays;
    progress.report("image", ++done, tiles.size());
  });
  film.pool_errors();
  Rendered result{std::move(film), {}, {}};
  if (refiner) {
    result.counts += refiner->counts();
    result.rays += refiner->rays();
  }
  for (const RadianceCounts& tile : counts) result.counts += tile;
  for (const RayCounts& tile : rays) result.rays += tile;
  return result;
}

}  // namespace obscura
