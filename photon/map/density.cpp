// The cubature of the unit ball, its random rotation, and the weights that remove an edge's first-order
// bias.
#include "photon/map/density.h"

#include <algorithm>
#include <bit>
#include <cstddef>

namespace obscura::detail {
namespace {

// Bounds of the edge correction, by experiment (photon/METHODS.md, "The photon map"): what a photon may count against,
// how much of the denominator may be removed, what must remain of it.
constexpr double kRidge = 0.005;
constexpr double kSteepest = 2.5;
constexpr double kMostRemoved = 0.75;
constexpr double kLeast = 0.1;

/// Mass of the kernel inside the radius rho of the unit ball, by Simpson's rule on rho^2 f.
double mass_within(Kernel kernel, double rho) noexcept {
  constexpr int kSteps = 64;
  const double h = rho / kSteps;
  double sum = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double t = i * h;
    const double factor = i == 0 || i == kSteps ? 1 : (i % 2 ? 4 : 2);
    sum += factor * t * t * kernel_shape(kernel, t * t);
  }
  return 4 * kPi * kernel_norm(kernel) * sum * h / 3;
}

double radius_of_mass(Kernel kernel, double mass) noexcept {
  double low = 0, high = 1;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (mass_within(kernel, middle) < mass ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

using Points = std::array<BallPoint, kRoundPoints>;

Points make_points(Kernel kernel) noexcept {
  // Directions of a Fibonacci lattice on the half sphere; radii at the middles of equal masses, dealt
  // out in the order of a second irrational number (the plastic number's inverse).
  constexpr int kPairs = kRoundPoints / 2;
  constexpr double kGolden = 0.6180339887498949, kPlastic = 0.7548776662466927;
  Points points;
  double inner_sum = 0;
  for (int i = 0; i < kPairs; ++i) {
    const auto place = [](int j) {
      const double t = (j + 0.5) * kPlastic;
      return t - std::floor(t);
    };
    int rank = 0;
    for (int j = 0; j < kPairs; ++j) rank += place(j) < place(i);
    const double rho = radius_of_mass(kernel, (rank + 0.5) / kPairs);
    const double z = (i + 0.5) / kPairs;
    const double s = std::sqrt(1 - z * z);
    const double angle = 2 * kPi * kGolden * i;
    const Vec3d d = rho * Vec3d(s * std::cos(angle), s * std::sin(angle), z);
    const double u = rho * rho;
    const double inner = 2 * u < 1 ? kernel_shape(kernel, 2 * u) / kernel_shape(kernel, u) : 0;
    points[2 * i] = {d.x, d.y, d.z, inner};
    points[2 * i + 1] = {-d.x, -d.y, -d.z, inner};
    inner_sum += 2 * inner;
  }
  for (BallPoint& point : points) point.inner *= kRoundPoints / inner_sum;
  return points;
}

}  // namespace

std::span<const BallPoint, kRoundPoints> ball_points(Kernel kernel) noexcept {
  static const std::array<Points, 4> tables = {make_points(Kernel::constant), make_points(Kernel::epanechnikov),
                                               make_points(Kernel::cone), make_points(Kernel::gaussian)};
  return tables[static_cast<std::size_t>(kernel)];
}

Rotation rotation_at(const Vec3d& key, int round) noexcept {
  auto state = static_cast<std::uint64_t>(round);
  const auto next = [&state](std::uint64_t salt) {  // SplitMix64 of Steele et al., OOPSLA 2014
    state += salt + 0x9E3779B97F4A7C15u;
    std::uint64_t z = state;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    state = z ^ z >> 31;
    return static_cast<double>(state >> 11) * 0x1p-53;
  };
  for (int axis = 0; axis < 3; ++axis) next(std::bit_cast<std::uint64_t>(key[axis]));

  // A uniform unit quaternion: Shoemake, "Uniform random rotations" (Graphics Gems III, 1992).
  const double u = next(1), v = 2 * kPi * next(2), w = 2 * kPi * next(3);
  const double a = std::sqrt(1 - u) * std::sin(v), b = std::sqrt(1 - u) * std::cos(v);
  const double c = std::sqrt(u) * std::sin(w), d = std::sqrt(u) * std::cos(w);
  return {{1 - 2 * (b * b + c * c), 2 * (a * b + c * d), 2 * (a * c - b * d)},
          {2 * (a * b - c * d), 1 - 2 * (a * a + c * c), 2 * (b * c + a * d)},
          {2 * (a * c + b * d), 2 * (b * c - a * d), 1 - 2 * (a * a + b * b)}};
}

namespace {

void accumulate(BallMoments& sum, const BallMoments& m, double sign) noexcept {
  sum.zeroth += sign * m.zeroth;
  sum.first += sign * m.first;
  sum.xx += sign * m.xx;
  sum.yy += sign * m.yy;
  sum.zz += sign * m.zz;
  sum.xy += sign * m.xy;
  sum.xz += sign * m.xz;
  sum.yz += sign * m.yz;
}

/// M2^-1 M1 by Cholesky's factors, in bounds that the photons' noise can bear.
Vec3d edge_slope(const BallMoments& m) noexcept {
  // A little on the diagonal, so that a sheet or a single point of medium has a solution too.
  const double ridge = kRidge * m.zeroth;
  const double l00 = std::sqrt(m.xx + ridge);
  const double l10 = m.xy / l00, l20 = m.xz / l00;
  const double l11 = std::sqrt(std::max(m.yy - l10 * l10, 0.0) + ridge);
  const double l21 = (m.yz - l20 * l10) / l11;
  const double l22 = std::sqrt(std::max(m.zz - l20 * l20 - l21 * l21, 0.0) + ridge);
  const double y0 = m.first.x / l00;
  const double y1 = (m.first.y - l10 * y0) / l11;
  const double y2 = (m.first.z - l20 * y0 - l21 * y1) / l22;
  const double z = y2 / l22;
  const double y = (y1 - l21 * z) / l11;
  const double x = (y0 - l10 * y - l20 * z) / l00;
  const Vec3d slope(x, y, z);

  const double steepest = slope.length();
  const double removed = slope.dot(m.first);
  double share = steepest > kSteepest ? kSteepest / steepest : 1;
  if (share * removed > kMostRemoved * m.zeroth) share = kMostRemoved * m.zeroth / removed;
  return share * slope;
}

}  // namespace

PhotonWeight photon_weight(std::span<const BallMoments> rounds, bool correct) noexcept {
  PhotonWeight weight;
  BallMoments all;
  for (const BallMoments& round : rounds) accumulate(all, round, 1);
  if (!(all.zeroth > 0)) return weight;

  // Each round's denominator with a slope from the other rounds: what chose the slope must not judge
  // it, or noise in the first moment makes every denominator too small.
  const auto count = static_cast<double>(rounds.size());
  double sum = 0, squares = 0;
  Vec3d slope(0, 0, 0);
  for (const BallMoments& round : rounds) {
    double denominator = round.zeroth;
    if (correct) {
      BallMoments others = all;
      accumulate(others, round, -1);
      if (others.zeroth > 1e-9 * all.zeroth) {
        const Vec3d from_others = edge_slope(others);
        denominator -= from_others.dot(round.first);
        slope += from_others / count;
      }
    }
    sum += denominator;
    squares += denominator * denominator;
  }
  const double mean = std::max(sum / count, kLeast * all.zeroth / count);
  weight.variance = std::max(squares / count - (sum / count) * (sum / count), 0.0) / ((count - 1) * mean * mean);

  // 1 / mean is too large by the variance of the mean, in second order.
  weight.level = std::max(1 - weight.variance, 0.1) * kRoundPoints / mean;
  weight.slope = weight.level * slope;
  return weight;
}

}  // namespace obscura::detail
