// Cameras against formulas by hand, and the solid angle of their pixels against the whole.
#include "sensor/capture/camera.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "photon/spot/spot.h"

using namespace obscura;

namespace {

CameraSettings looking_north(Projection projection, double fov_deg, int columns, int rows) {
  CameraSettings settings;
  settings.position_m = {1, 2, 3};
  settings.look_at_m = {1, 12, 3};
  settings.projection = projection;
  settings.fov_deg = fov_deg;
  settings.resolution = {columns, rows};
  return settings;
}

void check_close(const Vec3d& a, const Vec3d& b, double tolerance = 1e-14) {
  INFO(a.x << ' ' << a.y << ' ' << a.z << " against " << b.x << ' ' << b.y << ' ' << b.z);
  CHECK((a - b).length() <= tolerance);
}

// Solid angle under which a triangle of unit directions is seen (Van Oosterom and Strackee, IEEE
// Trans. Biomed. Eng. 30, 1983).
double solid_angle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  return 2 * std::atan2(a.dot(b.cross(c)), 1 + a.dot(b) + b.dot(c) + c.dot(a));
}

// The sum over pixels, each as the two spherical triangles of its corners; signed by handedness.
double pixels_solid_angle(const Camera& camera, const std::function<bool(double, double)>& counts) {
  double sum = 0;
  for (int y = 0; y < camera.rows(); ++y) {
    for (int x = 0; x < camera.columns(); ++x) {
      if (!counts(x + 0.5, y + 0.5)) continue;
      const Vec3d a = camera.ray(x, y)->direction, b = camera.ray(x + 1, y)->direction,
                  c = camera.ray(x + 1, y + 1)->direction, d = camera.ray(x, y + 1)->direction;
      sum += solid_angle(a, c, d) + solid_angle(a, b, c);
    }
  }
  return sum;
}

}  // namespace

TEST_CASE("the perspective camera's centre and corners are those of the pinhole", "[sensor][camera]") {
  const Camera camera(looking_north(Projection::perspective, 90, 320, 240));
  check_close(camera.ray(160, 120)->direction, {0, 1, 0});
  check_close(camera.ray(160, 120)->origin, {1, 2, 3});
  // tan 45 = 1 across the half width, 0.75 across the half height; the left is west, the top is up.
  const double length = std::sqrt(1 + 1 + 0.75 * 0.75);
  check_close(camera.ray(0, 0)->direction, Vec3d(-1, 1, 0.75) / length);
  check_close(camera.ray(320, 0)->direction, Vec3d(1, 1, 0.75) / length);
  check_close(camera.ray(0, 240)->direction, Vec3d(-1, 1, -0.75) / length);
  check_close(camera.ray(320, 240)->direction, Vec3d(1, 1, -0.75) / length);
}

TEST_CASE("the field of view is the full horizontal angle at any width", "[sensor][camera]") {
  for (const double fov : {1e-4, 0.1, 20.0, 120.0, 179.9}) {
    const Camera camera(looking_north(Projection::perspective, fov, 301, 7));
    const Vec3d left = camera.ray(0, 3.5)->direction, right = camera.ray(301, 3.5)->direction;
    const double angle = 2 * std::atan2((left - right).length(), (left + right).length());
    CHECK(angle == Approx(fov * kPi / 180).epsilon(1e-9));
    // A twin: the half angle, or the vertical one, would be seen.
    CHECK(angle != Approx(fov * kPi / 360).epsilon(1e-3));
  }
}

TEST_CASE("the picture is right-handed: image x is direction x up", "[sensor][camera]") {
  CameraSettings settings = looking_north(Projection::perspective, 40, 64, 48);
  settings.look_at_m = settings.position_m + Vec3d(0, 0, -5);  // straight down, north up
  settings.up = {0, 1, 0};
  const Camera camera(settings);
  CHECK(camera.ray(64, 24)->direction.x > 0);  // east is right
  CHECK(camera.ray(32, 0)->direction.y > 0);   // north is up
  check_close(camera.right(), camera.forward().cross(camera.up()));
}

TEST_CASE("up need not be square to the view, nor a unit vector", "[sensor][camera]") {
  CameraSettings settings = looking_north(Projection::perspective, 40, 64, 48);
  const Camera camera(settings);
  settings.up = {0, 3, 7};
  const Camera tilted(settings);
  check_close(camera.ray(5, 7)->direction, tilted.ray(5, 7)->direction);
}

TEST_CASE("orthographic rays are parallel and span the width", "[sensor][camera]") {
  CameraSettings settings = looking_north(Projection::orthographic, 20, 200, 100);
  settings.width_m = 8;
  const Camera camera(settings);
  check_close(camera.ray(0, 0)->origin, {1 - 4, 2, 3 + 2});
  check_close(camera.ray(200, 100)->origin, {1 + 4, 2, 3 - 2});
  check_close(camera.ray(13, 77)->direction, {0, 1, 0});
}

