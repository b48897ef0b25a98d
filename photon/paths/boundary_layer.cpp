#include "photon/paths/boundary_layer.h"

#include <algorithm>
#include <cmath>

#include "photon/world/world_walk.h"

namespace obscura::detail {
namespace {

/// Balls are taken to resolve a layer where they are smaller than it, and not to where they are three times as large.
constexpr double kResolved = 1, kUnresolved = 3;
/// Depths of the layer within which a face matters.
constexpr double kReach = 4;
/// Share of what is taken off that may be wrong: faces are not plane, nor what is behind them uniform.
constexpr double kDoubt = 0.3;

/// Absorption and transport extinction, 1/m.
struct Transport {
  double absorption = 0, extinction = 0;
};

Transport transport_at(SpectralWorld world, const Vec3d& point) noexcept {
  Transport sum;
  for (int c = 0; c < world->cloud_count(); ++c) {
    const Octree& octree = *world->clouds()[static_cast<std::size_t>(c)].octree;
    const Vec3d index = world->index_point(c, point);
    for (const CloudOptics::Part& part : world.optics(c).parts()) {
      const auto density = static_cast<double>(octree.value(part.channel, index));
      sum.absorption += density * (part.extinction - part.scattering);
      sum.extinction +=
          density * (part.extinction - (part.scattering > 0 ? part.scattering * part.phase->mean_cosine() : 0.0));
    }
  }
  return sum;
}

/// Optical depth of clouds along a short ray.
double depth_along(SpectralWorld world, const Ray& ray) noexcept {
  double depth = 0;
  for (WorldWalk walk(world, ray); walk.next();) depth += walk.optics().extinction * (walk.end() - walk.begin());
  return depth;
}

}  // namespace

void resolve_boundary_layer(SpectralWorld world, const Vec3d& point, Estimate& estimate) noexcept {
  if (!(estimate.value > 0) || !(estimate.radius > 0)) return;
  const Transport at = transport_at(world, point);
  // Light falls off as exp(-s / layer) with the distance s from the face.
  const double layer = 1 / std::sqrt(3 * at.absorption * at.extinction);
  const double wide = estimate.radius / layer;
  if (!(wide > kResolved)) return;

  // The nearest face along the axes, and the light that comes in there.
  const double reach = kReach * layer;
  const double whole = reach * world.at(point).extinction;
  double nearest = kInfinity, outside = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Vec3d direction(0);
      direction[axis] = sign;
      const double depth = depth_along(world, {point, direction, 0, reach});
      if (!(depth < 0.999 * whole) || !(depth < nearest)) continue;
      nearest = depth;
      outside = world.background(direction, false);
    }
  }
  if (!(nearest < kInfinity)) return;

  // Of a half space of a uniform source, J is short of its inner value by 1 / (1 + gamma) of its difference from what
  // comes in, at the face; the half ball has the mean of exp(-s / layer), about 3 / 2 layers over its radius.
  const double gamma = std::sqrt(at.absorption / at.extinction);
  const double in_ball = std::min(1.5 / wide, 0.5);
  const double here = std::exp(-nearest / whole * kReach);
  const double inside = estimate.value;
  const double share = std::clamp((wide - kResolved) / (kUnresolved - kResolved), 0.0, 1.0);
  // The change is linear in the estimate, so that it is one of each batch. It makes no light negative.
  double change = share * (in_ball - here) / (1 + gamma - in_ball);
  if (outside > inside) change = std::min(change, inside / (outside - inside));
  const auto changed = [&](double light) { return light + change * (light - outside); };
  estimate.value = changed(inside);
  for (double& batch : estimate.batch) batch = changed(batch);
  estimate.bias =
      std::copysign(std::hypot((1 + change) * estimate.bias, kDoubt * change * (inside - outside)), estimate.bias);
}

}  // namespace obscura::detail
