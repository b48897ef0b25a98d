// The rays of one pixel, added up, and what they tell of their own scatter.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "octree/base/math.h"
#include "sensor/capture/sample.h"
#include "sensor/capture/stratum.h"

namespace obscura {

/// What a ray stands for: a part of its pixel.
struct RayPart {
  /// Its rectangle, in sides of the pixel; none: parts are taken to lie in a row.
  std::optional<Stratum> place = std::nullopt;
  /// Share of the pixel, above 0; only ratios matter.
  double weight = 1;
  /// That the ray has drawn: its noise falls as their number grows.
  int paths = 1;
  /// Edges, or what else would have split the part, are still in it: its rays scatter by them, others do not.
  bool complex = false;
  /// Radiance that corners foretell, of each band (NaN: they do not); empty: of none. What they foretell of a trend
  /// from part to part is no scatter.
  std::span<const double> foreseen = {};
};

/// How rays of a kind of part scatter: the variance of one of n rays is about square / known * (1 / paths).
struct Scatter {
  double square = 0;  ///< seen, (W/m2/sr)^2, over rays whose neighbours tell
  double known = 0;   ///< sum of weight^2 / paths over these
  double weight = 0;  ///< the same sum over all rays of the kind; weights of a pixel add up to 1

  /// Of the pixel's mean, from these rays.
  double variance() const noexcept { return known > 0 ? weight * square / known : 0.0; }
};

/// The developed values of one pixel in one band.
struct PixelBand {
  double radiance = 0;
  /// Standard error of `radiance`, squared, as the pixel alone knows it: batches and rays (sensor/METHODS.md, "The
  /// error of a pixel").
  double variance = 0;
  /// Its two parts: of the map, which pixels share, and of the pixel's own rays.
  double map_variance = 0, ray_variance = 0;
  /// The part of the rays' scatter that the batches hold already.
  double counted_twice = 0;
  /// Scatter of rays in smooth parts and in complex ones.
  Scatter smooth, complex;
  double bias = 0;
  double transmission = 0;
  double transmission_atmosphere = 0;
  /// The radiance as each batch alone would have it.
  std::array<double, kBatches> batch{};
};

/// The variance of the mean of the batches, from their scatter.
double variance_of_mean(const std::array<double, kBatches>& batch, double mean) noexcept;
double mean_of(const std::array<double, kBatches>& batch) noexcept;

/// A ray's radiance, and what its corners foretold of it (NaN: nothing).
struct RayLight {
  double radiance = 0;
  double foreseen = std::numeric_limits<double>::quiet_NaN();
};

/// Second difference of three neighbours in a row: of independent values it has six times the variance of one, of a
/// slope it is 0.
double bend(const RayLight& before, const RayLight& middle, const RayLight& after) noexcept;
/// a - b + c - d of four neighbours around a corner: four times the variance, and 0 for any slope.
double twist(const RayLight& a, const RayLight& b, const RayLight& c, const RayLight& d) noexcept;

/// Adds up the rays of one pixel. Reuse it: it allocates only when made.
class PixelSum {
 public:
  explicit PixelSum(int bands) : bands_(static_cast<std::size_t>(bands)) {}

  void reset() noexcept;
  /// A ray with a value that is not finite (depth may be infinite) is left out and counted. Rays of neighbouring parts
  /// follow one another.
  void add(const RaySample& ray, const RayPart& part = {}) noexcept;
  /// Expected squared distance of one ray's radiance from the pixel's mean, as its corners tell. It counts only where
  /// the pixel has one ray, which has no scatter of its own.
  void set_spread(int band, double variance) noexcept { bands_[static_cast<std::size_t>(band)].spread = variance; }

  /// Rays that count.
  std::uint32_t rays() const noexcept { return rays_; }
  std::uint32_t anomalies() const noexcept { return anomalies_; }
  double depth_m() const noexcept { return depth_m_; }
  /// What the corners foretold of the pixel's only ray; NaN where they did not.
  double foreseen(int band) const noexcept { return bands_[static_cast<std::size_t>(band)].last[0].foreseen; }
  PixelBand band(int index) const noexcept;

 private:
  struct Sums {
    double radiance = 0;              // running mean; all sums are weighted
    std::array<RayLight, 4> last;     // the latest first
    std::array<double, 2> squares{};  // of smooth and complex parts
    double ray_noise = 0;             // the batches' variance of the mean
    double bias = 0;
    double variance = 0;  // of the rays' own points
    double spread = 0;    // see set_spread()
    double transmission = 0;
    double transmission_atmosphere = 0;
    double direct = 0;
    std::array<double, kBatches> map{};
  };
  struct Sent {
    std::optional<Stratum> place;
    double weight = 0, noise = 0;  // 1 / paths
    bool complex = false;
  };
  /// How the latest rays lie, and so which of their differences is scatter.
  enum class Group { none, same, row, square };
  Group group() const noexcept;
  /// Where no group tells, as of two rays: differences of successive ones, slopes and all.
  void ask_pairs(const Sums& sums, Scatter& smooth, Scatter& complex) const noexcept;

  std::vector<Sums> bands_;
  double weight_ = 0;                          // sum over rays
  double weight2_ = 0;                         // of their squares
  std::array<Sent, 4> last_;                   // the latest first
  std::array<double, 2> known_{}, weights_{};  // see Scatter; of smooth and complex parts
  std::uint32_t rays_ = 0;
  std::uint32_t anomalies_ = 0;
  double depth_m_ = kInfinity;
};

}  // namespace obscura
