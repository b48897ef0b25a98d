// Surfaces by Embree against every sphere and every triangle in turn.
#include "photon/world/surfaces.h"

#include <catch2/catch.hpp>

#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/voxel_fields.h"

using namespace obscura;
using namespace obscura::test;

namespace {

/// The nearest entry in extended precision, sphere by sphere; `doubt` where a limb is so near that
/// rounding may decide.
SurfaceHit nearest(const std::vector<HotSphere>& spheres, const Ray& ray, bool& doubt) {
  SurfaceHit best;
  doubt = false;
  using Long = long double;
  for (std::size_t s = 0; s < spheres.size(); ++s) {
    const Long r = static_cast<Long>(spheres[s].radius);
    Long o[3], d[3], b = 0, c = -r * r, d2 = 0, closest2 = 0;
    for (int axis = 0; axis < 3; ++axis) {
      o[axis] = static_cast<Long>(ray.origin[axis]) - static_cast<Long>(spheres[s].center[axis]);
      d[axis] = static_cast<Long>(ray.direction[axis]);
      b -= o[axis] * d[axis];
      c += o[axis] * o[axis];
      d2 += d[axis] * d[axis];
    }
    for (int axis = 0; axis < 3; ++axis) closest2 += (o[axis] + b / d2 * d[axis]) * (o[axis] + b / d2 * d[axis]);
    const Long discriminant = r * r - closest2;
    doubt = doubt || std::abs(discriminant) < 1e-6L * r * r;
    if (c <= 0 || b <= 0 || discriminant <= 0) continue;
    const double t = static_cast<double>(b / d2 - std::sqrt(discriminant / d2));
    if (t > ray.t_min && t < ray.t_max && t < best.t) best = {t, {static_cast<std::uint32_t>(s), 0}};
  }
  return best;
}

std::vector<HotSphere> random_spheres(int count, double size, double radius, const Vec3d& middle, std::uint64_t seed) {
  Stream random(seed, 0, 0);
  std::vector<HotSphere> spheres;
  for (int i = 0; i < count; ++i) {
    const Vec3d offset(random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5);
    spheres.push_back({middle + size * offset, radius * (0.2 + random.uniform()), {1}});
  }
  return spheres;
}

/// Aims at spheres from `distance`, some at their very limbs, and compares. How many were hit.
int compare(const std::vector<HotSphere>& list, const Vec3d& origin, double distance, int rays, double tolerance) {
  const Surfaces spheres({}, list, origin);
  Stream random(5, 0, 0);
  int hits = 0, wrong = 0;
  double worst = 0;
  for (int i = 0; i < rays; ++i) {
    const HotSphere& aim = list[random.bits() % list.size()];
    const Vec3d d = random_direction(random);
    const Vec3d beside = d.cross(random_direction(random)).normalized();
    const double off = i % 3 == 0 ? 0.999 : 1.3 * random.uniform();
    Ray ray{aim.center + off * aim.radius * beside - distance * (0.2 + random.uniform()) * d, d, 0, kInfinity};
    bool doubt;
    const SurfaceHit expected = nearest(list, ray, doubt);
    const SurfaceHit found = spheres.intersect(ray);
    if (doubt) continue;
    hits += expected.t < kInfinity;
    wrong += found.id != expected.id || (found.t < kInfinity) != (expected.t < kInfinity);
    if (found.t < kInfinity && expected.t < kInfinity) worst = std::max(worst, std::abs(found.t - expected.t));
  }
  CHECK(wrong == 0);
  CHECK(worst < tolerance);
  return hits;
}

}  // namespace

TEST_CASE("the first sphere is that of a search through all", "[photon][surfaces]") {
  CHECK(compare(random_spheres(200, 10, 1, Vec3d(0), 1), Vec3d(0), 20, 3000, 1e-11) > 2000);
}

TEST_CASE("ten thousand tiny particles are found, limbs included", "[photon][surfaces]") {
  CHECK(compare(random_spheres(10000, 10, 1e-3, Vec3d(0), 2), Vec3d(0), 20, 1000, 1e-10) > 600);
}

TEST_CASE("spheres far from the origin and seen from afar are as exact as near ones", "[photon][surfaces]") {
  const Vec3d there(1e7, -2e7, 3e7);
  CHECK(compare(random_spheres(50, 10, 0.5, there, 3), there, 20, 1000, 1e-5) > 600);
  // A kilometre away from millimetres, ten thousand kilometres from a metre.
  CHECK(compare(random_spheres(50, 1, 1e-3, Vec3d(0), 4), Vec3d(0), 1000, 2000, 1e-8) > 1000);
  CHECK(compare(random_spheres(50, 10, 1, Vec3d(0), 5), Vec3d(0), 1e7, 2000, 1e-5) > 1000);
}

