// The errors of an image: what pixels tell of their rays' scatter, lent to their neighbours.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "sensor/capture/film.h"
#include "sensor/capture/pool.h"

namespace obscura {
namespace {

/// A window grows until its sum of squares is as sure as that of so many equal ones,
constexpr double kSure = 12;
/// from its least to its most pixels on either side.
constexpr int kLeastReach = 2, kMostReach = 8;
/// The open sky has no noise of its own: only wisps and ramps (refine.h) near by.
constexpr int kSkyReach = 4;
/// Differences below this share of the values are rounding to float32.
constexpr double kRounding = 3e-7;

}  // namespace

/// One band of a film at a time.
class ErrorPool {
 public:
  explicit ErrorPool(Film& film) : film_(film), columns_(film.columns()), rows_(film.rows()) {
    for (int k = 0; k < 2; ++k) {
      known_[k] = common(Film::kKnownSmooth + k);
      weight_[k] = common(Film::kWeightSmooth + k);
      square_[k].resize(film.pixel_count());
    }
  }

  void run(int band) {
    band_ = band;
    transmission_ = film_.values(band, Film::Value::transmission);
    radiance_ = film_.values(band, Film::Value::radiance);
    each_pixel([this](int x, int y) { lend(x, y); });

    std::vector<double> rays(film_.pixel_count());
    std::vector<float> error(film_.pixel_count()), bias(film_.pixel_count());
    const std::span<float> own_error = film_.plane(Film::kBandValues * band + static_cast<int>(Film::Value::error));
    const std::span<float> own_bias = film_.plane(Film::kBandValues * band + static_cast<int>(Film::Value::bias));
    each_pixel([&](int x, int y) {
      const std::size_t p = place(x, y);
      const auto mean = [&](auto&& value) {
        return detail::pooled(
            x, y, columns_, rows_, [&](int u, int v) { return alike(p, place(u, v)); },
            [&](int u, int v) { return value(place(u, v)); });
      };
      const double map = mean([&](std::size_t q) { return square(scatter(Film::kMap)[q]); });
      const double twice =
          lone(p) ? map : mean([&](std::size_t q) { return lone(q) ? 0.0 : square(scatter(Film::kCountedTwice)[q]); });
      rays[p] = std::max(0.0, scatter_of(x, y) - twice);
      const double all = std::sqrt(map + rays[p]);
      error[p] = all > 0 ? std::max(static_cast<float>(all), Film::kLeast) : 0.0f;
      if (radiance_[p] == 0 && own_error[p] == Film::kLeast) error[p] = std::max(error[p], Film::kLeast);
      bias[p] = static_cast<float>(mean([&](std::size_t q) { return own_bias[q]; }));
    });
    std::ranges::copy(error, own_error.begin());
    std::ranges::copy(bias, own_bias.begin());
    for (int t = 0; t < film_.tile_count(); ++t) {
      const auto [x0, y0, width, height] = film_.tile_box(t);
      if (film_.passes(x0, y0) == 0) continue;
      double sum = 0;
      for (int y = y0; y < y0 + height; ++y)
        for (int x = x0; x < x0 + width; ++x) sum += rays[place(x, y)];
      film_.totals_[static_cast<std::size_t>(t * film_.bands() + band)].ray_variance = sum;
    }
  }

 private:
  static double square(double value) noexcept { return value * value; }
  std::size_t place(int x, int y) const noexcept {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x);
  }
  std::span<float> channel(int number) const noexcept {
    return {film_.scatter_.data() + static_cast<std::size_t>(number) * film_.pixel_count(), film_.pixel_count()};
  }
  std::span<float> common(int number) const noexcept { return channel(Film::kBandPlanes * film_.bands() + number); }
  std::span<float> scatter(int number) const noexcept { return channel(Film::kBandPlanes * band_ + number); }

  bool done(std::size_t p) const noexcept { return film_.ray_count()[p] > 0; }
  bool lone(std::size_t p) const noexcept { return film_.ray_count()[p] == 1; }
  /// Whether both show the same: one object, or the sky, behind clouds or not.
  bool alike(std::size_t p, std::size_t q) const noexcept {
    return done(q) && film_.object_id()[p] == film_.object_id()[q] &&
           (transmission_[p] < 1) == (transmission_[q] < 1) &&
           std::isinf(film_.depth_m()[p]) == std::isinf(film_.depth_m()[q]);
  }
  template <class Work>
  void each_pixel(const Work& work) const {
    tbb::parallel_for(0, rows_, [&](int y) {
      for (int x = 0; x < columns_; ++x) {
        if (done(place(x, y))) work(x, y);
      }
    });
  }

