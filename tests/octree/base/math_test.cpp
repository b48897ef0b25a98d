#include "octree/base/math.h"

#include <catch2/catch.hpp>

#include "octree/base/random.h"

using namespace obscura;

namespace {

const Box3d kBox(Vec3d(0, 0, 0), Vec3d(2, 1, 0.5));

double entry(const Ray& ray) { return clip(ray, kBox).first; }
double exit_of(const Ray& ray) { return clip(ray, kBox).second; }
bool misses(const Ray& ray) {
  const auto [enter, leave] = clip(ray, kBox);
  return enter > leave;
}

}  // namespace

TEST_CASE("a ray is clipped to a box", "[base][math]") {
  const Ray along_x{{-1, 0.5, 0.25}, {1, 0, 0}};
  CHECK(entry(along_x) == 1);
  CHECK(exit_of(along_x) == 3);
  const Ray back{{3, 0.5, 0.25}, {-2, 0, 0}};  // t is in units of the direction
  CHECK(entry(back) == 0.5);
  CHECK(exit_of(back) == 1.5);
  const Ray inside{{1, 0.5, 0.25}, {0, 0, 1}};
  CHECK(entry(inside) == 0);
  CHECK(exit_of(inside) == 0.25);
  const Ray limited{{-1, 0.5, 0.25}, {1, 0, 0}, 1.5, 2.25};
  CHECK(entry(limited) == 1.5);
  CHECK(exit_of(limited) == 2.25);
  CHECK(misses({{-1, 2, 0.25}, {1, 0, 0}}));
  CHECK(misses({{-1, 0.5, 0.25}, {-1, 0, 0}}));
  CHECK(misses({{-1, 0.5, 0.25}, {1, 0, 0}, 0, 0.5}));
  CHECK(misses({{-1, 0.9, 0.25}, {1, 1, 0}}));
}

TEST_CASE("a ray in a face is inside on the lower side only", "[base][math]") {
  CHECK_FALSE(misses({{-1, 0, 0.25}, {1, 0, 0}}));
  CHECK(misses({{-1, 1, 0.25}, {1, 0, 0}}));
  CHECK_FALSE(misses({{-1, 0, 0}, {1, 0, 0}}));
  CHECK(misses({{-1, 0, 0.5}, {1, 0, 0}}));
  CHECK_FALSE(misses({{-1, -0.0, 0.25}, {1, -0.0, 0.0}}));
}

TEST_CASE("the basis is orthonormal and right-handed for every direction", "[base][math]") {
  std::vector<Vec3d> directions{{0, 0, 1},
                                {0, 0, -1},
                                {1, 0, 0},
                                {0, -1, 0},
                                {1, 0, -0.0},
                                Vec3d(1e-9, 1e-9, -1).normalized(),
                                Vec3d(1e-20, 0, -1).normalized()};
  Stream stream(1, 0, 0);
  for (int i = 0; i < 1000; ++i) {
    const double z = 2 * stream.uniform() - 1, phi = 2 * kPi * stream.uniform();
    const double sine = std::sqrt(1 - z * z);
    directions.emplace_back(sine * std::cos(phi), sine * std::sin(phi), z);
  }
  for (const Vec3d& n : directions) {
    const auto [u, v] = orthonormal_basis(n);
    CHECK(std::abs(u.length() - 1) < 1e-14);
    CHECK(std::abs(v.length() - 1) < 1e-14);
    CHECK(std::abs(u.dot(v)) < 1e-14);
    CHECK(std::abs(u.dot(n)) < 1e-14);
    CHECK((u.cross(v) - n).length() < 1e-14);
  }
}

TEST_CASE("affine maps act on row vectors, left one first", "[base][math]") {
  Affine scale, shift;
  scale.setScale(Vec3d(2, 3, 4));
  shift.setTranslation(Vec3d(10, 20, 30));
  CHECK(transform_point(scale * shift, Vec3d(1, 1, 1)) == Vec3d(12, 23, 34));
  CHECK(transform_point(shift * scale, Vec3d(1, 1, 1)) == Vec3d(22, 63, 124));
  CHECK(transform_direction(scale * shift, Vec3d(1, 1, 1)) == Vec3d(2, 3, 4));
  CHECK(linear_determinant(scale * shift) == 24);
  Affine mirror;
  mirror.setScale(Vec3d(-1, 1, 1));
  CHECK(linear_determinant(mirror) == -1);
}

TEST_CASE("a ray keeps its parameter through a map", "[base][math]") {
  Affine map;
  map.setEulerAngles(Vec3d(0.3, -0.5, 1.1));
  map[3][0] = 7;
  map[3][2] = -4;
  map[0][1] += 0.2;  // shear
  const Ray ray{{1, 2, 3}, {0.6, 0, 0.8}, 0.5, 9};
  const Ray image = transform_ray(map, ray);
  CHECK(image.t_min == 0.5);
  CHECK(image.t_max == 9);
  for (const double t : {0.0, 1.5, -20.0}) {
    CHECK((image.at(t) - transform_point(map, ray.at(t))).length() < 1e-13);
  }
}

TEST_CASE("the image of a box is held by its box", "[base][math]") {
  Affine turn;
  turn.setEulerAngles(Vec3d(0, 0, kPi / 4));
  const Box3d image = transform_box(turn, Box3d(Vec3d(-1, -1, 0), Vec3d(1, 1, 2)));
  CHECK(image.max.x == Approx(std::sqrt(2)));
  CHECK(image.min.y == Approx(-std::sqrt(2)));
  CHECK(image.min.z == 0);
  CHECK(image.max.z == 2);
  CHECK(transform_box(turn, Box3d()).isEmpty());
}
