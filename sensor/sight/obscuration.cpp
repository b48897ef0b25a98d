#include "sensor/sight/obscuration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <numeric>

#include "octree/base/math.h"
#include "octree/base/statistics.h"

namespace obscura {
namespace {

constexpr double kMiss = 0.05;  // share of cases that an interval may miss

// A number computed from all replicas but one (-1: from all); nothing where it has no meaning.
using Value = std::function<std::optional<double>(int left_out)>;

/// Student's interval about the value from all replicas, with the jackknife's error (sensor/METHODS.md, "Obscuration").
std::optional<Confident> confident(int replicas, const Value& value, double least = -kInfinity,
                                   double most = kInfinity) {
  const std::optional<double> all = value(-1);
  if (!all) return std::nullopt;
  Moments pseudo;
  for (int r = 0; r < replicas; ++r) {
    const std::optional<double> rest = value(r);
    if (!rest) return std::nullopt;
    pseudo.add(*all + (replicas - 1) * (*all - *rest));
  }
  const double half = student_limit(kMiss, replicas - 1) * pseudo.standard_error();
  return Confident{*all, std::clamp(*all - half, least, most), std::clamp(*all + half, least, most)};
}

/// The interval of a mean over replicas, each of which has one number.
std::optional<Confident> confident_mean(const std::vector<double>& numbers, double least, double most) {
  const double sum = pairwise_sum(numbers);
  const auto count = static_cast<double>(numbers.size());
  return confident(
      static_cast<int>(numbers.size()),
      [&](int out) -> std::optional<double> {
        return out < 0 ? sum / count : (sum - numbers[static_cast<std::size_t>(out)]) / (count - 1);
      },
      least, most);
}

/// Where a share of the lines is 0 (or 1) in all replicas, their scatter is 0: the interval then reaches to the share
/// that so many lines would have missed in 5 of 100 cases.
void open_ends(std::optional<Confident>& share, double lines) {
  if (!share || share->high > share->low || !(lines > 0)) return;
  const double room = 1 - std::pow(kMiss, 1 / lines);
  if (share->value <= 0) share->high = room;
  if (share->value >= 1) share->low = 1 - room;
}

/// Linear between the ordered values (definition 7 of Hyndman and Fan, The American Statistician 50, 1996).
double percentile(const std::vector<float>& ordered, double per_cent) {
  const double place = std::clamp(per_cent / 100, 0.0, 1.0) * static_cast<double>(ordered.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, ordered.size() - 1);
  return ordered[below] + (place - static_cast<double>(below)) * (static_cast<double>(ordered[above]) - ordered[below]);
}

/// One kind of look in all replicas, added up so that any one can be left out.
class Looks {
 public:
  Looks(std::span<const SightReplica> replicas, Look SightReplica::*which) {
    for (const SightReplica& replica : replicas) looks_.push_back(&(replica.*which));
    object_.resize(looks_.size());
    object_lines_.resize(looks_.size());
    for (std::size_t r = 0; r < looks_.size(); ++r) {
      object_[r] = pairwise_sum(looks_[r]->radiance);
      object_lines_[r] = pairwise_sum(looks_[r]->lines);
    }
  }

  int count() const { return static_cast<int>(looks_.size()); }
  std::size_t pixels() const { return looks_.front()->lines.size(); }

  std::optional<double> object(int out) const {
    return mean(out, [&](std::size_t r) { return std::pair{object_[r], object_lines_[r]}; });
  }
  std::optional<double> surroundings(int out) const {
    return mean(out, [&](std::size_t r) { return std::pair{looks_[r]->surround_radiance, looks_[r]->surround_lines}; });
  }
  std::optional<double> difference(int out) const {
    const auto o = object(out), s = surroundings(out);
    if (!o || !s) return std::nullopt;
    return *o - *s;
  }
  std::optional<double> relative(int out) const {
    const auto d = difference(out), s = surroundings(out);
    if (!d || !(*s > 0)) return std::nullopt;
    return *d / *s;
  }

