#include "sensor/capture/view.h"

#include <algorithm>
#include <array>

namespace obscura {
namespace {

constexpr std::array<int, 2> kMostPlaces = {12, 9};

}  // namespace

CameraView view_of(const Camera& camera) {
  CameraView view;
  view.together = 4;
  const std::array<int, 2> pixels = {camera.columns(), camera.rows()};
  const std::array<int, 2> places = {std::min(pixels[0], kMostPlaces[0]), std::min(pixels[1], kMostPlaces[1])};
  for (int row = 0; row < places[1]; ++row) {
    for (int column = 0; column < places[0]; ++column) {
      const int x = (2 * column + 1) * pixels[0] / (2 * places[0]), y = (2 * row + 1) * pixels[1] / (2 * places[1]);
      std::array<Ray, 4> rays;
      bool all = true;
      for (std::size_t k = 0; k < 4; ++k) {
        const std::optional<Ray> ray = camera.ray(x + (k & 1 ? 0.75 : 0.25), y + (k & 2 ? 0.75 : 0.25));
        all = all && ray;
        if (ray) rays[k] = *ray;
      }
      if (all) view.rays.insert(view.rays.end(), rays.begin(), rays.end());
    }
  }
  const double right = pixels[0] + 1.0, bottom = pixels[1] + 1.0;
  const std::array<std::optional<Ray>, 4> corners = {camera.ray(-1, -1), camera.ray(right, -1),
                                                     camera.ray(right, bottom), camera.ray(-1, bottom)};
  const Projection projection = camera.settings().projection;
  if (projection == Projection::fisheye) {
    view.origins = {camera.settings().position_m};
    return view;
  }
  for (const auto& corner : corners) view.origins.push_back(corner->origin);
  for (std::size_t k = 0; k < 4; ++k) {
    const Ray &a = *corners[k], &b = *corners[(k + 1) % 4];
    const Vec3d along = projection == Projection::perspective ? b.direction : b.origin - a.origin;
    Vec3d inward = a.direction.cross(along).normalized();
    if (inward.dot(projection == Projection::perspective ? camera.forward() : corners[(k + 2) % 4]->origin - a.origin) <
        0)
      inward = -inward;
    view.sides.push_back({a.origin, inward});
  }
  view.sides.push_back({corners[0]->origin, camera.forward()});
  return view;
}

}  // namespace obscura
