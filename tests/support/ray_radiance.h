// What tests of ray integrals share: an octree from a function of the voxel, the radiance that a
// walk through it gathers, and the measured order of convergence.
#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "octree/build/build.h"
#include "octree/tree/walk.h"
#include "photon/optics/transfer.h"
#include "tests/support/voxel_fields.h"

namespace obscura::test {

inline Octree lossless(const VoxelStream& stream) {
  BuildSettings settings;
  settings.tolerance = 0;
  return build_octree(stream, settings).first;
}

/// A half-line with unit direction: t is in metres.
inline Ray line(const Vec3d& origin, const Vec3d& direction, double t_min = 0, double t_max = kInfinity) {
  return {origin, direction / direction.length(), t_min, t_max};
}

inline double depth_along(const Octree& tree, const Ray& ray, double weight = 1) {
  std::vector<double> weights(static_cast<std::size_t>(tree.channel_count()), 0.0);
  weights[0] = weight;
  return optical_depth(tree, transform_ray(tree.local_to_index(), ray), weights);
}

struct Gathered {
  double radiance = 0;  ///< emitted along the ray, without background
  double depth = 0;
  double length = 0;  ///< in the domain
  double transmission() const { return std::exp(-depth); }
};

/// Front to back along the ray: extinction(walk) in 1/m and source(walk) in W/m2/sr of each
/// segment.
template <class Extinction, class Source>
Gathered gather(const Octree& tree, const Ray& ray, Extinction&& extinction, Source&& source) {
  Gathered g;
  walk(tree, transform_ray(tree.local_to_index(), ray), [&](double begin, double end, const Walk& segment) {
    const double k = extinction(segment);
    const double d = end - begin;
    g.radiance += g.transmission() * k * source(segment) * effective_length(k, d);
    g.depth += k * d;
    g.length += d;
    return true;
  });
  return g;
}

/// Orders between successive errors, each from half the voxel of the one before.
inline std::vector<double> orders(const std::vector<double>& errors) {
  std::vector<double> result;
  for (std::size_t i = 1; i < errors.size(); ++i) {
    result.push_back(std::log2(std::abs(errors[i - 1] / errors[i])));
  }
  return result;
}

}  // namespace obscura::test