TEST_CASE("a ray that starts in a sphere does not see it; one that starts on it sees no other side",
          "[photon][surfaces]") {
  const std::vector<HotSphere> list = {{{0, 0, 0}, 1, {1}}, {{5, 0, 0}, 1, {1}}, {{0, 0, 0}, 0.25, {1}}};
  const Surfaces spheres({}, list, {0, 0, 0});
  SurfaceHit hit = spheres.intersect({{0.5, 0, 0}, {1, 0, 0}, 0, kInfinity});
  CHECK(hit.t == Approx(3.5));
  CHECK(hit.id.surface == 1);
  hit = spheres.intersect({{0.5, 0, 0}, {-1, 0, 0}, 0, kInfinity});
  CHECK(hit.id.surface == 2);
  CHECK(hit.t == Approx(0.25));
  Stream random(6, 0, 0);
  for (int i = 0; i < 1000; ++i) {
    const Vec3d normal = random_direction(random);
    Vec3d d = random_direction(random);
    if (d.dot(normal) < 0) d = -d;
    const SurfaceHit seen = spheres.intersect({Vec3d(5, 0, 0) + normal, d, 0, kInfinity});
    CHECK(seen.id.surface != 1);
  }
}

TEST_CASE("hits count only between t_min and t_max; the lower index wins a tie", "[photon][surfaces]") {
  const std::vector<HotSphere> list = {{{0, 0, 9}, 1, {1}}, {{0, 0, 5}, 1, {1}}, {{0, 0, 5}, 1, {1}}};
  const Surfaces spheres({}, list, {0, 0, 5});
  const Ray ray{{0, 0, 0}, {0, 0, 1}, 0, kInfinity};
  CHECK(spheres.intersect(ray).t == 4);
  CHECK(spheres.intersect(ray).id.surface == 1);
  CHECK(spheres.intersect({ray.origin, ray.direction, 0, 4}).t == kInfinity);
  CHECK(spheres.intersect({ray.origin, ray.direction, 0, 4.0001}).t == 4);
  CHECK(spheres.intersect({ray.origin, ray.direction, 4.5, kInfinity}).id.surface == 0);
  CHECK(spheres.intersect({ray.origin, -ray.direction, 0, kInfinity}).t == kInfinity);
  CHECK(Surfaces().intersect(ray).t == kInfinity);
  CHECK(Surfaces().empty());
}

namespace {

/// A bumpy sheet of 2 n n triangles over [0, 1]^2, facing up.
std::shared_ptr<const Mesh> sheet(std::uint32_t n, double height) {
  return test::sheet_mesh(n, [=](std::uint32_t i, std::uint32_t j) {
    return Vec3d(double(i) / n, double(j) / n,
                 height * voxel_noise(7, Vec3i(static_cast<int>(i), static_cast<int>(j), 0)));
  });
}

Object placed(std::shared_ptr<const Mesh> mesh, const Vec3d& where, const Vec3d& turn = Vec3d(0), double scale = 1) {
  Object object;
  object.mesh = std::move(mesh);
  object.local_to_world = placement(where, turn, scale);
  return object;
}

/// Every triangle in turn, in extended precision (Moeller and Trumbore, 1997). `doubt` near an edge.
SurfaceHit nearest_triangle(const std::vector<Object>& objects, const Ray& ray, bool& doubt) {
  using Long = long double;
  struct V {
    Long x, y, z;
    V operator-(const V& o) const { return {x - o.x, y - o.y, z - o.z}; }
    V cross(const V& o) const { return {y * o.z - z * o.y, z * o.x - x * o.z, x * o.y - y * o.x}; }
    Long dot(const V& o) const { return x * o.x + y * o.y + z * o.z; }
  };
  SurfaceHit best;
  doubt = false;
  const V o{ray.origin.x, ray.origin.y, ray.origin.z}, d{ray.direction.x, ray.direction.y, ray.direction.z};
  for (std::uint32_t i = 0; i < objects.size(); ++i) {
    const Mesh& mesh = *objects[i].mesh;
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
      V p[3];
      for (std::size_t c = 0; c < 3; ++c) {
        const Vec3d v = transform_point(objects[i].local_to_world, mesh.vertices[mesh.faces[f][c]]);
        p[c] = {v.x, v.y, v.z};
      }
      const V e1 = p[1] - p[0], e2 = p[2] - p[0], h = d.cross(e2), s = o - p[0], q = s.cross(e1);
      const Long a = e1.dot(h);
      if (a == 0) continue;
      const Long u = s.dot(h) / a, v = d.dot(q) / a, t = e2.dot(q) / a, w = 1 - u - v;
      const Long edge = std::min({u, v, w});
      if (std::abs(edge) < 1e-4L && t > 0) doubt = true;
      if (edge >= 0 && t > ray.t_min && t < ray.t_max && t < best.t) best = {double(t), {i, f}, double(u), double(v)};
    }
  }
  return best;
}

}  // namespace

