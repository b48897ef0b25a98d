// What the path tracer says of a World: averages of radiance over rays from a low-discrepancy sequence.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "octree/base/low_discrepancy.h"
#include "octree/base/statistics.h"
#include "photon/optics/sampling.h"
#include "photon/paths/path_tracer.h"

namespace obscura::test {

/// Independent batches of an average: few enough that each is well spread, enough for a normal error.
inline constexpr int kPathBatches = 48;

struct WeightedRay {
  Ray ray;
  double weight = 1;
};

/// Mean of weight times radiance over rays: ray_of(numbers) makes a WeightedRay of uniform numbers. About
/// `count` rays in all; `paths` for each.
template <class RayOf>
BatchMean path_average(const World& world, int count, std::uint64_t seed, RayOf&& ray_of, int paths = 1) {
  const std::size_t each = static_cast<std::size_t>(std::max(1, count / kPathBatches));
  std::vector<Ray> rays(each);
  std::vector<double> weights(each);
  std::vector<std::uint64_t> histories(each);
  std::vector<Incoming> incoming(each);
  std::array<double, kPathBatches> means{};
  PathSettings settings;
  settings.paths = paths;
  settings.seed = seed;
  for (std::size_t batch = 0; batch < kPathBatches; ++batch) {
    const LowDiscrepancy numbers(seed, static_cast<std::uint32_t>(batch));
    for (std::size_t i = 0; i < each; ++i) {
      const WeightedRay wish = ray_of(numbers.point(static_cast<std::uint32_t>(i)));
      rays[i] = wish.ray;
      weights[i] = wish.weight;
      histories[i] = batch * each + i;
    }
    path_radiance({world, 0}, settings, rays, histories, incoming);
    for (std::size_t i = 0; i < each; ++i) means[batch] += weights[i] * incoming[i].total() / static_cast<double>(each);
  }
  return batch_mean(means);
}

/// Radiance that arrives against one direction.
inline BatchMean path_radiance_along(const World& world, const Ray& ray, int count, std::uint64_t seed, int paths = 1) {
  return path_average(
      world, count, seed,
      [&](const auto&) {
        return WeightedRay{ray, 1};
      },
      paths);
}

/// A ray that looks at a stack from outside: light leaves it at cosine mu to the vertical, upward on top or
/// downward below, `phi` from the x axis.
inline Ray view(double top, bool upward, double mu, double phi) {
  const double sine = std::sqrt(std::max(0.0, (1 - mu) * (1 + mu)));
  const Vec3d travels(sine * std::cos(phi), sine * std::sin(phi), upward ? mu : -mu);
  return {{500, 500, upward ? top + 0.5 : -0.5}, -travels, 0, kInfinity};
}

/// Mean radiance that leaves a stack, weighted with the cosine: its flux over pi.
inline BatchMean path_exitance(const World& world, double top, bool upward, int count, std::uint64_t seed,
                               int paths = 1) {
  return path_average(
      world, count, seed,
      [&](const auto& u) {
        return WeightedRay{view(top, upward, std::sqrt(u[0]), 2 * kPi * u[1]), 1};
      },
      paths);
}

}  // namespace obscura::test
