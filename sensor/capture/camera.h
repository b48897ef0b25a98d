// The camera: from a place on the image to a ray. Three projections, square pixels, double precision.
#pragma once

#include <array>
#include <optional>

#include "octree/base/error.h"
#include "octree/base/math.h"
#include "photon/world/footprint.h"

namespace obscura {

struct Spot;  // photon/spot/spot.h

enum class Projection { perspective, orthographic, fisheye };

struct CameraSettings {
  Vec3d position_m{0, 0, 0};
  Vec3d look_at_m{0, 1, 0};
  Vec3d up{0, 0, 1};
  Projection projection = Projection::perspective;
  /// Full angle: across the image's width (perspective, below 180) or across its shorter side
  /// (fisheye, up to 360).
  double fov_deg = 20;
  /// Width of the image in metres (orthographic), above 0 there.
  double width_m = 0;
  /// Columns and rows.
  std::array<int, 2> resolution{320, 240};

  bool operator==(const CameraSettings&) const = default;
};

/// What is wrong with the settings, or nothing. `where` is the key as in a scene file's "sensor".
std::optional<Problem> camera_problem(const CameraSettings& settings);

/// Immutable; a ray costs a few dozen flops and depends on nothing but its arguments.
///
/// Image plane: px runs from 0 at the left edge to columns() at the right, py from 0 at the top edge
/// to rows() at the bottom; pixel (x, y) covers [x, x+1) x [y, y+1). The image's x is direction x up.
class Camera {
 public:
  /// @pre camera_problem(settings) has nothing to say (asserted).
  explicit Camera(const CameraSettings& settings);

  /// The ray into the scene from a place on the image, with a unit direction: it looks against the
  /// light. Nothing where a fisheye has no direction, beyond 180 degrees from its axis.
  std::optional<Ray> ray(double px, double py) const noexcept;

  /// What the rays of a rectangle on the image see. A fisheye's bulge bounds how far its straight lines bend
  /// from planes; where the rectangle reaches beyond 180 degrees from the axis, or is wider than half a
  /// radian, the spot holds all directions. Nothing where no corner has a ray.
  std::optional<Spot> spot(double px0, double py0, double px1, double py1) const noexcept;

  /// The footprint of rays that each stand for the share, (0, 1], of a pixel: that of a square no wider than the
  /// narrowest pixel's.
  Footprint footprint(double pixel_share) const noexcept;

  int columns() const noexcept { return settings_.resolution[0]; }
  int rows() const noexcept { return settings_.resolution[1]; }
  const CameraSettings& settings() const noexcept { return settings_; }

  /// The camera's right-handed frame, unit vectors: image x, image up, and against the view.
  const Vec3d& right() const noexcept { return right_; }
  const Vec3d& up() const noexcept { return up_; }
  const Vec3d& forward() const noexcept { return forward_; }

 private:
  CameraSettings settings_;
  Vec3d right_;
  Vec3d up_;
  Vec3d forward_;
  double scale_;  // per pixel from the centre: tangent, metres, or radians from the axis
};

}  // namespace obscura
