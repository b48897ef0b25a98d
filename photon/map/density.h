// The density estimate: from the photons around a point to fluence, in-scattered radiance or any other
// weighting of the light there, with batch values and the kernel's bias. Formulas:
// photon/METHODS.md, "The photon map".
#pragma once

#include <array>
#include <span>

#include "photon/map/kernel.h"
#include "photon/map/photon_map.h"

namespace obscura {

struct GatherSettings {
  int nearest = 64;  ///< k; the k-th photon gives the radius and is not counted. 2 .. Nearest::kMax
  Kernel kernel = Kernel::epanechnikov;
  int rounds = 4;  ///< of 24 points each for the denominator: half as many in a homogeneous ball, up to
                   ///< four times as many where the medium fills little of it. 2 .. 16
  double max_radius_m = kInfinity;  ///< where fewer than k are within it, it is the radius
  bool edge_correction = true;      ///< local linear correction for gradients at edges
};

/// Everything is for weighted light at a point: with weight 1 the fluence (W/m2), with a phase function
/// (1/sr) of the photons' directions the in-scattered radiance J (W/m2/sr).
struct Estimate {
  double value = 0;                      ///< mean over batches
  std::array<double, kBatches> batch{};  ///< independent replicas of the value
  double bias = 0;                       ///< signed: value - truth to the order radius^2, from two radii; noisy
  double radius = 0;                     ///< m, of the ball
  int photons = 0;                       ///< that were counted
  bool anomaly = false;                  ///< photons where there is no extinction: value is 0
};

/// For a ball without surfaces in it: all its places see one another.
struct Unobstructed {
  bool obstructed(const Vec3d&, double) const noexcept { return false; }
  Vec3d key(const Vec3d& x) const noexcept { return x; }
  bool sees(const Vec3d&, const Vec3d&) const noexcept { return true; }
};

namespace detail {

/// A point of the cubature in the unit ball, distributed like the kernel. Each is followed by its
/// antipode, so that a homogeneous medium has a first moment of 0.
struct BallPoint {
  double x, y, z;
  double inner;  ///< its weight in the kernel of radius 1/sqrt 2; 0 outside
};
inline constexpr int kRoundPoints = 24;
inline constexpr int kMostRounds = 16;
std::span<const BallPoint, kRoundPoints> ball_points(Kernel kernel) noexcept;

struct Rotation {
  Vec3d x, y, z;  // images of the axes
};
/// Uniform over all rotations, the same for the same key and round.
Rotation rotation_at(const Vec3d& key, int round) noexcept;

/// Moments of the extinction in a ball under its kernel; lengths in units of the ball's radius.
struct BallMoments {
  double zeroth = 0;
  Vec3d first{0, 0, 0};
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;

  void add(double k, const Vec3d& d) noexcept {
    const Vec3d kd = k * d;
    zeroth += k;
    first += kd;
    xx += kd.x * d.x;
    yy += kd.y * d.y;
    zz += kd.z * d.z;
    xy += kd.x * d.y;
    xz += kd.x * d.z;
    yz += kd.y * d.z;
  }
};

/// The weight of a photon at d (in radii) is level - slope . d: the local linear correction over the denominator.
struct PhotonWeight {
  double level = 0;
  Vec3d slope{0, 0, 0};
  double variance = 0;  ///< of the denominator's cubature, relative
};
/// @param rounds  moments of independent rounds, each divided by the weight of its points
PhotonWeight photon_weight(std::span<const BallMoments> rounds, bool correct) noexcept;

/// Whether there is extinction at the place of a photon, as exactly as a map in float32 keeps it.
template <class Extinction>
bool in_medium(const Vec3d& place, const Extinction& extinction) noexcept {
  const double rounding = 1e-6 * (1 + place.length());
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 0.0, 1.0}) {
      Vec3d near = place;
      near[axis] += sign * rounding;
      if (extinction(near) > 0) return true;
    }
  }
  return false;
}

/// Largest relative standard error with which a denominator is believed.
inline constexpr double kMostDoubt = 0.5;

