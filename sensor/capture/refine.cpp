#include "sensor/capture/refine.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "octree/base/error_scale.h"
#include "photon/world/spectral_world.h"
#include "sensor/capture/pool.h"

namespace obscura {
namespace {

/// The range of four normal numbers is below this many standard deviations 19 times of 20.
constexpr double kNoiseRange = 3.63;
/// Slopes are believed beyond this many times the square that noise alone makes, 19 times of 20.
constexpr double kNoiseSlope = 3;
/// Corners whose noise is below this share of their slope's square foretell what is between them.
constexpr double kForetold = 1.0 / 30;
/// Share of the corners that may outshine the bright end.
constexpr double kGlints = 1e-3;

int levels_of(int most) noexcept {
  int levels = 0;
  for (; most >= 4; most /= 4) ++levels;
  return levels;
}

/// Place of a cell of the finest grid along Hilbert's curve, which goes through squares one by one: the cells of a
/// quadtree in this order touch.
std::uint64_t hilbert(int levels, std::uint32_t x, std::uint32_t y) noexcept {
  std::uint64_t place = 0;
  for (std::uint32_t half = levels > 0 ? 1u << (levels - 1) : 0; half > 0; half /= 2) {
    const bool right = x & half, below = y & half;
    place = 4 * place + ((right ? 3u : 0u) ^ (below ? 1u : 0u));
    if (!below) {
      if (right) {
        x = ~x;
        y = ~y;
      }
      std::swap(x, y);
    }
  }
  return place;
}

/// Parts along an edge through a pixel, of sides 2^-level, are 2^level; each errs by its area, and together, by chance,
/// by 2^(-1.5 level) of what the pixel would: thresholds of the parts grow by as much.
double tolerance(int level) noexcept { return std::exp2(1.5 * level); }

/// From corners in the order of Refiner::Corners.
Slope slope_of(double c0, double c1, double c2, double c3) noexcept {
  return {0.5 * (c1 + c3 - c0 - c2), 0.5 * (c2 + c3 - c0 - c1), c0 + c3 - c1 - c2};
}
Slope operator*(double share, const Slope& slope) noexcept {
  return {share * slope.across, share * slope.down, share * slope.twist};
}

double largest(std::initializer_list<double> values) { return std::max(values); }
double range(std::initializer_list<double> values) { return std::max(values) - std::min(values); }

}  // namespace

/// A square part of a pixel.
struct Refiner::Cell {
  std::size_t pixel;                  // of the tile
  std::uint32_t x, y;                 // within the pixel, in its own side lengths
  Criterion whole = Criterion::none;  // what has split the part that it is a quarter of
};

Refiner::Refiner(const World& world, const RadianceEstimator& estimator, const Sampler& sampler,
                 const Progress& progress)
    : world_(&world),
      sampler_(&sampler),
      settings_(&*sampler.settings().adaptive),
      // Where the error may ask for more, every part has a ray in either half.
      corners_(world, estimator, sampler, levels_of(sampler.settings().max_oversampling / (settings_->error ? 2 : 1))),
      columns_(sampler.camera().columns()),
      rows_of_pixels_(sampler.camera().rows()),
      most_(std::max(1, sampler.settings().max_oversampling / (settings_->error ? 2 : 1))) {
  rays_decide_ = world.cloud_count() > 0 && (settings_->transmission || settings_->radiance);
  for (int i = 0; i < world.interval_count(); ++i) {
    rays_decide_ =
        rays_decide_ || (SpectralWorld(world, i).surfaces_reflect() && (settings_->radiance || settings_->shadow));
  }

  find_wanted(Film({{columns_, rows_of_pixels_}, 1}));
  grid_.resize(wanted_.size() * corners_.stride());
  const std::size_t row_length = static_cast<std::size_t>(columns_ + 1) * corners_.stride();
  std::vector<RadianceCounts> counts(static_cast<std::size_t>(rows_of_pixels_ + 1));
  std::atomic<std::uint64_t> done{0};
  tbb::parallel_for(0, rows_of_pixels_ + 1, [&](int y) {
    if (progress.cancelled()) return;
    std::vector<CornerRays::Corner> corners;
    for (int x = 0; x <= columns_; ++x) {
      if (!wanted(x, y)) continue;
      corners.push_back(
          {static_cast<std::uint32_t>(x) << corners_.levels(), static_cast<std::uint32_t>(y) << corners_.levels()});
    }
    std::vector<float> values(corners.size() * corners_.stride());
    counts[static_cast<std::size_t>(y)] = corners_.trace(corners, values);
    auto value = values.cbegin();
    for (int x = 0; x <= columns_; ++x) {
      if (!wanted(x, y)) continue;
      std::copy_n(value, corners_.stride(),
                  grid_.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(y) * row_length +
                                                              static_cast<std::size_t>(x) * corners_.stride()));
      value += static_cast<std::ptrdiff_t>(corners_.stride());
    }
    progress.report("base rays", ++done, static_cast<std::uint64_t>(rows_of_pixels_ + 1));
  });
  for (const RadianceCounts& row : counts) counts_ += row;
  rays_.deciding = static_cast<std::uint64_t>(std::count(wanted_.begin(), wanted_.end(), 1));

