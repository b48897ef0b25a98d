#include "photon/spot/spot_seen.h"

#include <algorithm>

namespace obscura::detail {
namespace {

/// Normals that are kept for comparison; more than so many that are not alike count as different.
constexpr std::size_t kMostNormals = 256;

/// Range of the emissivity's factor between two angles.
std::pair<double, double> factor_range(const Material& material, double low, double high) {
  const std::vector<double>& at = material.angle_deg;
  const std::vector<double>& factor = material.angle_factor;
  const auto value = [&](double degrees) {
    const auto i = static_cast<std::size_t>(std::upper_bound(at.begin(), at.end(), degrees) - at.begin());
    if (i == 0) return factor.front();
    if (i == at.size()) return factor.back();
    return factor[i - 1] + (factor[i] - factor[i - 1]) * (degrees - at[i - 1]) / (at[i] - at[i - 1]);
  };
  low *= 180 / kPi;
  high *= 180 / kPi;
  const double first = value(low), last = value(high);
  std::pair<double, double> result{std::min(first, last), std::max(first, last)};
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (at[i] <= low || at[i] >= high) continue;
    result.first = std::min(result.first, factor[i]);
    result.second = std::max(result.second, factor[i]);
  }
  return result;
}

}  // namespace

void Seen::clear() {
  others_ = faces_ = 0;
  sky_ = plain_ = given_ = false;
  kinds_.clear();
  materials_.clear();
  normals_.clear();
  central_ = 0;
  near_ = kInfinity;
  far_ = 0;
  K_low_ = kInfinity;
  K_high_ = -kInfinity;
  emissivity_low_.clear();
  emissivity_high_.clear();
  last_plain_material_ = -3;
}

Criterion Seen::add_sky() {
  if (sky_) return Criterion::none;
  sky_ = true;
  ++others_;
  const auto reached = [&](const std::optional<int>& threshold, std::size_t faces) {
    return threshold && *threshold >= 2 &&
           faces + static_cast<std::size_t>(others_) >= static_cast<std::size_t>(*threshold);
  };
  if (reached(asked_.polygons, kinds_.size())) return Criterion::polygons;
  if (reached(asked_.polygons_strict, static_cast<std::size_t>(faces_))) return Criterion::polygons;
  if (asked_.materials && *asked_.materials >= 2 && static_cast<int>(materials_.size()) + 1 >= *asked_.materials)
    return Criterion::materials;
  return Criterion::none;
}

Criterion Seen::add_disc() {
  ++others_;
  const int kinds = static_cast<int>(kinds_.size()) + others_;
  const bool met =
      (asked_.polygons && *asked_.polygons >= 2 && kinds >= *asked_.polygons) ||
      (asked_.polygons_strict && *asked_.polygons_strict >= 2 && faces_ + others_ >= *asked_.polygons_strict);
  return met ? Criterion::polygons : Criterion::none;
}

bool Seen::apart(const Normal& a, const Normal& b, double angle, double chord2) noexcept {
  const double between2 = (a.direction - b.direction).length2();
  if (a.curl + b.curl == 0) return between2 > chord2;
  return 2 * std::asin(std::min(1.0, 0.5 * std::sqrt(between2))) + a.curl + b.curl > angle;
}

bool Seen::new_kind(const SeenFace& sight) {
  for (const Kind& kind : kinds_) {
    if (kind.surface != sight.surface || kind.material != sight.material) continue;
    if (asked_.temperature_K &&
        (kind.radiance_given != sight.radiance_given ||
         (!sight.radiance_given &&
          std::max(kind.K_high, sight.K_high) - std::min(kind.K_low, sight.K_low) > *asked_.temperature_K))) {
      continue;
    }
    if (asked_.normal && apart(kind.normal, {sight.normal, sight.curl}, *asked_.normal, chord2_)) continue;
    return false;
  }
  kinds_.push_back(
      {sight.surface, sight.material, {sight.normal, sight.curl}, sight.K_low, sight.K_high, sight.radiance_given});
  return true;
}

