// The film: what the rays brought home, pixel by pixel, with an honest error. Work comes in tiles:
// each is filled by one thread in pixel order and put back whole, so that no order of threads shows.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "photon/spot/spot.h"
#include "sensor/capture/sample.h"

namespace obscura {

struct FilmSettings {
  /// Columns and rows.
  std::array<int, 2> resolution{1, 1};
  int bands = 1;
};

/// The developed values of one pixel in one band.
struct PixelBand {
  double radiance = 0;
  /// Standard error of `radiance`, squared: batches and rays (sensor/METHODS.md, "The error of a pixel").
  double variance = 0;
  /// The share of `variance` that is the pixel's own: its rays, not the map that pixels share.
  double ray_variance = 0;
  double bias = 0;
  double transmission = 0;
  double transmission_atmosphere = 0;
  /// The radiance as each batch alone would have it.
  std::array<double, kBatches> batch{};
};

/// Adds up the rays of one pixel. Reuse it: it allocates only when made.
class PixelSum {
 public:
  explicit PixelSum(int bands) : bands_(static_cast<std::size_t>(bands)) {}

  void reset() noexcept;
  /// A ray with a value that is not finite (depth may be infinite) is left out and counted.
  /// @param weight the share of the pixel that the ray stands for, above 0; only ratios matter
  void add(const RaySample& ray, double weight = 1) noexcept;
  /// Expected squared distance of one ray's radiance from the pixel's mean, as its corners tell. It counts only where
  /// the pixel has one ray, which has no scatter of its own.
  void set_spread(int band, double variance) noexcept { bands_[static_cast<std::size_t>(band)].spread = variance; }

  /// Rays that count.
  std::uint32_t rays() const noexcept { return rays_; }
  std::uint32_t anomalies() const noexcept { return anomalies_; }
  double depth_m() const noexcept { return depth_m_; }
  PixelBand band(int index) const noexcept;

 private:
  struct Sums {
    double radiance = 0;  // running mean; all sums are weighted
    double last = 0;      // of the ray before
    double before_last = 0;
    double step2 = 0;      // squared difference of the first two rays
    double bends2 = 0;     // squared second differences of successive rays, by the middle one's squared weight
    double ray_noise = 0;  // the batches' variance of the mean
    double bias = 0;
    double variance = 0;  // of the rays' own points
    double spread = 0;    // see set_spread()
    double transmission = 0;
    double transmission_atmosphere = 0;
    double direct = 0;
    std::array<double, kBatches> map{};
  };

  std::vector<Sums> bands_;
  double weight_ = 0;   // sum over rays
  double weight2_ = 0;  // of their squares
  double last_weight_ = 0;
  double middle_weight2_ = 0;  // of the squares, over rays with a ray before and behind
  std::uint32_t rays_ = 0;
  std::uint32_t anomalies_ = 0;
  double depth_m_ = kInfinity;
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

  int index_ = 0;
  int x_ = 0, y_ = 0, columns_ = 0, rows_ = 0;
  int done_ = 0;
  std::uint64_t rays_ = 0;
  std::uint64_t anomalies_ = 0;
  std::vector<float> values_;   // [channel][row][column]
  std::vector<Totals> totals_;  // per band
};

class Film {
 public:
  /// Side of a tile in pixels.
  static constexpr int kTileSide = 16;

  /// The values of a band that the film keeps for each pixel.
  enum class Value { radiance, error, bias, transmission, transmission_atmosphere };
  static constexpr int kBandValues = 5;

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

  /// Replaces error (in squares) and bias of each pixel by the weighted mean over it and its neighbours: a pixel's own
  /// few rays are skewed, and those that miss what is bright claim too small an error with too small a mean
  /// (sensor/METHODS.md, "The error of a pixel"). Pixels that see no cloud neither give nor take. Call it once, when
  /// all tiles are there.
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

  std::size_t pixel_count() const noexcept {
    return static_cast<std::size_t>(columns()) * static_cast<std::size_t>(rows());
  }
  std::span<float> plane(int channel) noexcept;
  std::span<const float> plane(int channel) const noexcept;
  ImageMean mean_over(int first_tile, int tile_end, int band) const;

  FilmSettings settings_;
  int tile_columns_;
  int tile_rows_;
  std::vector<float> values_;  // [channel][row][column]; bands, then depth, object, rays, criterion
  std::vector<TileState> tiles_;
  std::vector<FilmTile::Totals> totals_;  // [tile][band]
};

}  // namespace obscura