  pool_noise();

  std::vector<float> bright;
  for (int b = 0; b < corners_.bands(); ++b) {
    bright.clear();
    for (std::size_t i = 0; i < wanted_.size(); ++i) {
      if (wanted_[i]) bright.push_back(std::abs(grid_[i * corners_.stride() + static_cast<std::size_t>(2 + 3 * b)]));
    }
    const auto end = bright.end() - 1 - static_cast<std::ptrdiff_t>(kGlints * static_cast<double>(bright.size()));
    std::nth_element(bright.begin(), end, bright.end());
    dark_.push_back(kDarkShare * *end);
  }
}

void Refiner::find_wanted(const Film& film) {
  const std::vector<int>& tiles = sampler_->settings().tiles;
  wanted_.assign(static_cast<std::size_t>(columns_ + 1) * static_cast<std::size_t>(rows_of_pixels_ + 1), tiles.empty());
  for (const int tile : tiles) {
    const auto [x0, y0, columns, rows] = film.tile_box(tile);
    for (int y = y0; y <= y0 + rows; ++y) {
      for (int x = x0; x <= x0 + columns; ++x) {
        wanted_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_ + 1) + static_cast<std::size_t>(x)] = 1;
      }
    }
  }
}

void Refiner::pool_noise() {
  std::vector<float> own(static_cast<std::size_t>(columns_ + 1) * static_cast<std::size_t>(rows_of_pixels_ + 1));
  for (int b = 0; b < corners_.bands(); ++b) {
    const std::size_t k = 3 + 3 * static_cast<std::size_t>(b);
    for (std::size_t i = 0; i < own.size(); ++i) own[i] = grid_[i * corners_.stride() + k];
    tbb::parallel_for(0, rows_of_pixels_ + 1, [&](int y) {
      for (int x = 0; x <= columns_; ++x) {
        if (!wanted(x, y)) continue;
        grid_[static_cast<std::size_t>(y * (columns_ + 1) + x) * corners_.stride() + k] =
            static_cast<float>(detail::pooled(
                x, y, columns_ + 1, rows_of_pixels_ + 1, [&](int u, int v) { return wanted(u, v); },
                [&](int u, int v) { return own[static_cast<std::size_t>(v * (columns_ + 1) + u)]; }));
      }
    });
  }
}

bool Refiner::rays_decide(int level) const noexcept {
  // No share, and no range of what is not negative, exceeds 1.
  const auto can = [&](const std::optional<double>& threshold) {
    return threshold && *threshold * tolerance(level) < 1;
  };
  return rays_decide_ && (can(settings_->shadow) || can(settings_->transmission) || can(settings_->radiance));
}

