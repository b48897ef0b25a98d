// The time of a ray against the number of triangles: bumpy terrain of 10^3 to 10^7 triangles, seen by the
// same rays, closest hit in double. Prints one row for each, with the memory and the time to build.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "octree/base/random.h"
#include "photon/optics/sampling.h"
#include "photon/world/surfaces.h"
#include "tests/support/shapes_of_surfaces.h"

using namespace obscura;

namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// MiB that the process holds now.
double resident_MiB() {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word) {
    if (word != "VmRSS:") continue;
    double kB = 0;
    status >> kB;
    return kB / 1024;
  }
  return 0;
}

/// Hills of several sizes over [0, 1]^2 as 2 n n triangles.
std::shared_ptr<const Mesh> terrain(std::uint32_t n) {
  return test::sheet_mesh(n, [n](std::uint32_t i, std::uint32_t j) {
    const double x = double(i) / n, y = double(j) / n;
    double z = 0, size = 0.05;
    for (double wave = 9; wave < 3000; wave *= 2.7, size *= 0.42)
      z += size * std::sin(wave * x + 2 * z) * std::cos(wave * 1.1 * y);
    return Vec3d(x, y, z);
  });
}

}  // namespace

int main() {
  constexpr int kRays = 1000000;
  std::printf("%10s %10s %14s %12s %10s %12s\n", "triangles", "build s", "MiB with mesh", "ns per ray", "hits %",
              "of 10^3's");
  double first = 0;
  for (const std::uint32_t n : {22u, 71u, 224u, 707u, 2236u}) {
    const double before = resident_MiB();
    auto start = std::chrono::steady_clock::now();
    std::vector<Object> objects(1);
    objects[0].mesh = terrain(n);
    start = std::chrono::steady_clock::now();
    const Surfaces surfaces(objects, {}, {0.5, 0.5, 0});
    const double build = seconds_since(start);
    const double memory = resident_MiB() - before;
    std::vector<double> times;
    int hits = 0;
    for (int round = 0; round < 3; ++round) {
      Stream random(1, 0, 0);
      hits = 0;
      start = std::chrono::steady_clock::now();
      for (int i = 0; i < kRays; ++i) {
        const double u = random.uniform(), v = random.uniform();
        Vec3d d = uniform_direction(u, v);
        d.z = -std::abs(d.z) - 0.05;
        d.normalize();
        const Vec3d aim(random.uniform(), random.uniform(), 0);
        hits += surfaces.intersect({aim - 2.0 * d, d, 0, kInfinity}).exists();
      }
      times.push_back(1e9 * seconds_since(start) / kRays);
    }
    std::sort(times.begin(), times.end());
    if (first == 0) first = times[1];
    std::printf("%10u %10.3f %14.1f %12.0f %10.1f %12.2f\n", 2 * n * n, build, memory, times[1], 100.0 * hits / kRays,
                times[1] / first);
    std::fflush(stdout);
  }
}
