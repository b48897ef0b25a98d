#include "sensor/capture/camera.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "photon/spot/spot.h"

namespace obscura {
namespace {

bool finite(const Vec3d& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

// The length by hypot: Imath's own squares first, which over- and underflows.
Vec3d unit(const Vec3d& v) {
  const double length = std::hypot(v.x, v.y, v.z);
  return length > 0 ? v / length : Vec3d(0, 0, 0);
}

// Below this sine between view and up, the picture's rotation is rounding error.
constexpr double kParallelSine = 1e-9;

}  // namespace

std::optional<Problem> camera_problem(const CameraSettings& s) {
  if (!finite(s.position_m)) return Problem{"position_m", "is not finite", "give three numbers"};
  if (!finite(s.look_at_m)) return Problem{"look_at_m", "is not finite", "give three numbers"};
  const Vec3d view = unit(s.look_at_m - s.position_m);
  if (view == Vec3d(0, 0, 0)) {
    return Problem{"look_at_m", "is the sensor's own position", "name a point in front of it"};
  }
  if (!finite(s.up) || unit(s.up) == Vec3d(0, 0, 0)) {
    return Problem{"up", "is not a direction", "give three numbers, not all 0"};
  }
  if (unit(s.up).cross(view).length() < kParallelSine) {
    return Problem{"up", "is parallel to the view", "choose another direction, [0, 1, 0] for one"};
  }
  for (const int side : s.resolution) {
    if (side < 1) return Problem{"resolution", "has a side below 1", "give columns and rows"};
  }
  if (s.projection == Projection::orthographic) {
    if (!(s.width_m > 0) || !std::isfinite(s.width_m)) {
      return Problem{"width_m", "is not above 0", "give the image's width in metres"};
    }
  } else if (s.projection == Projection::perspective) {
    if (!(s.fov_deg > 0 && s.fov_deg < 180)) {
      return Problem{"fov_deg", "is not between 0 and 180", "use a fisheye for wider views"};
    }
  } else if (!(s.fov_deg > 0 && s.fov_deg <= 360)) {
    return Problem{"fov_deg", "is not between 0 and 360", "give the angle across the shorter side"};
  }
  return std::nullopt;
}

Camera::Camera(const CameraSettings& settings) : settings_(settings) {
  assert(!camera_problem(settings));
  forward_ = unit(settings.look_at_m - settings.position_m);
  right_ = unit(forward_.cross(unit(settings.up)));
  up_ = right_.cross(forward_);

  const double half_angle = settings.fov_deg * (kPi / 360);
  const double half_width = 0.5 * columns();
  switch (settings.projection) {
    case Projection::perspective:
      scale_ = std::tan(half_angle) / half_width;
      break;
    case Projection::orthographic:
      scale_ = 0.5 * settings.width_m / half_width;
      break;
    case Projection::fisheye:
      scale_ = half_angle / (0.5 * std::min(columns(), rows()));
      break;
  }
}

std::optional<Ray> Camera::ray(double px, double py) const noexcept {
  const double x = (px - 0.5 * columns()) * scale_;
  const double y = (0.5 * rows() - py) * scale_;
  Ray ray;
  ray.origin = settings_.position_m;
  switch (settings_.projection) {
    case Projection::perspective:
      ray.direction = unit(forward_ + x * right_ + y * up_);
      break;
    case Projection::orthographic:
      ray.origin += x * right_ + y * up_;
      ray.direction = forward_;
      break;
    case Projection::fisheye: {
      const double angle = std::hypot(x, y);
      if (angle > kPi) return std::nullopt;
      const double sine_over_angle = angle > 0 ? std::sin(angle) / angle : 1;
      ray.direction = unit(std::cos(angle) * forward_ + (sine_over_angle * x) * right_ + (sine_over_angle * y) * up_);
      break;
    }
  }
  return ray;
}

std::optional<Spot> Camera::spot(double px0, double py0, double px1, double py1) const noexcept {
  constexpr double kWidest = 0.5;  // radians, of a fisheye's rectangle
  const std::array<std::optional<Ray>, 4> rays{ray(px0, py0), ray(px1, py0), ray(px1, py1), ray(px0, py1)};
  Spot spot;
  bool any = false, all = true;
  for (std::size_t i = 0; i < 4; ++i) {
    any = any || rays[i];
    all = all && rays[i];
    if (rays[i]) spot.corners.fill(*rays[i]);
  }
  if (!any) return std::nullopt;
  for (std::size_t i = 0; i < 4; ++i) {
    if (rays[i]) spot.corners[i] = *rays[i];
  }
  if (settings_.projection != Projection::fisheye) return spot;

  // A straight line of the image, followed at one radian per radian, is a curve on the sphere of
  // directions whose covariant acceleration is at most 2/3 of its angle from the axis and at most 0.66;
  // so it leaves the great circle between its ends by no more than that times (1 / cos(length/2) - 1)
  // (sensor/METHODS.md, "Cameras").
  const double width = std::abs(px1 - px0) * scale_, height = std::abs(py1 - py0) * scale_;
  const double x = std::max(std::abs(px0 - 0.5 * columns()), std::abs(px1 - 0.5 * columns())) * scale_;
  const double y = std::max(std::abs(py0 - 0.5 * rows()), std::abs(py1 - 0.5 * rows())) * scale_;
  const double length = std::max(width, height);
  const double farthest = std::hypot(x, y);
  // Rounding near the antipode, where all directions of a rectangle are nearly one.
  if (!all || length > kWidest || farthest > kPi - 1e-6) {
    spot.bulge = kPi;
  } else {
    spot.bulge = std::min(0.66, 2.0 / 3.0 * farthest) * (1 / std::cos(0.5 * length) - 1);
  }
  return spot;
}

Footprint Camera::footprint(double pixel_share) const noexcept {
  const double side = std::sqrt(pixel_share) * scale_;
  const double corner = 0.5 * std::hypot(columns(), rows()) * scale_;  // farthest from the axis
  switch (settings_.projection) {
    case Projection::orthographic:
      return {side, 0};
    case Projection::perspective:
      // Along the radius, the angle is the arc tangent.
      return {0, side / (1 + corner * corner)};
    case Projection::fisheye:
      // Around the axis, circles shrink beyond 90 degrees.
      return {0, corner < kPi ? side * std::sin(corner) / corner : 0.0};
  }
  return {};
}

}  // namespace obscura
