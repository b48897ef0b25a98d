// The cubature of the unit ball, its random rotation, and the weights that remove an edge's first-order
// bias.
#include "photon/density.h"

#include <bit>
#include <vector>

namespace obscura::detail {
namespace {

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

std::vector<BallPoint> make_points(Kernel kernel) {
  // Roberts' R3 sequence: multiples of the powers of the root of t^4 = t + 1.
  constexpr double kRoot = 1.2207440846057596;
  std::vector<BallPoint> points;
  points.reserve(kBallPoints);
  for (int i = 0; i < kBallPoints / 2; ++i) {
    const auto fraction = [i](double step) {
      const double t = 0.5 + (i + 1) * step;
      return t - std::floor(t);
    };
    const double rho = radius_of_mass(kernel, fraction(1 / kRoot));
    const double z = fraction(1 / (kRoot * kRoot));
    const double angle = 2 * kPi * fraction(1 / (kRoot * kRoot * kRoot));
    const double s = std::sqrt(1 - z * z);
    const double u = rho * rho;
    const double inner = 2 * u < 1 ? kernel_shape(kernel, 2 * u) / kernel_shape(kernel, u) : 0;
    const Vec3d d = rho * Vec3d(s * std::cos(angle), s * std::sin(angle), z);
    points.push_back({d.x, d.y, d.z, inner});
    points.push_back({-d.x, -d.y, -d.z, inner});
  }
  return points;
}

}  // namespace

std::span<const BallPoint> ball_points(Kernel kernel) noexcept {
  static const std::array<std::vector<BallPoint>, 4> tables = {
      make_points(Kernel::constant), make_points(Kernel::epanechnikov), make_points(Kernel::cone),
      make_points(Kernel::gaussian)};
  return tables[static_cast<std::size_t>(kernel)];
}

Rotation rotation_at(const Vec3d& x) noexcept {
  std::uint64_t state = 0;
  const auto next = [&state](std::uint64_t salt) {  // SplitMix64 of Steele et al., OOPSLA 2014
    state += salt + 0x9E3779B97F4A7C15u;
    std::uint64_t z = state;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    state = z ^ z >> 31;
    return static_cast<double>(state >> 11) * 0x1p-53;
  };
  for (int axis = 0; axis < 3; ++axis) next(std::bit_cast<std::uint64_t>(x[axis]));

  // A uniform unit quaternion: Shoemake, "Uniform random rotations" (Graphics Gems III, 1992).
  const double u = next(1), v = 2 * kPi * next(2), w = 2 * kPi * next(3);
  const double a = std::sqrt(1 - u) * std::sin(v), b = std::sqrt(1 - u) * std::cos(v);
  const double c = std::sqrt(u) * std::sin(w), d = std::sqrt(u) * std::cos(w);
  return {{1 - 2 * (b * b + c * c), 2 * (a * b + c * d), 2 * (a * c - b * d)},
          {2 * (a * b - c * d), 1 - 2 * (a * a + c * c), 2 * (b * c + a * d)},
          {2 * (a * c + b * d), 2 * (b * c - a * d), 1 - 2 * (a * a + b * b)}};
}

Moments3::Weights Moments3::weights(double count, double radius, bool correct) const noexcept {
  Weights result;
  if (!(zeroth_ > 0) || !(count > 0)) return result;
  // Sums to integrals: the kernel's own norm and 1 / radius^3 are left to the caller and to this.
  const double scale = radius * radius * radius / count;
  result.normaliser = zeroth_ * scale;
  if (!correct) return result;

  // slope = M2^-1 M1, by Cholesky's factors; a little is added to the diagonal so that a sheet or a
  // single point of medium has a solution too.
  const double ridge = 1e-3 * zeroth_;
  const double l00 = std::sqrt(xx_ + ridge);
  const double l10 = xy_ / l00, l20 = xz_ / l00;
  const double l11 = std::sqrt(yy_ + ridge - l10 * l10);
  const double l21 = (yz_ - l20 * l10) / l11;
  const double l22 = std::sqrt(zz_ + ridge - l20 * l20 - l21 * l21);
  const double y0 = first_.x / l00;
  const double y1 = (first_.y - l10 * y0) / l11;
  const double y2 = (first_.z - l20 * y0 - l21 * y1) / l22;
  const double z = y2 / l22;
  const double y = (y1 - l21 * z) / l11;
  const double x = (y0 - l10 * y - l20 * z) / l00;
  const Vec3d slope(x, y, z);

  // Not more than photons can bear: no weight below -1.5, no normaliser below a fifth.
  const double steepest = slope.length();
  const double removed = slope.dot(first_);
  double share = steepest > 2.5 ? 2.5 / steepest : 1;
  if (share * removed > 0.8 * zeroth_) share = 0.8 * zeroth_ / removed;
  result.slope = share * slope;
  result.normaliser = (zeroth_ - share * removed) * scale;
  return result;
}

}  // namespace obscura::detail