  /// Bias of the difference, as the photon map estimates its own.
  double difference_bias() const {
    double object = 0, object_lines = 0, around = 0, around_lines = 0;
    for (std::size_t r = 0; r < looks_.size(); ++r) {
      object += looks_[r]->bias;
      object_lines += object_lines_[r];
      around += looks_[r]->surround_bias;
      around_lines += looks_[r]->surround_lines;
    }
    return object_lines > 0 && around_lines > 0 ? object / object_lines - around / around_lines : 0.0;
  }

  /// Share of the visible area whose pixels' mean radiance is between two bounds.
  std::optional<double> share_between(int out, double low, double high) const {
    double inside = 0, all = 0;
    for (std::size_t p = 0; p < pixels(); ++p) {
      double lines = 0, radiance = 0;
      for (std::size_t r = 0; r < looks_.size(); ++r) {
        if (static_cast<int>(r) == out) continue;
        lines += looks_[r]->lines[p];
        radiance += looks_[r]->radiance[p];
      }
      if (!(lines > 0)) continue;
      all += lines;
      if (radiance > low * lines && radiance < high * lines) inside += lines;
    }
    if (!(all > 0)) return std::nullopt;
    return inside / all;
  }

  /// Standard error of a pixel's mean over all replicas: RMS over the object's pixels, weighted with their area.
  double pixel_error() const {
    double sum = 0, all = 0;
    for (std::size_t p = 0; p < pixels(); ++p) {
      Moments means;
      double lines = 0;
      for (const Look* look : looks_) {
        if (!(look->lines[p] > 0)) continue;
        means.add(look->radiance[p] / look->lines[p]);
        lines += look->lines[p];
      }
      if (means.count() < 2) continue;
      sum += lines * means.variance() / static_cast<double>(means.count());
      all += lines;
    }
    return all > 0 ? std::sqrt(sum / all) : 0.0;
  }

 private:
  template <class F>
  std::optional<double> mean(int out, const F& part) const {
    double radiance = 0, lines = 0;
    for (std::size_t r = 0; r < looks_.size(); ++r) {
      if (static_cast<int>(r) == out) continue;
      const auto [l, n] = part(r);
      radiance += l;
      lines += n;
    }
    if (!(lines > 0)) return std::nullopt;
    return radiance / lines;
  }