TEST_CASE("fisheye angles are in proportion to the distance from the centre", "[sensor][camera]") {
  const Camera camera(looking_north(Projection::fisheye, 180, 300, 200));
  check_close(camera.ray(150, 100)->direction, {0, 1, 0});
  check_close(camera.ray(150, 0)->direction, {0, 0, 1});  // the shorter side spans the fov
  check_close(camera.ray(250, 100)->direction, {1, 0, 0});
  check_close(camera.ray(200, 100)->direction, Vec3d(1, 1, 0) / std::sqrt(2.0));
  check_close(camera.ray(300, 100)->direction, Vec3d(1, -1, 0) / std::sqrt(2.0));  // beyond, it goes on
}

TEST_CASE("a fisheye has no ray beyond 180 degrees from its axis", "[sensor][camera]") {
  const Camera camera(looking_north(Projection::fisheye, 360, 100, 100));
  CHECK(camera.ray(50, 50));
  CHECK(camera.ray(99.9, 50));
  CHECK(!camera.ray(100.1, 50));
  CHECK(!camera.ray(0, 0));
  check_close(camera.ray(100 - 1e-9, 50)->direction, {0, -1, 0}, 1e-9);
}

TEST_CASE("the pixels of a perspective image add up to its pyramid", "[sensor][camera]") {
  const double fov = 70 * kPi / 180;
  const Camera camera(looking_north(Projection::perspective, 70, 48, 36));
  const double a = std::tan(fov / 2), b = a * 36 / 48;
  // Right rectangular pyramid: 4 asin(ab / sqrt((1 + a^2)(1 + b^2))) with half sides a, b at distance 1.
  const double whole = 4 * std::asin(a * b / std::sqrt((1 + a * a) * (1 + b * b)));
  const double sum = pixels_solid_angle(camera, [](double, double) { return true; });
  CHECK(sum == Approx(whole).epsilon(1e-12));
  // A twin: one column less is seen.
  CHECK(pixels_solid_angle(camera, [](double x, double) { return x > 1; }) < whole * (1 - 1e-3));
}

TEST_CASE("the pixels of a fisheye add up to its cap", "[sensor][camera]") {
  for (const double fov_deg : {90.0, 180.0, 300.0}) {
    const Camera camera(looking_north(Projection::fisheye, fov_deg, 400, 400));
    const double sum =
        pixels_solid_angle(camera, [](double x, double y) { return std::hypot(x - 200, y - 200) <= 200; });
    const double cap = 2 * kPi * (1 - std::cos(fov_deg * kPi / 360));
    CHECK(sum == Approx(cap).epsilon(2e-3));  // pixels on the circle count by their centres
  }
}

TEST_CASE("directions are unit vectors from everywhere, at every angle", "[sensor][camera]") {
  for (const double far : {0.0, 1e7, -1e7}) {
    for (const double fov : {1e-4, 20.0, 179.9}) {
      CameraSettings settings = looking_north(Projection::perspective, fov, 640, 480);
      settings.position_m += Vec3d(far, far, far);
      settings.look_at_m += Vec3d(far, far, far);
      const Camera camera(settings);
      const Camera at_home(looking_north(Projection::perspective, fov, 640, 480));
      for (const auto& [x, y] : {std::pair{0.0, 0.0}, {320.5, 240.5}, {640.0, 480.0}, {17.3, 411.9}}) {
        const Vec3d direction = camera.ray(x, y)->direction;
        CHECK(std::abs(direction.length() - 1) < 4e-16);
        check_close(direction, at_home.ray(x, y)->direction, 1e-15);
      }
      // Neighbours differ even where a pixel is a hundred-billionth of a radian wide.
      CHECK(camera.ray(320.5, 240.5)->direction != camera.ray(321.5, 240.5)->direction);
    }
  }
}

