// The density estimate: from the photons around a point to fluence, in-scattered radiance or any other
// weighting of the light there, with batch values and the kernel's bias. Formulas: photon/METHODS.md.
#pragma once

#include "photon/kernel.h"
#include "photon/photon_map.h"

#include <array>
#include <span>

namespace obscura {

struct GatherSettings {
  int nearest = 64;  ///< k; the k-th photon gives the radius and is not counted. 2 .. Nearest::kMax
  Kernel kernel = Kernel::epanechnikov;
  int samples = 64;            ///< points of the denominator's cubature, even; up to eight times as many
                               ///< where the medium fills little of the ball
  double max_radius_m = kInfinity;  ///< where fewer than k are within it, it is the radius
  bool edge_correction = true;      ///< local linear correction for gradients at edges
};

/// Everything is for weighted light at a point: with weight 1 the fluence (W/m2), with a phase function
/// (1/sr) of the photons' directions the in-scattered radiance J (W/m2/sr).
struct Estimate {
  double value = 0;                      ///< mean over batches
  std::array<double, kBatches> batch{};  ///< independent replicas of the value
  double bias = 0;      ///< signed: value - truth to the order radius^2, from two radii; noisy
  double radius = 0;    ///< m, of the ball
  int photons = 0;      ///< that were counted
  bool anomaly = false; ///< photons in the ball, but no extinction was met: value is 0
};

namespace detail {

/// A point of the cubature in the unit ball, distributed like the kernel; every second one is the
/// antipode of the one before.
struct BallPoint {
  double x, y, z;
  double inner;  ///< what it counts in the kernel of radius 1/sqrt 2
};
inline constexpr int kBallPoints = 1024;
/// Each beginning of even length is a good cubature.
std::span<const BallPoint> ball_points(Kernel kernel) noexcept;

struct Rotation {
  Vec3d x, y, z;  // images of the axes
};
/// Uniform over all rotations, the same for the same point.
Rotation rotation_at(const Vec3d& x) noexcept;

/// Moments of the extinction in a ball under its kernel; lengths in units of the ball's radius.
class Moments3 {
 public:
  void add(double weight, const Vec3d& d) noexcept {
    zeroth_ += weight;
    first_ += weight * d;
    xx_ += weight * d.x * d.x;
    yy_ += weight * d.y * d.y;
    zz_ += weight * d.z * d.z;
    xy_ += weight * d.x * d.y;
    xz_ += weight * d.x * d.z;
    yz_ += weight * d.y * d.z;
  }
  double zeroth() const noexcept { return zeroth_; }

  /// A photon at d counts (1 - slope . d) / normaliser.
  struct Weights {
    Vec3d slope{0, 0, 0};
    double normaliser = 0;
  };
  /// @param count  sum of the cubature's own weights
  Weights weights(double count, double radius, bool correct) const noexcept;

 private:
  double zeroth_ = 0;
  Vec3d first_{0, 0, 0};
  double xx_ = 0, yy_ = 0, zz_ = 0, xy_ = 0, xz_ = 0, yz_ = 0;
};

}  // namespace detail

/// The estimate at x (m, world).
/// @param extinction  double(const Vec3d& y): k at y in 1/m, of the medium whose collisions the map
///                    holds; >= 0, 0 outside. It has to repeat where the map does.
/// @param weight      double(const Vec3d& direction): what light that travels there counts
/// A map without photons, or with one, has no density: value 0. Where the map has no more than k photons
/// the farthest of all gives the radius and is not counted.
template <class Extinction, class Weight>
Estimate estimate(const PhotonMap& map, const Vec3d& x, const Extinction& extinction,
                  const Weight& weight, const GatherSettings& settings) noexcept {
  Estimate result;

  // The ball: k neighbours, the last of which gives the radius and is not counted.
  const double reach = std::min(settings.max_radius_m, map.reach());
  Nearest nearest(settings.nearest, static_cast<float>(reach * reach));
  const Vec3f local = map.local(x);
  map.nearest(local, nearest);
  const bool cut = nearest.count() < nearest.wanted() && std::isfinite(reach);
  if (nearest.count() == 0) {
    if (cut) result.radius = reach;
    return result;
  }
  const float rim = cut ? static_cast<float>(reach * reach) : nearest.distance2(nearest.count() - 1);
  const double radius2 = rim;
  const double radius = std::sqrt(radius2);
  result.radius = radius;
  if (!(radius > 0)) return result;

  // The denominator: extinction under the kernel, for the ball and for the one of radius / sqrt 2.
  const auto points = detail::ball_points(settings.kernel);
  const detail::Rotation turn = detail::rotation_at(x);
  const int round = std::clamp(settings.samples, 2, detail::kBallPoints / 8) & ~1;
  detail::Moments3 outer, inner;
  double outer_count = 0, inner_count = 0, squares = 0;
  for (int i = 0; i < 8 * round;) {
    for (const int end = i + round; i < end; ++i) {
      const detail::BallPoint& point = points[i];
      const Vec3d d = point.x * turn.x + point.y * turn.y + point.z * turn.z;
      const double k = extinction(x + radius * d);
      inner_count += point.inner;
      if (!(k > 0)) continue;
      outer.add(k, d);
      inner.add(k * point.inner, d);
      squares += k * k;
    }
    outer_count = i;
    // Enough once the medium has been met by a third of a round.
    if (3 * outer.zeroth() * outer.zeroth() >= round * squares && squares > 0) break;
  }
  const auto outer_weights = outer.weights(outer_count, radius, settings.edge_correction);
  const auto inner_weights =
      inner.weights(inner_count, radius * std::numbers::sqrt2 / 2, settings.edge_correction);

  // The photons, into their batches.
  double inner_sum = 0;
  for (int i = 0; i < nearest.count(); ++i) {
    const float distance2 = nearest.distance2(i);
    if (!(distance2 < rim)) continue;
    ++result.photons;
    const Photon& photon = map.photon(nearest.index(i));
    const Vec3d d = Vec3d(map.offset(local, nearest.index(i))) / radius;
    const double light = photon.power * weight(decode_direction(photon.direction));
    const double u = distance2 / radius2;
    result.batch[photon.batch % kBatches] += light * detail::kernel_shape(settings.kernel, u) *
                                             (1 - outer_weights.slope.dot(d));
    if (2 * u < 1) {
      inner_sum += light * detail::kernel_shape(settings.kernel, 2 * u) *
                   (1 - inner_weights.slope.dot(d));
    }
  }
  if (result.photons == 0) return result;
  if (!(outer_weights.normaliser > 0)) {
    result.batch = {};
    result.anomaly = true;
    return result;
  }

  const double norm = detail::kernel_norm(settings.kernel) / map.emitted();
  const double scale = norm / outer_weights.normaliser;
  double sum = 0;
  for (double& batch : result.batch) {
    batch *= scale * kBatches;
    sum += batch;
  }
  result.value = sum / kBatches;
  if (inner_weights.normaliser > 0) {
    result.bias = 2 * (result.value - inner_sum * norm / inner_weights.normaliser);
  }
  return result;
}

}  // namespace obscura