Ramp Refiner::ramp(const Corners& c, int band) const noexcept {
  const std::size_t t = 1 + 3 * static_cast<std::size_t>(band), k = t + 1;
  Ramp ramp;
  const Slope slope = slope_of(c[0][k], c[1][k], c[2][k], c[3][k]);
  const double square = (slope.across * slope.across + slope.down * slope.down) / 12 + slope.twist * slope.twist / 144;
  const double noise = 7.0 / 36 * 0.25 * (double{c[0][k + 1]} + c[1][k + 1] + c[2][k + 1] + c[3][k + 1]);
  const double highest = 0.5 * (std::abs(slope.across) + std::abs(slope.down)) + 0.25 * std::abs(slope.twist);
  if (!(square > kNoiseSlope * noise) || !std::isfinite(square)) return {};
  if (noise < kForetold * square) ramp.mean = 0.25 * (double{c[0][k]} + c[1][k] + c[2][k] + c[3][k]);
  // No more than half of what is there, so that nothing becomes negative.
  const double least = std::min({c[0][k], c[1][k], c[2][k], c[3][k]});
  ramp.strength = std::clamp(std::min(1 - kNoiseSlope * noise / square, 0.5 * least / highest), 0.0, 1.0);
  ramp.radiance = ramp.strength * slope;
  ramp.transmission = ramp.strength * slope_of(c[0][t], c[1][t], c[2][t], c[3][t]);
  return ramp;
}

Criterion Refiner::by_rays(const Corners& c, int level) const noexcept {
  const double times = tolerance(level);
  const auto varies = [&](std::size_t k) { return range({c[0][k], c[1][k], c[2][k], c[3][k]}); };
  if (settings_->shadow && varies(0) > *settings_->shadow * times) return Criterion::shadow;
  for (int b = 0; b < corners_.bands(); ++b) {
    if (settings_->transmission && varies(1 + 3 * static_cast<std::size_t>(b)) > *settings_->transmission * times)
      return Criterion::transmission;
  }
  if (!settings_->radiance) return Criterion::none;
  for (int b = 0; b < corners_.bands(); ++b) {
    const std::size_t k = 2 + 3 * static_cast<std::size_t>(b);
    const double scale = largest({dark(b), std::abs(c[0][k]), std::abs(c[1][k]), std::abs(c[2][k]), std::abs(c[3][k])});
    const double variance = 0.25 * (double{c[0][k + 1]} + c[1][k + 1] + c[2][k + 1] + c[3][k + 1]);
    if (varies(k) > *settings_->radiance * times * scale + kNoiseRange * std::sqrt(variance))
      return Criterion::radiance;
  }
  return Criterion::none;
}

bool Refiner::asks_by_rays(const FilmTile& tile, std::size_t pixel) const noexcept {
  const int columns = tile.x_end() - tile.x_begin();
  return rays_decide_ && by_rays(corners_of(tile.x_begin() + static_cast<int>(pixel) % columns,
                                            tile.y_begin() + static_cast<int>(pixel) / columns),
                                 0) != Criterion::none;
}