  std::vector<const Look*> looks_;
  std::vector<double> object_, object_lines_;
};

std::optional<double> kelvin(const Band& band, const std::optional<double>& radiance) {
  if (band.grey() || !radiance || !(*radiance > 0)) return std::nullopt;
  return band.brightness_temperature(*radiance);
}

std::optional<double> kelvin_difference(const Band& band, const Looks& looks, int out) {
  const auto o = kelvin(band, looks.object(out)), s = kelvin(band, looks.surroundings(out));
  if (!o || !s) return std::nullopt;
  return *o - *s;
}

SightContrast contrast_of(const Band& band, const Looks& looks, const ObscurationSettings& settings) {
  const int n = looks.count();
  SightContrast c;
  c.object = confident(n, [&](int out) { return looks.object(out); });
  c.surroundings = confident(n, [&](int out) { return looks.surroundings(out); });
  c.difference = confident(n, [&](int out) { return looks.difference(out); });
  c.relative = confident(n, [&](int out) { return looks.relative(out); });
  c.object_K = confident(
      n, [&](int out) { return kelvin(band, looks.object(out)); }, 0);
  c.surroundings_K = confident(
      n, [&](int out) { return kelvin(band, looks.surroundings(out)); }, 0);
  c.difference_K = confident(n, [&](int out) { return kelvin_difference(band, looks, out); });
  c.pixel_error = looks.pixel_error();
  c.difference_bias = looks.difference_bias();
  c.lost_contrast = confident(
      n,
      [&](int out) -> std::optional<double> {
        const auto s = looks.surroundings(out);
        if (!s || !(*s > 0)) return std::nullopt;
        return looks.share_between(out, *s * (1 - settings.contrast), *s * (1 + settings.contrast));
      },
      0, 1);
  if (settings.difference_K) {
    // Radiance grows with temperature: bounds in one are bounds in the other.
    c.lost_K = confident(
        n,
        [&](int out) -> std::optional<double> {
          const auto K = kelvin(band, looks.surroundings(out));
          if (!K) return std::nullopt;
          const double cold = *K - *settings.difference_K;
          return looks.share_between(out, cold > 0 ? band.planck(cold) : -kInfinity,
                                     band.planck(*K + *settings.difference_K));
        },
        0, 1);
  }
  return c;
}

/// The value with the cloud over that without it; nothing where the interval of the latter holds 0, or where it is only
/// rounding of numbers as large as `scale`.
std::optional<Confident> ratio(int replicas, const std::optional<Confident>& without, double scale, const Value& above,
                               const Value& below) {
  if (!without || (without->low <= 0 && without->high >= 0) || std::abs(without->value) <= 1e-6 * scale)
    return std::nullopt;
  return confident(replicas, [&](int out) -> std::optional<double> {
    const auto a = above(out), b = below(out);
    if (!a || !b || *b == 0) return std::nullopt;
    return *a / *b;
  });
}

void add_transmission(std::span<const SightReplica> replicas, const ObscurationSettings& settings,
                      BandObscuration& result) {
  std::vector<double> means, obscured;
  std::vector<std::vector<double>> places(settings.percentiles.size());
  double lines = 0;
  result.transmission_min = kInfinity;
  result.transmission_max = -kInfinity;
  for (const SightReplica& replica : replicas) {
    std::vector<float> ordered = replica.transmission;
    assert(!ordered.empty());
    std::ranges::sort(ordered);
    const auto count = static_cast<double>(ordered.size());
    means.push_back(std::accumulate(ordered.begin(), ordered.end(), 0.0) / count);
    // Transmissions are floats, so the threshold becomes one too: a line exactly on it counts as obscured.
    const auto limit = static_cast<float>(settings.transmission);
    obscured.push_back(static_cast<double>(std::ranges::upper_bound(ordered, limit) - ordered.begin()) / count);
    for (std::size_t p = 0; p < places.size(); ++p) places[p].push_back(percentile(ordered, settings.percentiles[p]));
    result.transmission_min = std::min<double>(result.transmission_min, ordered.front());
    result.transmission_max = std::max<double>(result.transmission_max, ordered.back());
    lines += count;
  }
  result.transmission = confident_mean(means, 0, 1);
  result.obscured = confident_mean(obscured, 0, 1);
  open_ends(result.obscured, lines);
  for (std::size_t p = 0; p < places.size(); ++p) {
    result.percentiles.emplace_back(settings.percentiles[p], *confident_mean(places[p], 0, 1));
  }
}

/// What the intervals do not tell: shares below thresholds that a pixel's noise reaches, and the map's own bias.
void add_notes(const Band& band, const ObscurationSettings& settings, BandObscuration& result) {
  for (const auto& [look, c] : {std::pair{"with", &result.with}, std::pair{"without", &result.without}}) {
    std::string note;
    if (c->surroundings && c->surroundings->value > 0 &&
        c->pixel_error > 0.5 * settings.contrast * c->surroundings->value) {
      note = fmt::format("{:.2g} of the surroundings", c->pixel_error / c->surroundings->value);
    }
    if (c->lost_K && c->surroundings_K) {
      const double K = c->pixel_error / band.planck_derivative(c->surroundings_K->value);
      if (K > 0.5 * *settings.difference_K) note += fmt::format("{}{:.2g} K", note.empty() ? "" : ", ", K);
    }
    if (!note.empty()) {
      result.notes.push_back(fmt::format(
          "{} the cloud, a pixel's own noise ({}) is not small against the threshold: the share below it is rough",
          look, note));
    }
    if (c->difference && std::abs(c->difference_bias) > 0.5 * (c->difference->high - c->difference->low) &&
        std::abs(c->difference_bias) > 1e-3 * std::abs(c->difference->value)) {
      result.notes.push_back(
          fmt::format("{} the cloud, the photon map's own bias may be {:+.2g} of the difference's radiance, more than "
                      "its interval: "
                      "more photons make it smaller, method path has none",
                      look, c->difference_bias));
    }
  }
}

}  // namespace

double ObjectMask::area() const noexcept { return std::accumulate(share.begin(), share.end(), 0.0); }

std::size_t ObjectMask::interior() const noexcept {
  return static_cast<std::size_t>(std::ranges::count_if(share, [](float s) { return s >= 1; }));
}

std::size_t ObjectMask::ring_size() const noexcept {
  return static_cast<std::size_t>(std::ranges::count_if(ring, [](std::uint8_t r) { return r != 0; }));
}

bool ObjectMask::at_border() const noexcept {
  for (int y = 0; y < rows; ++y) {
    const bool whole = y == 0 || y == rows - 1;
    for (int x = 0; x < columns; x += whole ? 1 : std::max(1, columns - 1)) {
      if (share[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x)] > 0)
        return true;
    }
  }
  return false;
}