  /// Sets the squares that a pixel lends to others. One with a single ray is the middle of its neighbours'.
  void lend(int x, int y) {
    const std::size_t p = place(x, y);
    if (!lone(p)) {
      for (int k = 0; k < 2; ++k) square_[k][p] = square(scatter(Film::kSmooth + k)[p]);
      return;
    }
    const int kind = weight_[1][p] > 0;
    double squares = 0, known = 0;
    int count = 0;
    for (const int v : {-1, 1}) {
      for (const int u : {-1, 1}) {
        if (x + u < 0 || x + u >= columns_ || y + v < 0 || y + v >= rows_) continue;
        const std::array<std::size_t, 4> around{p, place(x + u, y), place(x + u, y + v), place(x, y + v)};
        if (!std::ranges::all_of(around, [this](std::size_t q) { return lone(q); })) continue;
        const auto complex = std::ranges::count_if(around, [this](std::size_t q) { return !smooth(q); });
        if (kind == 0 && (complex > 0 || !std::ranges::all_of(around, [&](std::size_t q) {
                            return film_.object_id()[p] == film_.object_id()[q];
                          })))
          continue;
        const double t = twist(seen(around[0]), seen(around[1]), seen(around[2]), seen(around[3]));
        if (std::abs(t) > kRounding * std::abs(radiance_[p])) squares += t * t / (kind == 0 ? 4 : complex);
        for (const std::size_t q : around)
          known += (kind == 0 || !smooth(q) ? noise(q) : 0.0) / (kind == 0 ? 4 : complex);
        ++count;
      }
    }
    square_[static_cast<std::size_t>(kind)][p] = count > 0 ? squares / count : 0.0;
    known_[static_cast<std::size_t>(kind)][p] = static_cast<float>(count > 0 ? known / count : 0.0);
  }
  /// About how the variance of a pixel goes with the light that its clouds take, before the sky: of smooth clouds as a
  /// higher power than of ragged ones (sensor/MEASURED.md, "Coverage").
  double opaque(std::size_t p) const noexcept {
    return std::isinf(film_.depth_m()[p]) && transmission_[p] < 1 ? std::pow(1.0 - double{transmission_[p]}, 0.75)
                                                                  : 1.0;
  }
  bool smooth(std::size_t p) const noexcept { return !(weight_[1][p] > 0); }
  double noise(std::size_t p) const noexcept { return double{weight_[0][p]} + weight_[1][p]; }
  RayLight seen(std::size_t p) const noexcept { return {radiance_[p], scatter(Film::kForeseen)[p]}; }

  /// Variance of a pixel's mean from its rays' scatter, as it and its neighbours know it.
  double scatter_of(int x, int y) const noexcept {
    const std::size_t p = place(x, y);
    std::array<double, 2> ratio{-1, -1};
    for (std::size_t k = 0; k < 2; ++k) {
      if (!(weight_[k][p] > 0)) continue;
      // What differs within complex parts differs alike along an edge, whatever the centres show.
      ratio[k] = pooled_ratio(x, y, k, [&](std::size_t q) { return k == 1 ? done(q) : alike(p, q); });
      if (ratio[k] < 0) ratio[k] = pooled_ratio(x, y, k, [&](std::size_t q) { return done(q); });
    }
    double sum = 0;
    for (std::size_t k = 0; k < 2; ++k) {
      if (!(weight_[k][p] > 0)) continue;
      const double here = ratio[k] >= 0 ? ratio[k] : ratio[1 - k];
      sum += here >= 0 ? weight_[k][p] * here : lone(p) ? square(scatter(Film::kOwn)[p]) : 0.0;
    }
    return sum;
  }

  bool open_sky(std::size_t p) const noexcept { return std::isinf(film_.depth_m()[p]) && !(transmission_[p] < 1); }

  /// Squares over what is known of them in a window that grows until they are sure (where light is rare, a few pixels
  /// that see none of it prove little); -1: nothing is known.
  template <class Counts>
  double pooled_ratio(int x, int y, std::size_t kind, const Counts& counts) const noexcept {
    double squares = 0, known = 0;
    const bool open = open_sky(place(x, y));
    for (int reach = kLeastReach; reach <= (open ? kSkyReach : kMostReach); reach *= 2) {
      squares = known = 0;
      double fourth = 0;
      for (int v = std::max(0, y - reach); v <= std::min(rows_ - 1, y + reach); ++v) {
        for (int u = std::max(0, x - reach); u <= std::min(columns_ - 1, x + reach); ++u) {
          const std::size_t q = place(u, v);
          if (!(known_[kind][q] > 0) || !counts(q)) continue;
          const double weight = (reach + 1 - std::abs(u - x)) * (reach + 1 - std::abs(v - y));
          const double term = weight * square_[kind][q];
          squares += term;
          fourth += term * term;
          known += weight * known_[kind][q] * opaque(q);
        }
      }
      if (squares > 0 && squares * squares >= kSure * fourth) break;
    }
    return known > 0 ? squares / known * opaque(place(x, y)) : -1.0;
  }

  Film& film_;
  int columns_, rows_;
  int band_ = 0;
  std::span<const float> transmission_, radiance_;
  std::array<std::span<float>, 2> known_, weight_;  // of smooth and complex parts, see Scatter
  std::array<std::vector<double>, 2> square_;
};

void Film::pool_errors() {
  const std::vector<float> known(scatter_.end() - static_cast<std::ptrdiff_t>(kCommonPlanes * pixel_count()),
                                 scatter_.end());
  for (int b = 0; b < bands(); ++b) {
    std::ranges::copy(known, scatter_.end() - static_cast<std::ptrdiff_t>(kCommonPlanes * pixel_count()));
    ErrorPool(*this).run(b);
  }
  scatter_ = {};
}

}  // namespace obscura