TEST_CASE("the first triangle is that of a search through all, turned, scaled and far away", "[photon][surfaces]") {
  for (const double far : {0.0, 5e6}) {
    const Vec3d there(far, -0.3 * far, 0.1 * far);
    const auto mesh = sheet(12, 0.3);
    std::vector<Object> objects;
    Stream random(11, 0, 0);
    for (int i = 0; i < 6; ++i) {
      const Vec3d where(random.uniform(), random.uniform(), random.uniform());
      objects.push_back(placed(mesh, there + 3.0 * where,
                               6.0 * Vec3d(random.uniform(), random.uniform(), random.uniform()),
                               0.5 + random.uniform()));
    }
    const Surfaces surfaces(objects, {}, there + Vec3d(1.5));
    int hits = 0, wrong = 0, wrong_shadow = 0;
    double worst = 0, worst_weight = 0;
    for (int i = 0; i < 4000; ++i) {
      const Vec3d d = random_direction(random);
      const Vec3d aim = there + 4.0 * Vec3d(random.uniform(), random.uniform(), random.uniform());
      const Ray ray{aim - (i % 2 ? 2.0 : 3000.0) * d, d, 0, kInfinity};
      bool doubt;
      const SurfaceHit expected = nearest_triangle(objects, ray, doubt);
      if (doubt) continue;
      const SurfaceHit found = surfaces.intersect(ray);
      hits += expected.exists();
      wrong += found.id != expected.id;
      wrong_shadow += surfaces.occluded(ray) != expected.exists();
      if (found.exists() && expected.exists()) {
        worst = std::max(worst, std::abs(found.t - expected.t));
        worst_weight = std::max({worst_weight, std::abs(found.u - expected.u), std::abs(found.v - expected.v)});
      }
    }
    CHECK(hits > 400);
    CHECK(wrong == 0);
    CHECK(wrong_shadow == 0);
    CHECK(worst < (far > 0 ? 1e-7 : 1e-10));
    CHECK(worst_weight < (far > 0 ? 1e-6 : 1e-9));
  }
}

TEST_CASE("of coincident faces the lowest object and face is met, whatever their corners", "[photon][surfaces]") {
  // The same square three times: as two triangles the one way, the other way, and as one large triangle.
  const double z = 0.1;
  auto one = std::make_shared<Mesh>();
  one->vertices = {{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}};
  one->faces = {{0, 1, 3}, {1, 2, 3}, {0, 1, 3}};
  auto two = std::make_shared<Mesh>();
  two->vertices = {{-3.3, -2.7, z}, {7.1, -1.9, z}, {0.3, 9.7, z}};
  two->faces = {{0, 1, 2}};
  Stream random(3, 0, 0);
  for (const bool large_first : {false, true}) {
    const std::vector<Object> objects = {placed(large_first ? two : one, {0, 0, 0}),
                                         placed(large_first ? one : two, {0, 0, 0}), placed(one, {0, 0, 0})};
    const Surfaces surfaces(objects, {}, {0.5, 0.5, 0});
    for (int i = 0; i < 2000; ++i) {
      const Vec3d at(0.01 + 0.98 * random.uniform(), 0.01 + 0.98 * random.uniform(), z);
      Vec3d d = random_direction(random);
      if (std::abs(d.z) < 0.01) continue;
      const SurfaceHit hit = surfaces.intersect({at - 2.0 * d, d, 0, kInfinity});
      REQUIRE(hit.exists());
      CHECK(hit.id.surface == 0);
      if (!large_first && std::abs(at.x + at.y - 1) > 1e-6) CHECK(hit.id.face == (at.x + at.y < 1 ? 0u : 1u));
    }
  }
}

TEST_CASE("no ray slips between the triangles of a closed or a bumpy surface", "[photon][surfaces]") {
  const std::vector<Object> objects = {placed(sheet(40, 0.05), {0, 0, 0}, {0.3, 0.2, 0.1})};
  const Surfaces surfaces(objects, {}, {0.5, 0.5, 0});
  Stream random(4, 0, 0);
  int missed = 0;
  for (int i = 0; i < 20000; ++i) {
    // Through vertices and edges, from above.
    const double a = int(1 + 39 * random.uniform()) / 40.0;
    const double b = i % 2 ? int(1 + 39 * random.uniform()) / 40.0 : 0.02 + 0.96 * random.uniform();
    const Vec3d at = transform_point(objects[0].local_to_world, Vec3d(a, b, 0.02));
    const Vec3d up =
        transform_direction(objects[0].local_to_world, Vec3d(0.01 * random.uniform(), 0.01, 1)).normalized();
    missed += !surfaces.intersect({at + up, -up, 0, kInfinity}).exists();
  }
  CHECK(missed == 0);
}

