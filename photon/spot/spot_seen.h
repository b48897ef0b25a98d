// What a spot is known to hold, and whether that meets a criterion.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "photon/spot/spot.h"
#include "photon/world/world.h"

namespace obscura::detail {

/// A face, or the part of it in the spot.
struct SeenFace {
  std::uint32_t surface = 0;
  int material = 0;          ///< of the World, or one of those below
  Vec3d normal{0, 0, 1};     ///< unit, on the side that is seen
  double curl = 0;           ///< radians by which normals differ from it
  double near = 0, far = 0;  ///< m along rays
  double K_low = 0, K_high = 0;
  bool radiance_given = false;           ///< in place of a temperature
  double angle_low = 0, angle_high = 0;  ///< radians between rays and normal

  static constexpr int kBack = -1;  ///< the absorbing side of a one-sided face
  static constexpr int kHot = -2;   ///< a hot sphere's
};

/// Sums up the sights of a spot; each call says whether a criterion is met from now on.
class Seen {
 public:
  Seen(const World& world, const SpotThresholds& thresholds) : world_(world), asked_(thresholds) {
    if (asked_.normal) chord2_ = chord2(*asked_.normal), half_chord2_ = chord2(0.5 * *asked_.normal);
  }

  void clear();
  Criterion add(const SeenFace& sight);
  Criterion add_sky();
  /// Of sun or moon; counts as a polygon.
  Criterion add_disc();

 private:
  struct Normal {
    Vec3d direction;
    double curl;
  };
  struct Kind {
    std::uint32_t surface;
    int material;
    Normal normal;
    double K_low, K_high;
    bool radiance_given;
  };

  /// The square of the distance between unit vectors that enclose an angle.
  static double chord2(double angle) noexcept {
    const double chord = 2 * std::sin(0.5 * std::clamp(angle, 0.0, kPi));
    return angle < kPi ? chord * chord : kInfinity;
  }
  /// More than an angle apart, whose chord2() is given.
  static bool apart(const Normal& a, const Normal& b, double angle, double chord2) noexcept;
  bool new_kind(const SeenFace& sight);
  bool normals_differ(const SeenFace& sight);
  bool temperatures_differ(const SeenFace& sight);
  bool emissivities_differ(const SeenFace& sight);

  const World& world_;
  SpotThresholds asked_;
  double chord2_ = 0, half_chord2_ = 0;
  int others_ = 0;  // sky and discs
  int faces_ = 0;
  bool sky_ = false;
  std::vector<Kind> kinds_;
  std::vector<int> materials_;
  std::vector<Normal> normals_;
  std::size_t central_ = 0;  // of the normals, from the front: near the first
  double near_ = kInfinity, far_ = 0;
  double K_low_ = kInfinity, K_high_ = -kInfinity;
  bool plain_ = false, given_ = false;  // temperatures; radiances in their place
  std::uint32_t giver_ = 0;
  std::vector<double> emissivity_low_, emissivity_high_;  // per interval
  int last_plain_material_ = -3;
};

}  // namespace obscura::detail