TEST_CASE("a footprint is as wide as the narrowest pixel, and a share of it in proportion", "[sensor][camera]") {
  // Neighbouring rays' angle, or their distance, against the footprint.
  const auto narrowest = [](const Camera& camera, double from) {
    double least = kInfinity;
    for (int y = 0; y < camera.rows(); ++y) {
      for (int x = 0; x < camera.columns(); ++x) {
        const auto ray = camera.ray(x, y), right = camera.ray(x + 1, y), below = camera.ray(x, y + 1);
        for (const auto& other : {right, below}) {
          const Vec3d apart = from > 0 ? other->direction - ray->direction : other->origin - ray->origin;
          least = std::min(least, apart.length());
        }
      }
    }
    return least;
  };
  CameraSettings wide = looking_north(Projection::orthographic, 0, 40, 30);
  wide.width_m = 80;
  CHECK(Camera(wide).footprint(1).at(1e3) == Approx(2));
  CHECK(Camera(wide).footprint(0.25).at(1e3) == Approx(1));
  for (const Projection projection : {Projection::perspective, Projection::fisheye}) {
    for (const double fov : {0.1, 20.0, 100.0}) {
      const Camera camera(looking_north(projection, fov, 40, 30));
      const Footprint spot = camera.footprint(1);
      CHECK(spot.width == 0);
      CHECK(spot.spread <= narrowest(camera, 1) * (1 + 1e-6));
      CHECK(spot.spread > 0.4 * narrowest(camera, 1));
      CHECK(camera.footprint(1.0 / 16).spread == Approx(spot.spread / 4));
    }
  }
}

TEST_CASE("settings that make no picture are named", "[sensor][camera]") {
  const CameraSettings good = looking_north(Projection::perspective, 20, 32, 24);
  CHECK(!camera_problem(good));

  const auto where = [&](const std::function<void(CameraSettings&)>& change) {
    CameraSettings settings = good;
    change(settings);
    const auto problem = camera_problem(settings);
    return problem ? problem->where : std::string("nothing");
  };
  CHECK(where([](CameraSettings& s) { s.up = {0, -2, 0}; }) == "up");
  CHECK(where([](CameraSettings& s) { s.up = {0, 0, 0}; }) == "up");
  CHECK(where([](CameraSettings& s) { s.look_at_m = s.position_m; }) == "look_at_m");
  CHECK(where([](CameraSettings& s) { s.position_m.x = NAN; }) == "position_m");
  CHECK(where([](CameraSettings& s) { s.fov_deg = 180; }) == "fov_deg");
  CHECK(where([](CameraSettings& s) { s.fov_deg = 0; }) == "fov_deg");
  CHECK(where([](CameraSettings& s) { s.resolution = {0, 5}; }) == "resolution");
  CHECK(where([](CameraSettings& s) {
          s.projection = Projection::orthographic;
          s.width_m = -1;
        }) == "width_m");
  CHECK(where([](CameraSettings& s) {
          s.projection = Projection::fisheye;
          s.fov_deg = 360;
        }) == "nothing");
}

TEST_CASE("a spot's planes hold every ray of its rectangle, and little more", "[sensor][camera]") {
  struct View {
    Projection projection;
    double fov_deg;
    int columns, rows;
  };
  for (const View& view : {View{Projection::perspective, 90, 16, 12}, View{Projection::fisheye, 180, 16, 16},
                           View{Projection::fisheye, 350, 40, 40}}) {
    const Camera camera(looking_north(view.projection, view.fov_deg, view.columns, view.rows));
    double worst = 0;
    for (int y = 0; y < view.rows; ++y) {
      for (int x = 0; x < view.columns; ++x) {
        const std::optional<Spot> spot = camera.spot(x, y, x + 1, y + 1);
        if (!spot || spot->bulge > 1) continue;
        Vec3d middle(0);
        for (const Ray& ray : spot->corners) middle += ray.direction;
        double most = 0;
        for (int i = 0; i < 4; ++i) {
          const Vec3d a = spot->corners[static_cast<std::size_t>(i)].direction,
                      b = spot->corners[static_cast<std::size_t>((i + 1) % 4)].direction;
          Vec3d n = a.cross(b).normalized();
          if (n.dot(middle) < 0) n = -n;
          for (int k = 0; k <= 16; ++k) {
            const double s = k / 16.0;
            for (const auto& [u, v] : {std::pair(s, 0.0), std::pair(1.0, s), std::pair(s, 1.0), std::pair(0.0, s)}) {
              most = std::max(most, std::asin(-n.dot(camera.ray(x + u, y + v)->direction)));
            }
          }
        }
        CAPTURE(x, y, most, spot->bulge);
        CHECK(most <= spot->bulge + 1e-14);
        if (spot->bulge > 0) worst = std::max(worst, most / spot->bulge);
      }
    }
    CHECK((view.projection == Projection::fisheye ? worst > 0.3 : worst == 0));
  }
  const Camera all(looking_north(Projection::fisheye, 360, 64, 64));
  CHECK_FALSE(all.spot(0, 0, 1, 1).has_value());
  CHECK(all.spot(0, 31, 1, 32)->bulge > 1);
  CHECK(all.spot(0, 0, 64, 64) == std::nullopt);
  const Camera parallel(looking_north(Projection::orthographic, 0, 8, 8));
  CHECK(parallel.spot(1, 1, 2, 2)->corners[0].direction == parallel.spot(5, 5, 6, 6)->corners[3].direction);
}