ObjectMask mask_of(int columns, int rows, std::vector<float> share, int width) {
  assert(share.size() == static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  ObjectMask mask;
  mask.columns = columns;
  mask.rows = rows;
  mask.share = std::move(share);
  mask.width = width > 0 ? width : std::max(2, static_cast<int>(std::ceil(0.5 * std::sqrt(mask.area()))));

  // A window in rows, then in columns: how far the nearest pixel with a mark is, on either side.
  const auto widen = [&](const std::vector<std::uint8_t>& from, int lines, int length, int line_step, int step) {
    std::vector<std::uint8_t> to(from.size());
    for (int line = 0; line < lines; ++line) {
      for (const bool back : {false, true}) {
        int since = mask.width + 1;
        for (int k = 0; k < length; ++k) {
          const auto i = static_cast<std::size_t>(line) * static_cast<std::size_t>(line_step) +
                         static_cast<std::size_t>(back ? length - 1 - k : k) * static_cast<std::size_t>(step);
          since = from[i] ? 0 : std::min(since + 1, mask.width + 1);
          if (since <= mask.width) to[i] = 1;
        }
      }
    }
    return to;
  };
  std::vector<std::uint8_t> marks(mask.share.size());
  std::ranges::transform(mask.share, marks.begin(), [](float s) { return static_cast<std::uint8_t>(s > 0 ? 1 : 0); });
  mask.ring = widen(widen(marks, rows, columns, columns, 1), columns, rows, 1, columns);
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (marks[i]) mask.ring[i] = 0;
  }
  return mask;
}

BandObscuration find_obscuration(const Band& band, std::span<const SightReplica> replicas,
                                 const ObscurationSettings& settings) {
  assert(replicas.size() >= 2);
  BandObscuration result;
  result.band = band.name();
  result.grey = band.grey();
  add_transmission(replicas, settings, result);

  const Looks with(replicas, &SightReplica::with), without(replicas, &SightReplica::without);
  result.with = contrast_of(band, with, settings);
  result.without = contrast_of(band, without, settings);
  const int n = with.count();
  const auto size = [](const std::optional<Confident>& c) { return c ? std::abs(c->value) : 0.0; };
  result.difference_ratio = ratio(
      n, result.without.difference, size(result.without.object) + size(result.without.surroundings),
      [&](int out) { return with.difference(out); }, [&](int out) { return without.difference(out); });
  result.relative_ratio = ratio(
      n, result.without.relative, 1, [&](int out) { return with.relative(out); },
      [&](int out) { return without.relative(out); });
  result.difference_K_ratio = ratio(
      n, result.without.difference_K, size(result.without.surroundings_K),
      [&](int out) { return kelvin_difference(band, with, out); },
      [&](int out) { return kelvin_difference(band, without, out); });

  if (!result.difference_ratio) {
    result.notes.push_back(
        "without the cloud the object's mean does not stand out from its surroundings: there is no ratio with to "
        "without");
  }
  add_notes(band, settings, result);
  return result;
}

}  // namespace obscura
