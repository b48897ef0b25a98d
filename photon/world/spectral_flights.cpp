// What clouds do along whole rays: optical depths, and where a flight ends.
#include <algorithm>
#include <limits>

#include "photon/world/spectral_world.h"
#include "photon/world/world_walk.h"

namespace obscura {
namespace {

/// One flight by the world walk, in double. Returns the optics of the segment that it collided in; the
/// end is kept off that segment's faces, so that a look-up there finds the same.
LocalOptics walk_to_depth(SpectralWorld world, const Flight& flight, FreePath& end) noexcept {
  end = {flight.ray.t_max, 0.0, false};
  WorldWalk walk(world, flight.ray);
  while (walk.next()) {
    const double length = walk.end() - walk.begin();
    const double depth = walk.optics().extinction * length;
    if (end.depth + depth >= flight.target_depth && depth > 0) {
      const double t = walk.begin() + (flight.target_depth - end.depth) / walk.optics().extinction;
      // Thick leaves have all their light near their faces: no farther from these than rounding demands.
      const double rounding = 8 * std::numeric_limits<double>::epsilon() * (flight.ray.origin.length() + walk.end());
      const double margin = std::min(1e-6 * length, std::max(1e-3 / walk.optics().extinction, rounding));
      end = {std::clamp(t, walk.begin() + margin, walk.end() - margin), flight.target_depth, true};
      return walk.optics();
    }
    end.depth += depth;
  }
  return {};
}

/// Optical depth from which on a leaf is thick: the batched walk is right to 2e-5 of a leaf, which is then no longer
/// small against a free path.
constexpr double kThick = 100;

}  // namespace

bool SpectralWorld::has_thick_leaves() const noexcept {
  double most = 0;
  for (int c = 0; c < world_->cloud_count(); ++c) {
    for (const CloudOptics::Part& part : optics(c).parts()) {
      most += part.extinction *
              static_cast<double>(world_->clouds()[static_cast<std::size_t>(c)].octree->bounds(part.channel).max);
    }
  }
  return most * world_->largest_leaf_m_ > kThick;
}

LocalOptics SpectralWorld::at_collision(const Flight& flight, FreePath& end) const noexcept {
  const LocalOptics here = at(flight.ray.at(end.t));
  if (here.extinction > 0 && here.extinction * world_->largest_leaf_m_ <= kThick) return here;
  return walk_to_depth(*this, flight, end);
}

void SpectralWorld::optical_depths(std::span<const Ray> rays, std::span<double> depths) const {
  std::vector<Ray> pieces;
  if (world_->cloud_count() == 1 && !world_->frame(0).periodic()) {
    pieces.resize(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) pieces[i] = transform_ray(world_->frame(0).world_to_index, rays[i]);
    obscura::optical_depths(*world_->clouds().front().octree, pieces, optics(0).extinction_weights(), depths);
    return;
  }
  std::fill(depths.begin(), depths.end(), 0.0);
  std::vector<double> parts;
  for (int c = 0; c < world_->cloud_count(); ++c) {
    const Octree& octree = *world_->clouds()[static_cast<std::size_t>(c)].octree;
    const std::vector<double>& weights = optics(c).extinction_weights();
    if (!world_->frame(c).periodic()) {
      pieces.clear();
      for (const Ray& ray : rays) pieces.push_back(transform_ray(world_->frame(c).world_to_index, ray));
      parts.resize(rays.size());
      obscura::optical_depths(octree, pieces, weights, parts);
      for (std::size_t i = 0; i < rays.size(); ++i) depths[i] += parts[i];
      continue;
    }
    // One round per cell that the rays cross.
    std::vector<CellRays> cells;
    cells.reserve(rays.size());
    for (const Ray& ray : rays) cells.emplace_back(world_->frame(c), ray);
    std::vector<std::size_t> active(rays.size());
    for (std::size_t i = 0; i < active.size(); ++i) active[i] = i;
    while (!active.empty()) {
      pieces.clear();
      std::size_t kept = 0;
      for (const std::size_t i : active) {
        // Beyond this depth nothing of the light is left in double precision.
        if (depths[i] > 750) continue;
        if (const std::optional<Ray> piece = cells[i].next()) {
          pieces.push_back(*piece);
          active[kept++] = i;
        }
      }
      active.resize(kept);
      parts.resize(kept);
      obscura::optical_depths(octree, pieces, weights, parts);
      for (std::size_t j = 0; j < kept; ++j) depths[active[j]] += parts[j];
    }
  }
}

void SpectralWorld::reach_depths(std::span<const Flight> flights, std::span<FreePath> ends) const {
  if (world_->cloud_count() == 1) {
    const Octree& octree = *world_->clouds().front().octree;
    const std::vector<double>& weights = optics(0).extinction_weights();
    // The batched walk is right to about 2e-5 of the cloud's size: too little for flights that are short
    // beside it, whose walk in double is short too.
    const Vec3d extent = world_->frame(0).local_bounds.max - world_->frame(0).local_bounds.min;
    const double size = transform_direction(world_->clouds().front().local_to_world, extent).length();
    const auto refine = [&](const Flight& flight, FreePath& end) {
      if (end.t - flight.ray.t_min < 2e-3 * size) walk_to_depth(*this, flight, end);
    };
    if (!world_->frame(0).periodic()) {
      std::vector<Flight> own(flights.begin(), flights.end());
      for (Flight& flight : own) flight.ray = transform_ray(world_->frame(0).world_to_index, flight.ray);
      obscura::free_paths(octree, own, weights, ends);
      for (std::size_t i = 0; i < flights.size(); ++i) {
        if (ends[i].collided) {
          refine(flights[i], ends[i]);
        } else {
          ends[i].t = flights[i].ray.t_max;
        }
      }
      return;
    }
    std::vector<CellRays> cells;
    cells.reserve(flights.size());
    for (const Flight& flight : flights) cells.emplace_back(world_->frame(0), flight.ray);
    std::vector<std::size_t> active(flights.size());
    for (std::size_t i = 0; i < active.size(); ++i) {
      active[i] = i;
      ends[i] = {flights[i].ray.t_max, 0.0, false};
    }
    std::vector<Flight> pieces;
    std::vector<FreePath> parts;
    while (!active.empty()) {
      pieces.clear();
      std::size_t kept = 0;
      for (const std::size_t i : active) {
        if (ends[i].collided) continue;
        if (const std::optional<Ray> piece = cells[i].next()) {
          pieces.push_back({*piece, flights[i].target_depth - ends[i].depth});
          active[kept++] = i;
        }
      }
      active.resize(kept);
      parts.resize(kept);
      obscura::free_paths(octree, pieces, weights, parts);
      for (std::size_t j = 0; j < kept; ++j) {
        FreePath& end = ends[active[j]];
        end.depth += parts[j].depth;
        end.collided = parts[j].collided;
        if (!end.collided) continue;
        end.t = parts[j].t;
        refine(flights[active[j]], end);
      }
    }
    return;
  }
  for (std::size_t i = 0; i < flights.size(); ++i) walk_to_depth(*this, flights[i], ends[i]);
}

}  // namespace obscura