/// The estimate in the ball about x, and where its nearest photon is. `resolved` tells whether the
/// cubature has met enough of the medium.
/// @param at_photon  x is the place of a photon, which is not counted
template <class Extinction, class Weight, class Surroundings>
Estimate estimate_in_ball(const PhotonMap& map, const Vec3d& x, const Extinction& extinction, const Weight& weight,
                          const Surroundings& surroundings, const GatherSettings& settings, bool at_photon,
                          Vec3d& neighbour, bool& resolved) noexcept {
  Estimate result;
  resolved = true;

  // The ball: k neighbours, the last of which gives the radius and is not counted. What is as far as
  // that is not counted either; where it is all there is, the search goes farther.
  const double reach = std::min(settings.max_radius_m, map.reach());
  const float reach2 = static_cast<float>(reach * reach);
  const Vec3f local = map.local(x);
  Nearest nearest(settings.nearest, reach2);
  map.nearest(local, nearest);
  if (nearest.full() && nearest.all_equal()) {
    nearest = Nearest(Nearest::kMax, reach2);
    map.nearest(local, nearest);
  }
  const bool cut = !nearest.full() && std::isfinite(reach);
  if (nearest.count() == 0) {
    if (cut) result.radius = reach;
    return result;
  }
  const float rim = cut ? reach2 : nearest.distance2(nearest.count() - 1);
  const double radius2 = rim;
  const double radius = std::sqrt(radius2);
  result.radius = radius;
  if (!(radius > 0) || (!cut && nearest.all_equal())) return result;

  // Where surfaces stand in the ball, it ends at them.
  const bool obstructed = surroundings.obstructed(x, radius);

  // The denominator: extinction under the kernel, for the ball and for the one of radius / sqrt 2, by
  // rounds of points that are turned independently, until they agree.
  const auto points = detail::ball_points(settings.kernel);
  std::array<detail::BallMoments, detail::kMostRounds> outer{}, inner{};
  detail::PhotonWeight counts;
  int rounds = 0;
  const int enough = std::clamp(settings.rounds, 2, detail::kMostRounds);
  for (int until = 2;; until = std::min(2 * until, detail::kMostRounds)) {
    for (; rounds < until; ++rounds) {
      const detail::Rotation turn = detail::rotation_at(surroundings.key(x), rounds);
      for (const detail::BallPoint& point : points) {
        const Vec3d d = point.x * turn.x + point.y * turn.y + point.z * turn.z;
        const Vec3d y = x + radius * d;
        const double k = extinction(y);
        if (!(k > 0) || (obstructed && !surroundings.sees(x, y))) continue;
        outer[rounds].add(k, d);
        if (point.inner > 0) inner[rounds].add(k * point.inner, d);
      }
    }
    counts = detail::photon_weight({outer.data(), std::size_t(rounds)}, settings.edge_correction);
    const double most = rounds < enough ? 0.01 : 0.2;
    if (rounds == detail::kMostRounds || (counts.level > 0 && counts.variance <= most * most)) break;
  }
  const auto inner_counts = detail::photon_weight({inner.data(), std::size_t(rounds)}, settings.edge_correction);

  resolved = counts.level > 0 && counts.variance <= detail::kMostDoubt * detail::kMostDoubt;

  // Rounds agree too when none has met what holds the photons: a hundredth of the extinction at the
  // photons is the least that they can be trusted to find.
  double photons_extinction = kInfinity;
  constexpr int kAsked = 4;
  for (int i = 0; i < kAsked; ++i) {
    const Vec3d d(map.offset(local, nearest.index(i * (nearest.count() - 1) / kAsked)));
    photons_extinction = std::min(photons_extinction, extinction(x + d));
  }
  double mean_extinction = 0;
  for (int round = 0; round < rounds; ++round) mean_extinction += outer[round].zeroth / rounds;
  if (mean_extinction < 0.01 * photons_extinction) resolved = false;

  // The photons, into their batches.
  double inner_sum = 0;
  float closest = kInfinity;
  for (int i = 0; i < nearest.count(); ++i) {
    const float distance2 = nearest.distance2(i);
    if (!(distance2 < rim)) continue;
    const Vec3d there = x + Vec3d(map.offset(local, nearest.index(i)));
    if (obstructed && !surroundings.sees(x, there)) continue;
    if (distance2 < closest) {
      closest = distance2;
      neighbour = there;
    }
    if (at_photon && distance2 == 0) continue;
    ++result.photons;
    const Photon& photon = map.photon(nearest.index(i));
    const Vec3d d = Vec3d(map.offset(local, nearest.index(i))) / radius;
    const double light = photon.power * weight(decode_direction(photon.direction));
    const double u = distance2 / radius2;
    result.batch[photon.batch % kBatches] +=
        light * detail::kernel_shape(settings.kernel, u) * (counts.level - counts.slope.dot(d));
    if (2 * u < 1) {
      inner_sum +=
          light * detail::kernel_shape(settings.kernel, 2 * u) * (inner_counts.level - inner_counts.slope.dot(d));
    }
  }
  if (!(counts.level > 0)) {
    result.batch = {};
    result.anomaly = result.photons > 0;
    return result;
  }

  const double norm = detail::kernel_norm(settings.kernel) / (radius * radius2);
  double sum = 0;
  for (double& batch : result.batch) {
    batch *= norm * kBatches;
    sum += batch;
  }
  result.value = sum / kBatches;
  if (inner_counts.level > 0) {
    constexpr double kShrunk = 2 * std::numbers::sqrt2;  // the volume's ratio
    result.bias = 2 * (result.value - inner_sum * norm * kShrunk);
  }
  return result;
}

}  // namespace detail