bool Seen::normals_differ(const SeenFace& sight) {
  const double most = *asked_.normal;
  const Normal normal{sight.normal, sight.curl};
  if (sight.curl > most) return true;
  // Two that are within half the angle of the first are alike: those need be compared with the others only.
  const bool central = normals_.empty() || !apart(normals_[0], normal, 0.5 * most, half_chord2_);
  if (!central && apart(normals_[0], normal, most, chord2_)) return true;
  for (std::size_t i = central ? central_ : 0; i < normals_.size(); ++i) {
    if (normals_[i].direction == sight.normal && normals_[i].curl >= sight.curl) return false;
    if (apart(normals_[i], normal, most, chord2_)) return true;
  }
  if (central) {
    for (std::size_t i = 0; i < central_; ++i) {
      if (normals_[i].direction == sight.normal && normals_[i].curl >= sight.curl) return false;
    }
  }
  if (normals_.size() >= kMostNormals) return true;
  normals_.push_back(normal);
  if (central) std::swap(normals_[central_++], normals_.back());
  return false;
}

bool Seen::temperatures_differ(const SeenFace& sight) {
  if (sight.radiance_given) {
    const bool differ = plain_ || (given_ && giver_ != sight.surface);
    given_ = true;
    giver_ = sight.surface;
    return differ;
  }
  plain_ = true;
  K_low_ = std::min(K_low_, sight.K_low);
  K_high_ = std::max(K_high_, sight.K_high);
  return given_ || K_high_ - K_low_ > *asked_.temperature_K;
}

bool Seen::emissivities_differ(const SeenFace& sight) {
  const Material* material =
      sight.material >= 0 ? &world_.materials()[static_cast<std::size_t>(sight.material)] : nullptr;
  const bool by_angle = material && !material->angle_factor.empty();
  if (!by_angle && sight.material == last_plain_material_) return false;
  if (!by_angle) last_plain_material_ = sight.material;
  const auto intervals = static_cast<std::size_t>(world_.interval_count());
  emissivity_low_.resize(intervals, kInfinity);
  emissivity_high_.resize(intervals, -kInfinity);
  std::pair<double, double> factor{1, 1};
  if (by_angle) factor = factor_range(*material, sight.angle_low, sight.angle_high);
  bool differ = false;
  for (std::size_t i = 0; i < intervals; ++i) {
    // A back emits nothing; a hot sphere is black.
    const double e = material ? material->emissivity[i] : sight.material == SeenFace::kHot ? 1.0 : 0.0;
    emissivity_low_[i] = std::min(emissivity_low_[i], std::clamp(e * factor.first, 0.0, 1.0));
    emissivity_high_[i] = std::max(emissivity_high_[i], std::clamp(e * factor.second, 0.0, 1.0));
    differ = differ || emissivity_high_[i] - emissivity_low_[i] > *asked_.emissivity;
  }
  return differ;
}

Criterion Seen::add(const SeenFace& sight) {
  ++faces_;
  if (asked_.polygons && new_kind(sight) && static_cast<int>(kinds_.size()) + others_ >= *asked_.polygons)
    return Criterion::polygons;
  if (asked_.polygons_strict && faces_ + others_ >= *asked_.polygons_strict) return Criterion::polygons;
  if (asked_.materials && std::find(materials_.begin(), materials_.end(), sight.material) == materials_.end()) {
    materials_.push_back(sight.material);
    if (static_cast<int>(materials_.size()) + sky_ >= *asked_.materials) return Criterion::materials;
  }
  if (asked_.normal && normals_differ(sight)) return Criterion::normal;
  near_ = std::min(near_, sight.near);
  far_ = std::max(far_, sight.far);
  if (asked_.depth && far_ - near_ > *asked_.depth * near_) return Criterion::depth;
  if (asked_.temperature_K && temperatures_differ(sight)) return Criterion::temperature;
  if (asked_.emissivity && emissivities_differ(sight)) return Criterion::emissivity;
  return Criterion::none;
}

}  // namespace obscura::detail