void Refiner::decide_by_rays(std::span<const Cell> cells, int level, const FilmTile& tile, std::vector<Criterion>& asks,
                             std::vector<Ramp>& ramps, TileStrata& result) const {
  const int columns = tile.x_end() - tile.x_begin();
  const std::uint32_t side = 1u << (corners_.levels() - level);
  const auto corner = [&](const Cell& cell, int which) {
    const auto x = static_cast<std::uint32_t>(tile.x_begin() + static_cast<int>(cell.pixel) % columns);
    const auto y = static_cast<std::uint32_t>(tile.y_begin() + static_cast<int>(cell.pixel) / columns);
    return CornerRays::Corner{(x << corners_.levels()) + (cell.x + static_cast<std::uint32_t>(which % 2)) * side,
                              (y << corners_.levels()) + (cell.y + static_cast<std::uint32_t>(which / 2)) * side};
  };
  const std::uint32_t within = (1u << corners_.levels()) - 1;
  const auto on_grid = [&](const CornerRays::Corner& c) { return ((c.x | c.y) & within) == 0; };
  std::vector<CornerRays::Corner> wanted;
  std::vector<char> own(cells.size());  // is told by rays at its own corners
  for (std::size_t i = 0; i < cells.size(); ++i) {
    own[i] = asks[i] == Criterion::none && (level == 0 || (rays_decide(level) && asks_by_rays(tile, cells[i].pixel)));
    if (!own[i]) continue;
    for (int k = 0; k < 4; ++k) {
      if (const CornerRays::Corner c = corner(cells[i], k); !on_grid(c)) wanted.push_back(c);
    }
  }
  std::ranges::sort(wanted);
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  std::vector<float> values(wanted.size() * corners_.stride());
  result.counts += corners_.trace(wanted, values);
  result.rays.deciding += wanted.size();

  const auto bands = static_cast<std::size_t>(corners_.bands());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (!own[i]) continue;
    // Where a camera has no ray, a slope would be one into nothing.
    bool all = true;
    Corners corners;
    for (int k = 0; k < 4; ++k) {
      const CornerRays::Corner c = corner(cells[i], k);
      all = all && sampler_->camera().ray(std::ldexp(c.x, -corners_.levels()), std::ldexp(c.y, -corners_.levels()));
      const auto found = std::ranges::lower_bound(wanted, c);
      corners[static_cast<std::size_t>(k)] =
          on_grid(c) ? grid(static_cast<int>(c.x >> corners_.levels()), static_cast<int>(c.y >> corners_.levels()))
                     : &values[static_cast<std::size_t>(found - wanted.begin()) * corners_.stride()];
    }
    if (rays_decide_) asks[i] = by_rays(corners, level);
    if (!all) continue;
    for (std::size_t b = 0; b < bands; ++b) ramps[i * bands + b] = ramp(corners, static_cast<int>(b));
  }
}