TEST_CASE("a ray does not meet the face that it leaves, but does meet the next one", "[photon][surfaces]") {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1e-3}, {1, 0, 1e-3}, {0, 1, 1e-3}};
  mesh->faces = {{0, 1, 2}, {3, 4, 5}};
  Object ball;
  ball.radius = 1;
  ball.local_to_world = placement({0, 0, 5}, Vec3d(0), 2);
  const std::vector<Object> objects = {placed(mesh, {0, 0, 0}), ball};
  const Surfaces surfaces(objects, {}, {0, 0, 2});
  const Ray up{{0.2, 0.2, 0}, {0, 0, 1}, surfaces.clearance(), kInfinity};
  CHECK(surfaces.intersect(up, {0, 0}).id == FaceId{0, 1});
  CHECK(surfaces.intersect(up, {0, 0}).t == Approx(1e-3));
  // Inside the ball, from its wall to its wall.
  const SurfaceHit across = surfaces.intersect({{0, 0, 3}, {0, 0, 1}, surfaces.clearance(), kInfinity}, {1, 0});
  CHECK(across.id == FaceId{1, 0});
  CHECK(across.t == Approx(4));
  CHECK(surfaces.intersect({{0, 0, 7}, {0, 0, 1}, surfaces.clearance(), kInfinity}, {1, 0}).t == kInfinity);
  CHECK(surfaces.intersect({{0, 0, 5}, {1, 0, 0}, 0, kInfinity}).t == Approx(2));
  CHECK(surfaces.area({1, 0}) == Approx(16 * kPi));
  CHECK(surfaces.area({0, 0}) == Approx(0.5));
  CHECK(surfaces.normal({0, 0}, {0, 0, 0}).z == Approx(1));
}

TEST_CASE("degenerate faces are never met and disturb no other", "[photon][surfaces]") {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, 0.5, 1}, {0.5, 0.5, 1}, {2, 2, 2}};
  mesh->faces = {{3, 4, 3}, {3, 4, 5}, {0, 0, 1}, {0, 1, 2}};
  const std::vector<Object> objects = {placed(mesh, {0, 0, 0})};
  const Surfaces surfaces(objects, {}, {0, 0, 0});
  CHECK(surfaces.intersect({{0.2, 0.2, 3}, {0, 0, -1}, 0, kInfinity}).id == FaceId{0, 3});
  CHECK_FALSE(surfaces.intersect({{0.5, 0.5, 3}, {0, 0, -1}, 0, 2.5}).exists());
}

TEST_CASE("near() finds every face within the radius", "[photon][surfaces]") {
  const std::vector<Object> objects = {placed(sheet(10, 0.1), {0, 0, 0})};
  const Surfaces surfaces(objects, {}, {0.5, 0.5, 0});
  CHECK(surfaces.near({0.5, 0.5, 0.5}, 0.55));
  CHECK_FALSE(surfaces.near({0.5, 0.5, 0.5}, 0.3));
  CHECK(surfaces.near({1.5, 0.5, 0.05}, 0.56));
  CHECK_FALSE(surfaces.near({1.5, 0.5, 0.05}, 0.4));
  CHECK_FALSE(Surfaces().near({0, 0, 0}, 100));
}

TEST_CASE("a place is flat where no face stands up from it", "[photon][surfaces]") {
  std::vector<Object> objects = {placed(sheet(10, 0), {0, 0, 0})};
  objects.push_back(placed(objects[0].mesh, {0.9, 0, 0.5}, {0, kPi / 2, 0}));  // a wall beside
  const Surfaces surfaces(objects, {}, {0.5, 0.5, 0});
  CHECK(surfaces.flat({0.5, 0.5, 0}, {0, 0, 1}, 0.3));
  CHECK(surfaces.flat({0.5, 0.5, 0}, {0, 0, -1}, 0.3));
  CHECK_FALSE(surfaces.flat({0.5, 0.5, 0}, {0, 0, 1}, 0.45));
  CHECK_FALSE(surfaces.flat({0.5, 0.5, 0}, {1, 0, 0}, 0.1));
  const std::vector<Object> bumps = {placed(sheet(10, 0.1), {0, 0, 0})};
  CHECK_FALSE(Surfaces(bumps, {}, {0.5, 0.5, 0}).flat({0.5, 0.5, 0.05}, {0, 0, 1}, 0.2));
}