/// The estimate at x (m, world).
/// @param extinction  double(const Vec3d& y): k at y in 1/m, of the medium whose collisions the map
///                    holds; >= 0, 0 outside. It has to repeat where the map does.
/// @param weight      double(const Vec3d& direction): what light that travels there counts
/// Where the map has no more than k photons, the farthest of all gives the radius and is not counted: in
/// a ball that holds the whole cloud the mean is still right. Photons at one place only, or a single one,
/// have no density: value 0.
/// @param surroundings  obstructed(x, radius): whether a surface stands in the ball; only then it is asked
///                    sees(x, y). Photons and medium that x does not see are left out. key(x) names the
///                    cubature's random rotation.
/// In a wisp so far from all else that the ball only just reaches what holds the photons, the cubature
/// cannot resolve the denominator: the light there is taken to be that at the nearest photon.
template <class Extinction, class Weight, class Surroundings = Unobstructed>
Estimate estimate(const PhotonMap& map, const Vec3d& x, const Extinction& extinction, const Weight& weight,
                  const GatherSettings& settings, const Surroundings& surroundings = {}) noexcept {
  Vec3d neighbour = x;
  bool resolved;
  Estimate result =
      detail::estimate_in_ball(map, x, extinction, weight, surroundings, settings, false, neighbour, resolved);
  if (resolved || result.photons == 0) return result;
  // A sheet or a thread may fill so little of the ball there that hardly a point of the cubature meets it: of a
  // ball of fewer photons it fills more.
  const Vec3d there = neighbour;
  GatherSettings fewer = settings;
  do {
    result = detail::estimate_in_ball(map, there, extinction, weight, surroundings, fewer, true, neighbour, resolved);
    fewer.nearest /= 2;
  } while (!resolved && fewer.nearest >= 8);
  if (!result.anomaly) return result;
  // Specks far apart, each with a photon or two: many of them together may be found. If not, what light the place has
  // is that of a few specks, and it is dark. Only photons outside all medium are none of this World's.
  GatherSettings more = settings;
  more.nearest = std::min(Nearest::kMax, 8 * settings.nearest);
  const Estimate wide =
      detail::estimate_in_ball(map, x, extinction, weight, surroundings, more, false, neighbour, resolved);
  if (resolved) return wide;
  result.anomaly = !detail::in_medium(there, extinction);
  return result;
}

}  // namespace obscura