TileStrata Refiner::split(const FilmTile& tile) const {
  TileStrata result;
  const int columns = tile.x_end() - tile.x_begin();
  const auto pixels = static_cast<std::size_t>(columns * (tile.y_end() - tile.y_begin()));
  result.rays.base = pixels;
  result.criterion.assign(pixels, Criterion::none);
  const auto bands = static_cast<std::size_t>(corners_.bands());

  struct Part {
    std::size_t pixel;
    std::uint64_t place;
    Stratum stratum;
    std::size_t ramp;  // of its first band
    bool complex;
  };
  std::vector<Part> parts;
  std::vector<Ramp> known(bands), ramps;  // the first is none
  std::vector<int> count(pixels, 1);
  std::vector<std::array<int, kCriteria>> asked(pixels);
  std::vector<Cell> cells, next;
  for (std::size_t p = 0; p < pixels; ++p) cells.push_back({p, 0, 0});

  // Below four there is no room for quarters: such pixels are shared out at once.
  const int levels = std::max(corners_.levels(), most_ > 1 ? 1 : 0);
  for (int level = 0; !cells.empty(); ++level) {
    const double side = std::ldexp(1.0, -level);
    std::vector<Criterion> asks(cells.size(), Criterion::none);
    ramps.assign(cells.size() * bands, {});
    // What lies at another distance is another polygon; a slope alone matters the less the smaller the part.
    SpotThresholds thresholds = settings_->geometry;
    if (thresholds.depth) *thresholds.depth *= tolerance(level);
    SpotQuery geometry(*world_, thresholds, settings_->specular_depth);
    const auto ask = [&](const Cell& cell) {
      const double x = tile.x_begin() + static_cast<int>(cell.pixel) % columns + cell.x * side;
      const double y = tile.y_begin() + static_cast<int>(cell.pixel) / columns + cell.y * side;
      const std::optional<Spot> spot = sampler_->camera().spot(x, y, x + side, y + side);
      return spot ? geometry(*spot) : Criterion::none;
    };
    if (level < levels) {
      for (std::size_t i = 0; i < cells.size(); ++i) asks[i] = ask(cells[i]);
      decide_by_rays(cells, level, tile, asks, ramps, result);
    }
    next.clear();
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const Cell& cell = cells[i];
      const int more = std::min(4, most_) - 1;
      if (asks[i] == Criterion::none || count[cell.pixel] + more > most_) {
        const std::uint32_t fine = 1u << std::max(0, corners_.levels() - level);
        // What has split the whole may be in any of its last quarters; only geometry tells in which.
        const bool by_geometry = cell.whole < Criterion::shadow;
        const bool complex = asks[i] != Criterion::none || (level == levels && cell.whole != Criterion::none &&
                                                            (!by_geometry || ask(cell) != Criterion::none));
        parts.push_back({cell.pixel,
                         hilbert(corners_.levels(), cell.x * fine, cell.y * fine),
                         {cell.x * side, cell.y * side, side, side},
                         asks[i] == Criterion::none ? known.size() : 0,
                         complex});
        if (asks[i] == Criterion::none) known.insert(known.end(), &ramps[i * bands], &ramps[i * bands] + bands);
        continue;
      }
      count[cell.pixel] += more;
      asked[cell.pixel][static_cast<std::size_t>(asks[i])] += more;
      if (more < 3) {
        for (int k = 0; k <= more; ++k)
          parts.push_back({cell.pixel, static_cast<std::uint64_t>(k), stratum(k, more + 1), 0, true});
      } else {
        for (std::uint32_t k = 0; k < 4; ++k)
          next.push_back({cell.pixel, 2 * cell.x + k % 2, 2 * cell.y + k / 2, asks[i]});
      }
    }
    cells.swap(next);
  }

  std::ranges::sort(
      parts, [](const Part& a, const Part& b) { return std::pair(a.pixel, a.place) < std::pair(b.pixel, b.place); });
  for (const Part& part : parts) {
    while (result.first.size() <= part.pixel) result.first.push_back(result.strata.size());
    result.strata.push_back(part.stratum);
    result.complex.push_back(part.complex);
    for (std::size_t b = 0; b < bands; ++b) result.ramps.push_back(known[part.ramp + b]);
  }
  result.first.push_back(result.strata.size());
  for (std::size_t p = 0; p < pixels; ++p) {
    const auto most = std::ranges::max_element(asked[p]);
    if (*most > 0) result.criterion[p] = static_cast<Criterion>(most - asked[p].begin());
    for (std::size_t c = 0; c < asked[p].size(); ++c) result.rays.asked[c] += static_cast<std::uint64_t>(asked[p][c]);
  }
  return result;
}

double Refiner::spread(int x, int y, int band, double px, double py, double radiance, double variance,
                       const Ramp& ramp) const noexcept {
  const std::size_t k = 2 + 3 * static_cast<std::size_t>(band);
  const Corners c = corners_of(x, y);
  const double u = px - x, v = py - y;
  const std::array<double, 4> share = {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
  double expected = -ramp.radiance(u - 0.5, v - 0.5), noise = 0, share2 = 0, mean_noise = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    expected += share[i] * c[i][k];
    noise += share[i] * share[i] * c[i][k + 1];
    share2 += share[i] * share[i];
    mean_noise += 0.25 * c[i][k + 1];
  }
  // The corners' own noise makes slopes of its own: as much as one corner's variance. The ramp takes its share of the
  // slope away and brings its share of that noise.
  const auto [across, down, twist] = slope_of(c[0][k], c[1][k], c[2][k], c[3][k]);
  const double left = (1 - ramp.strength) * (1 - ramp.strength);
  const double slope = left * std::max(0.0, across * across + down * down - 2 * mean_noise) / 12 +
                       ramp.strength * ramp.strength * 7.0 / 36 * mean_noise;
  const double stray = radiance - expected;
  return slope + std::max(0.0, stray * stray - variance - noise) / (1 + share2);
}

}  // namespace obscura
