// Where the picture is complex: which parts of a pixel get a ray of their own. Pixels are split in four, and
// their parts again, wherever the spot holds more than its thresholds allow. What decides is never averaged:
// all geometry in the spot, and rays at the corners of the parts, which stand at places of their own.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "octree/base/progress.h"
#include "sensor/capture/corner_rays.h"
#include "sensor/capture/film.h"
#include "sensor/capture/strata.h"

namespace obscura {

class Refiner {
 public:
  /// Traces the rays at the corners of the pixels of all tiles to be done. Keeps references to all that it is given.
  Refiner(const World& world, const RadianceEstimator& estimator, const Sampler& sampler, const Progress& progress);

  /// Columns, rows as the tile's. Thread-safe.
  TileStrata split(const FilmTile& tile) const;

  /// Expected squared distance of a lone ray from its pixel's mean: the part of the picture's slope that the ramp
  /// leaves, and what neither the corners nor known noise explain of the ray's radiance.
  /// @param px, py place of the ray on the image; radiance without the ramp; variance as the ray knows it
  double spread(int x, int y, int band, double px, double py, double radiance, double variance,
                const Ramp& ramp) const noexcept;

  /// A radiance that counts as dark, of each band: relative thresholds are relative to at least this.
  double dark(int band) const noexcept { return dark_[static_cast<std::size_t>(band)]; }

  RayCounts rays() const noexcept { return rays_; }
  const RadianceCounts& counts() const noexcept { return counts_; }

 private:
  struct Cell;
  using Corners = std::array<const float*, 4>;  // top left, top right, bottom left, bottom right

  /// Marks the corners of the tiles to be done.
  void find_wanted(const Film& film);
  bool wanted(int x, int y) const noexcept {
    return wanted_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_ + 1) + static_cast<std::size_t>(x)];
  }
  /// Averages the noise of corners over neighbours: the few paths of one corner tell it badly.
  void pool_noise();
  /// Whether corner rays can ask to split a part of this level.
  bool rays_decide(int level) const noexcept;
  Criterion by_rays(const Corners& corners, int level) const noexcept;
  Ramp ramp(const Corners& corners, int band) const noexcept;
  const float* grid(int x, int y) const noexcept {
    return grid_.data() +
           (static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_ + 1) + static_cast<std::size_t>(x)) *
               corners_.stride();
  }
  /// Sends rays to the corners of parts where the geometry has not asked: sets what they ask for, and the parts' ramps.
  void decide_by_rays(std::span<const Cell> cells, int level, const FilmTile& tile, std::vector<Criterion>& asks,
                      std::vector<Ramp>& ramps, TileStrata& result) const;
  Corners corners_of(int x, int y) const noexcept {
    return {grid(x, y), grid(x + 1, y), grid(x, y + 1), grid(x + 1, y + 1)};
  }
  /// Whether the rays at a pixel's own corners ask: only then do those at corners of its parts.
  bool asks_by_rays(const FilmTile& tile, std::size_t pixel) const noexcept;

  const World* world_;
  const Sampler* sampler_;
  const AdaptiveSettings* settings_;
  CornerRays corners_;
  int columns_, rows_of_pixels_;
  int most_;          // parts of a pixel
  bool rays_decide_;  // something that rays can tell varies in this World
  std::vector<char> wanted_;
  std::vector<float> grid_;
  std::vector<double> dark_;
  RayCounts rays_;
  RadianceCounts counts_;
};

}  // namespace obscura
