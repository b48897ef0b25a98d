// The film: what the rays brought home, pixel by pixel, with an honest error. Work comes in tiles:
// each is filled by one thread in pixel order and put back whole, so that no order of threads shows.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "photon/spot/spot.h"
#include "sensor/capture/pixel_sum.h"

namespace obscura {

struct FilmSettings {
  /// Columns and rows.
  std::array<int, 2> resolution{1, 1};
  int bands = 1;
};

/// Mean of an image's radiance over the pixels that are done.
struct ImageMean {
  double mean = 0;
  /// From the scatter of `batch` and the pixels' own rays.
  double standard_error = 0;
  /// The mean as each batch alone would have it.
  std::array<double, kBatches> batch{};
};

/// A rectangle of pixels in work.
class FilmTile {
 public:
  int x_begin() const noexcept { return x_; }
  int x_end() const noexcept { return x_ + columns_; }
  int y_begin() const noexcept { return y_; }
  int y_end() const noexcept { return y_ + rows_; }

  /// Sets a pixel that is done. Call it row by row from the top left, since sums are made in this order.
  /// @param object_id 1-based, at the pixel's centre; 0 none.
  /// @param criterion that has asked for most of the pixel's rays
  void put(int x, int y, const PixelSum& pixel, std::uint32_t object_id, Criterion criterion = Criterion::none);

 private:
  friend class Film;
  struct Totals {
    double ray_variance = 0;
    std::array<double, kBatches> batch{};
  };

  void put_scatter(std::size_t place, int band, const PixelSum& pixel, const PixelBand& values);

  int index_ = 0;
  int x_ = 0, y_ = 0, columns_ = 0, rows_ = 0;
  int done_ = 0;
  std::uint64_t rays_ = 0;
  std::uint64_t anomalies_ = 0;
  std::vector<float> values_;   // [channel][row][column]
  std::vector<float> scatter_;  // the same, see Film::ScatterPlane
  std::vector<Totals> totals_;  // per band
};

class Film {
 public:
  /// Side of a tile in pixels.
  static constexpr int kTileSide = 16;

  /// The values of a band that the film keeps for each pixel.
  enum class Value { radiance, error, bias, transmission, transmission_atmosphere };
  static constexpr int kBandValues = 5;
  /// Radiances nearer to 0 are 0 and have this error, so that 0 with error 0 means that nothing is there: float32's
  /// least normal number.
  static constexpr float kLeast = std::numeric_limits<float>::min();

  explicit Film(const FilmSettings& settings);

  int columns() const noexcept { return settings_.resolution[0]; }
  int rows() const noexcept { return settings_.resolution[1]; }
  int bands() const noexcept { return settings_.bands; }

  int tile_count() const noexcept { return tile_columns_ * tile_rows_; }
  /// Column and row of a tile's upper left pixel, its columns and rows.
  std::array<int, 4> tile_box(int index) const noexcept;
  /// An empty tile to work on; any thread.
  FilmTile tile(int index) const;
  /// Puts a tile back. @pre it has all its pixels. Different tiles may be put by different threads at once; a tile that
  /// is never put stays undone.
  void put(FilmTile&& tile);

  /// Sets the error of each pixel from what it and its neighbours know of their rays' scatter, and its bias to the
  /// weighted mean over both: a pixel's own few rays are skewed, and those that miss what is bright claim too small an
  /// error with too small a mean (sensor/METHODS.md, "The error of a pixel"). Call it once, when all tiles are there;
  /// until then a pixel has the error that it knows by itself.
  void pool_errors();

  /// Adds an independent pass over the same image (its own seed, its own map): means are weighted by
  /// passes, errors add in squares, depth is the nearer, the object is this film's.
  void merge(const Film& other);

  /// Passes that a pixel has: 0 is one never done, whose values are 0, depth infinite.
  int passes(int x, int y) const noexcept;
  std::uint64_t pixels_done() const noexcept;
  bool partial() const noexcept;

  /// Rays that count, and values that were not finite or did not fit float32 (none in the image).
  std::uint64_t rays() const noexcept;
  std::uint64_t anomalies() const noexcept;

  /// Pixels that are darker than float32 holds, though not black.
  std::uint64_t too_dark(int band) const noexcept;

  /// One value of every pixel, row by row from the top left. Never NaN, and finite but for depth.
  std::span<const float> values(int band, Value value) const noexcept;
  std::span<const float> depth_m() const noexcept;
  std::span<const float> object_id() const noexcept;
  std::span<const float> ray_count() const noexcept;
  /// Criterion as a number.
  std::span<const float> criterion() const noexcept;

  /// Summed in tile order: the same bits for any number of threads.
  ImageMean mean(int band) const;
  /// The same over the pixels of one tile.
  ImageMean mean_of_tile(int tile, int band) const;

 private:
  struct TileState {
    int passes = 0;
    int pixels = 0;
    std::uint64_t rays = 0;
    std::uint64_t anomalies = 0;
  };

  /// What is kept of each pixel until pool_errors(): first of each band (roots, so that float32 holds them), then of
  /// all. Of a pixel with one ray, which has no scatter, the first two are the ray's.
  enum ScatterPlane { kSmooth, kComplex, kCountedTwice, kMap, kBandPlanes };
  enum RayPlane { kForeseen = kSmooth, kOwn = kComplex };
  enum CommonPlane { kKnownSmooth, kKnownComplex, kWeightSmooth, kWeightComplex, kCommonPlanes };
  friend class ErrorPool;
  friend class FilmTile;
  int scatter_channels() const noexcept { return kBandPlanes * bands() + kCommonPlanes; }

  std::size_t pixel_count() const noexcept {
    return static_cast<std::size_t>(columns()) * static_cast<std::size_t>(rows());
  }
  std::span<float> plane(int channel) noexcept;
  std::span<const float> plane(int channel) const noexcept;
  ImageMean mean_over(int first_tile, int tile_end, int band) const;

  FilmSettings settings_;
  int tile_columns_;
  int tile_rows_;
  std::vector<float> values_;   // [channel][row][column]; bands, then depth, object, rays, criterion
  std::vector<float> scatter_;  // the same, see ScatterPlane; empty once errors are pooled
  std::vector<TileState> tiles_;
  std::vector<FilmTile::Totals> totals_;  // [tile][band]
};

}  // namespace obscura
