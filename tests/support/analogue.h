// A brute-force estimate of the radiance along a ray: analogue backward Monte Carlo with one global
// majorant over a function of space. It knows neither octree nor walk nor photons.
#pragma once

#include <functional>
#include <random>

#include "octree/base/math.h"
#include "octree/base/statistics.h"

namespace obscura::test {

struct AnalogueMedium {
  double extinction = 0;  // 1/m
  double albedo = 0;
  double source = 0;  // W/m2/sr: what absorption emits
};

struct AnalogueScene {
  Box3d box;  // outside: nothing
  std::function<AnalogueMedium(const Vec3d&)> medium;
  double majorant = 0;  // at least the largest extinction
  double g = 0;         // Henyey-Greenstein
  double sky = 0;       // W/m2/sr
  Vec3d toward_sun{0, 0, 1};
  double sun = 0;  // W/m2
};

class Analogue {
 public:
  Analogue(AnalogueScene scene, std::uint64_t seed) : scene_(std::move(scene)), engine_(seed) {}

  /// Radiance that arrives against `direction` at `origin`: mean and standard error over histories.
  Moments radiance(const Vec3d& origin, const Vec3d& direction, int histories) {
    Moments moments;
    for (int i = 0; i < histories; ++i) moments.add(history(origin, direction));
    return moments;
  }

  double history(Vec3d x, Vec3d d) {
    double sum = 0;
    for (;;) {
      const double t = next_collision(x, d);
      if (t == kInfinity) return sum + scene_.sky;
      x += t * d;
      const AnalogueMedium here = scene_.medium(x);
      if (uniform() >= here.albedo) return sum + here.source;
      if (scene_.sun > 0 && next_collision(x, scene_.toward_sun) == kInfinity) {
        sum += scene_.sun * phase(scene_.toward_sun.dot(d));
      }
      d = scatter(d);
    }
  }

 private:
  double uniform() { return std::uniform_real_distribution<double>(0, 1)(engine_); }

  double phase(double cosine) const {
    const double g = scene_.g;
    return (1 - g * g) / (4 * kPi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
  }

  // Delta tracking with one majorant for the whole box.
  double next_collision(const Vec3d& x, const Vec3d& d) {
    const auto [enter, leave] = clip(Ray{x, d, 0, kInfinity}, scene_.box);
    double t = enter;
    while (t < leave) {
      t -= std::log(1 - uniform()) / scene_.majorant;
      if (t < leave && uniform() * scene_.majorant < scene_.medium(x + t * d).extinction) return t;
    }
    return kInfinity;
  }

  Vec3d scatter(const Vec3d& d) {
    const double g = scene_.g;
    const double u = uniform();
    double cosine = 1 - 2 * u;
    if (g != 0) {
      const double s = (1 - g * g) / (1 - g + 2 * g * u);
      cosine = (1 + g * g - s * s) / (2 * g);
    }
    const double phi = 2 * kPi * uniform();
    const Vec3d side = (std::abs(d.x) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).cross(d).normalized();
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    return (cosine * d + sine * (std::cos(phi) * side + std::sin(phi) * d.cross(side))).normalized();
  }

  AnalogueScene scene_;
  std::mt19937_64 engine_;
};

}  // namespace obscura::test
