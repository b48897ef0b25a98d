#include "sensor/camera.h"

#include <algorithm>
#include <cassert>
#include <cmath>

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
      ray.direction = unit(std::cos(angle) * forward_ + (sine_over_angle * x) * right_ +
                           (sine_over_angle * y) * up_);
      break;
    }
  }
  return ray;
}

}  // namespace obscura
