// The random potential and its curl.
#include "octree/source/eddies.h"

namespace obscura::detail {
namespace {

constexpr std::uint32_t kPurpose = 0x65646479;  // this file's random numbers

/// The three quadratic B-spline weights around a point and their derivatives; the first lattice index.
struct Spline {
  int first;
  std::array<float, 3> weight, slope;

  explicit Spline(double x) noexcept {
    // A multiple of the period makes the number positive, where truncation is floor.
    constexpr int periods = 1 << 28;
    const int centre = static_cast<int>(x + (periods + 0.5));
    const auto t = static_cast<float>(x - (centre - periods));  // [-0.5, 0.5)
    first = centre - 1;
    weight = {0.5f * (0.5f - t) * (0.5f - t), 0.75f - t * t, 0.5f * (0.5f + t) * (0.5f + t)};
    slope = {t - 0.5f, -2 * t, t + 0.5f};
  }
};

}  // namespace

CurlNoise::CurlNoise(std::uint64_t seed) : potential_(kSize * kSize * kSize) {
  Stream random(seed, 0, kPurpose);
  for (Float4& p : potential_)
    for (int axis = 0; axis < 3; ++axis) p[axis] = static_cast<float>(2 * random.uniform() - 1);

  // Unit RMS, measured at seeded points.
  double sum = 0;
  constexpr int samples = 4096;
  for (int i = 0; i < samples; ++i) {
    const Vec3d point(random.uniform() * kSize, random.uniform() * kSize, random.uniform() * kSize);
    sum += raw(point).length2();
  }
  scale_ = 1 / std::sqrt(sum / samples);
}

Vec3d CurlNoise::raw(const Vec3d& point) const noexcept {
  const Spline x(point.x), y(point.y), z(point.z);
  // Gradients of the three components of the potential.
  Float4 dx{}, dy{}, dz{};
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j) {
      const int row = (((z.first + k) & (kSize - 1)) * kSize + ((y.first + j) & (kSize - 1))) * kSize;
      const Float4 a = potential_[row + (x.first & (kSize - 1))];
      const Float4 b = potential_[row + ((x.first + 1) & (kSize - 1))];
      const Float4 c = potential_[row + ((x.first + 2) & (kSize - 1))];
      const Float4 value = a * x.weight[0] + b * x.weight[1] + c * x.weight[2];
      const Float4 slope = a * x.slope[0] + b * x.slope[1] + c * x.slope[2];
      dx += slope * (y.weight[j] * z.weight[k]);
      dy += value * (y.slope[j] * z.weight[k]);
      dz += value * (y.weight[j] * z.slope[k]);
    }
  return {double(dy[2]) - dz[1], double(dz[0]) - dx[2], double(dx[1]) - dy[0]};
}

Vec3d CurlNoise::operator()(const Vec3d& point) const noexcept { return raw(point) * scale_; }

Eddies::Eddies(std::uint64_t seed, double strength, double widest_m, double voxel_m)
    : strength_(0.6 * strength), noise_(seed) {
  if (strength == 0) return;
  Stream random(seed, 1, kPurpose);
  for (double size = 6 * widest_m; size > 3 * voxel_m && sizes_.size() < 12; size /= 2) {
    sizes_.push_back(size);
    offsets_.emplace_back(32 * random.uniform(), 32 * random.uniform(), 32 * random.uniform());
  }
}

Vec3d Eddies::origin_of(const Vec3d& x, double width_m) const noexcept {
  Vec3d from = x;
  // The smallest eddies acted last, so they are undone first.
  for (std::size_t i = sizes_.size(); i-- > 0;) {
    const double amplitude = strength_ * std::min(sizes_[i], 2 * width_m) / kSteps;
    for (int step = 0; step < kSteps; ++step) from -= noise_(from * (2 / sizes_[i]) + offsets_[i]) * amplitude;
  }
  return from;
}

}  // namespace obscura::detail
