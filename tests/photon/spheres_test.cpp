// Spheres by Embree against every sphere in turn.
#include "photon/spheres.h"

#include <catch2/catch.hpp>

#include "tests/support/voxel_fields.h"

using namespace obscura;
using namespace obscura::test;

namespace {

/// The nearest entry in extended precision, sphere by sphere; `doubt` where a limb is so near that
/// rounding may decide.
SphereHit nearest(const std::vector<HotSphere>& spheres, const Ray& ray, bool& doubt) {
  SphereHit best;
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
    if (t > ray.t_min && t < ray.t_max && t < best.t) best = {t, static_cast<std::uint32_t>(s)};
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
  const Spheres spheres(list, origin);
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
    const SphereHit expected = nearest(list, ray, doubt);
    const SphereHit found = spheres.intersect(ray);
    if (doubt) continue;
    hits += expected.t < kInfinity;
    wrong += found.sphere != expected.sphere || (found.t < kInfinity) != (expected.t < kInfinity);
    if (found.t < kInfinity && expected.t < kInfinity) worst = std::max(worst, std::abs(found.t - expected.t));
  }
  CHECK(wrong == 0);
  CHECK(worst < tolerance);
  return hits;
}

}  // namespace

TEST_CASE("the first sphere is that of a search through all", "[photon][spheres]") {
  CHECK(compare(random_spheres(200, 10, 1, Vec3d(0), 1), Vec3d(0), 20, 3000, 1e-11) > 2000);
}

TEST_CASE("ten thousand tiny particles are found, limbs included", "[photon][spheres]") {
  CHECK(compare(random_spheres(10000, 10, 1e-3, Vec3d(0), 2), Vec3d(0), 20, 1000, 1e-10) > 600);
}

TEST_CASE("spheres far from the origin and seen from afar are as exact as near ones", "[photon][spheres]") {
  const Vec3d there(1e7, -2e7, 3e7);
  CHECK(compare(random_spheres(50, 10, 0.5, there, 3), there, 20, 1000, 1e-5) > 600);
  // A kilometre away from millimetres, ten thousand kilometres from a metre.
  CHECK(compare(random_spheres(50, 1, 1e-3, Vec3d(0), 4), Vec3d(0), 1000, 2000, 1e-8) > 1000);
  CHECK(compare(random_spheres(50, 10, 1, Vec3d(0), 5), Vec3d(0), 1e7, 2000, 1e-5) > 1000);
}

TEST_CASE("a ray that starts in a sphere does not see it; one that starts on it sees no other side", "[photon][spheres]") {
  const Spheres spheres({{{0, 0, 0}, 1, {1}}, {{5, 0, 0}, 1, {1}}, {{0, 0, 0}, 0.25, {1}}}, {0, 0, 0});
  SphereHit hit = spheres.intersect({{0.5, 0, 0}, {1, 0, 0}, 0, kInfinity});
  CHECK(hit.t == Approx(3.5));
  CHECK(hit.sphere == 1);
  hit = spheres.intersect({{0.5, 0, 0}, {-1, 0, 0}, 0, kInfinity});
  CHECK(hit.sphere == 2);
  CHECK(hit.t == Approx(0.25));
  Stream random(6, 0, 0);
  for (int i = 0; i < 1000; ++i) {
    const Vec3d normal = random_direction(random);
    Vec3d d = random_direction(random);
    if (d.dot(normal) < 0) d = -d;
    const SphereHit seen = spheres.intersect({Vec3d(5, 0, 0) + normal, d, 0, kInfinity});
    CHECK(seen.sphere != 1);
  }
}

TEST_CASE("hits count only between t_min and t_max; the lower index wins a tie", "[photon][spheres]") {
  const Spheres spheres({{{0, 0, 9}, 1, {1}}, {{0, 0, 5}, 1, {1}}, {{0, 0, 5}, 1, {1}}}, {0, 0, 5});
  const Ray ray{{0, 0, 0}, {0, 0, 1}, 0, kInfinity};
  CHECK(spheres.intersect(ray).t == 4);
  CHECK(spheres.intersect(ray).sphere == 1);
  CHECK(spheres.intersect({ray.origin, ray.direction, 0, 4}).t == kInfinity);
  CHECK(spheres.intersect({ray.origin, ray.direction, 0, 4.0001}).t == 4);
  CHECK(spheres.intersect({ray.origin, ray.direction, 4.5, kInfinity}).sphere == 0);
  CHECK(spheres.intersect({ray.origin, -ray.direction, 0, kInfinity}).t == kInfinity);
  CHECK(Spheres().intersect(ray).t == kInfinity);
  CHECK(Spheres().empty());
}
