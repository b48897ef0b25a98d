#include "photon/spot/spot_region.h"

#include <algorithm>

namespace obscura::detail {
namespace {

/// Beyond this cosine between the axis and a corner a spot is no longer treated as a pyramid.
constexpr double kWidest = 0.2;
constexpr double kLargestBulge = 1;

}  // namespace

bool Fragment::cut(const HalfSpace& half) noexcept {
  std::array<double, kMost> height;
  bool in = false, out = false;
  for (std::size_t i = 0; i < size; ++i) {
    height[i] = half.height(corners[i]);
    (height[i] < 0 ? out : in) = true;
  }
  if (!out) return true;
  if (!in) {
    size = 0;
    return false;
  }
  std::array<Vec3d, kMost> left;
  std::array<int, kMost> left_sides;
  std::size_t count = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t j = i + 1 < size ? i + 1 : 0;
    if (height[i] >= 0) {
      left[count] = corners[i];
      left_sides[count++] = sides[i];
    }
    if ((height[i] < 0) == (height[j] < 0)) continue;
    left[count] = corners[i] + height[i] / (height[i] - height[j]) * (corners[j] - corners[i]);
    left_sides[count++] = height[i] < 0 ? sides[i] : kNoSide;
  }
  std::copy_n(left.begin(), count, corners.begin());
  std::copy_n(left_sides.begin(), count, sides.begin());
  size = count;
  return true;
}

SpotRegion::SpotRegion(const Spot& spot, const Vec3d& origin, double slack, const Mirror* mirror) : slack_(slack) {
  const std::array<Ray, 4>& rays = spot.corners;
  central_ = true;
  bool parallel = true;
  for (std::size_t i = 1; i < 4; ++i) {
    central_ = central_ && rays[i].origin == rays[0].origin;
    parallel = parallel && rays[i].direction == rays[0].direction;
  }
  axis_ = Vec3d(0);
  eye_ = Vec3d(0);
  for (const Ray& ray : rays) {
    axis_ += ray.direction;
    eye_ += 0.25 * (ray.origin - origin);
  }
  axis_ = axis_.normalized();
  if (central_) eye_ = rays[0].origin - origin;
  bounded_ = (central_ != parallel) && spot.bulge < kLargestBulge;

  // Planes through neighbouring corners, with the middle inside.
  std::array<Vec3d, 4> normals;
  if (central_ && bounded_) {
    double widest = 1;
    for (const Ray& ray : rays) widest = std::min(widest, ray.direction.dot(axis_));
    if (spot.bulge > 0) widest = std::cos(std::acos(std::clamp(widest, -1.0, 1.0)) + spot.bulge);
    bounded_ = widest > kWidest;
    for (std::size_t i = 0; i < 4 && bounded_; ++i) {
      const Vec3d& a = rays[i].direction;
      const Vec3d& b = rays[(i + 1) % 4].direction;
      // From differences, which narrow spots need: a x b = a x (b - a).
      Vec3d n = a.cross(b - a);
      if (n.dot(axis_) < 0) n = -n;
      const double length = n.length();
      if (!(length > 0)) {
        bounded_ = false;
        break;
      }
      n /= length;
      // Tilted outward until nothing of the spot is outside: n . d >= -lean (axis . d) for all of its rays d.
      double lean = std::sin(spot.bulge) / widest;
      for (std::size_t j = 0; j < 4; ++j) {
        if (j != i && j != (i + 1) % 4) lean = std::max(lean, -n.dot(rays[j].direction) / rays[j].direction.dot(axis_));
      }
      normals[i] = (n + lean * axis_).normalized();
    }
  } else if (bounded_) {
    for (std::size_t i = 0; i < 4; ++i) {
      starts_[i] = rays[i].origin - origin;
      Vec3d n = axis_.cross(rays[(i + 1) % 4].origin - rays[i].origin);
      if (n.dot(eye_ - starts_[i]) < 0) n = -n;
      const double length = n.length();
      bounded_ = bounded_ && length > 0;
      if (bounded_) normals[i] = n / length;
    }
  }
  if (bounded_) {
    for (std::size_t i = 0; i < 4; ++i) {
      planes_[count_++] = {normals[i], slack - normals[i].dot(central_ ? eye_ : starts_[i])};
      edges_[i] = axis_;
      if (!central_) continue;
      const Vec3d& before = normals[(i + 3) % 4];
      Vec3d edge = before.cross(normals[i]);
      if (edge.dot(axis_) < 0) edge = -edge;
      const double length = edge.length();
      // Neighbouring sides in one plane: the corner between them will do.
      edges_[i] = length > 1e-9 ? edge / length : rays[i].direction;
    }
  }
  // Nothing behind the eye.
  if (bounded_) planes_[count_++] = {axis_, slack - axis_.dot(eye_)};

  HalfSpace begin;
  if (mirror) {
    begin = *mirror;
    mirrored_ = true;
  } else if (std::all_of(rays.begin(), rays.end(), [](const Ray& ray) { return ray.t_min > 0; })) {
    std::array<Vec3d, 4> at;
    for (std::size_t i = 0; i < 4; ++i) at[i] = rays[i].at(rays[i].t_min) - origin;
    Vec3d n = (at[2] - at[0]).cross(at[3] - at[1]);
    n = n.length() > 0 ? n.normalized() : axis_;
    if (n.dot(axis_) < 0) n = -n;
    double offset = -kInfinity;
    for (const Vec3d& corner : at) offset = std::max(offset, -n.dot(corner));
    begin = {n, offset};
    mirrored_ = true;
  }
  if (mirrored_) {
    start_ = count_;
    planes_[count_++] = begin;
  }
}

double SpotRegion::spread() const noexcept {
  if (!bounded_) return 2 * kPi;
  double most = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < i; ++j)
      most = std::max(most, (central_ ? edges_[i] - edges_[j] : starts_[i] - starts_[j]).length());
  }
  return central_ ? 2 * std::asin(std::min(1.0, 0.5 * most)) : most;
}

double SpotRegion::distance_to(const Vec3d& x) const noexcept {
  if (!bounded_) return 0;
  double least = kInfinity;
  bool outside = false;
  for (std::size_t i = 0; i < 4; ++i) {
    const double below = planes_[i].height(x) - slack_;
    if (below >= 0) continue;
    outside = true;
    const Vec3d foot = x - below * planes_[i].normal;
    bool on_it = height(foot) >= 0;
    for (std::size_t j = 0; j < 4 && on_it; ++j) on_it = j == i || planes_[j].height(foot) - slack_ >= 0;
    if (on_it) least = std::min(least, -below);
  }
  if (!outside) return 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3d to = x - edge_start(i);
    const double along = std::max(0.0, to.dot(edges_[i]));
    least = std::min(least, (to - along * edges_[i]).length());
  }
  return least;
}

}  // namespace obscura::detail
