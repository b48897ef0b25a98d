#include <algorithm>
#include <utility>

#include "octree/base/error.h"
#include "photon/world/check_contents.h"
#include "photon/world/spectral_world.h"

namespace obscura {

World::World(WorldContents contents) : contents_(std::move(contents)) {
  check_contents(contents_);
  if (contents_.clouds.size() > static_cast<std::size_t>(kMaxClouds)) {
    throw InputError("clouds", std::to_string(contents_.clouds.size()) + " clouds at one time",
                     "merge some: at most " + std::to_string(kMaxClouds) + " can overlap");
  }
  for (std::size_t band = 0; band < contents_.bands.size(); ++band) {
    const auto count = contents_.bands[band].intervals().size();
    for (std::size_t j = 0; j < count; ++j) {
      intervals_.push_back({static_cast<int>(band), static_cast<int>(j)});
    }
  }
  if (contents_.sun) suns_.push_back(*contents_.sun);
  if (contents_.moon) suns_.push_back(*contents_.moon);
  place_clouds();
  place_surfaces();
  make_map_frame();
  light_surfaces();
}

void World::place_clouds() {
  for (const Cloud& cloud : contents_.clouds) {
    frames_.push_back(make_cloud_frame(cloud));
    largest_leaf_m_ = std::max(largest_leaf_m_, largest_leaf_m(cloud));
    for (std::size_t axis = 0; axis < 2; ++axis) {
      if (cloud.period_m[axis] <= 0) continue;
      if (!periodic()) periodic_cloud_ = static_cast<int>(frames_.size()) - 1;
      Vec3d side(0);
      side[static_cast<int>(axis)] = cloud.period_m[axis];
      period_[axis] = transform_direction(cloud.local_to_world, side);
    }
  }
  for (int i = 0; i < interval_count(); ++i) {
    for (const Cloud& cloud : contents_.clouds) {
      const IntervalIndex where = interval(i);
      optics_.emplace_back(cloud, contents_.bands[static_cast<std::size_t>(where.band)], where.interval, i);
    }
  }
  // A cloud that neither attenuates nor emits is left out of the bounds, so that it changes no bit of any result.
  for (int c = 0; c < cloud_count(); ++c) {
    const Cloud& cloud = contents_.clouds[static_cast<std::size_t>(c)];
    bool acts = false;
    for (int i = 0; i < interval_count(); ++i) {
      for (const CloudOptics::Part& part : SpectralWorld(*this, i).optics(c).parts()) {
        acts = acts || (part.extinction > 0 && cloud.octree->bounds(part.channel).max > 0);
      }
    }
    for (const double emission : cloud.emission) acts = acts || emission > 0;
    const Box3d& local = frame(c).local_bounds;
    if (acts && !local.isEmpty()) cloud_bounds_.extendBy(transform_box(cloud.local_to_world, local));
  }
  bounds_ = cloud_bounds_;
}

void World::make_map_frame() {
  map_to_world_.makeIdentity();
  map_to_world_.setTranslation(origin_);
  if (periodic()) {
    const CloudFrame& f = frame(periodic_cloud_);
    const Affine& placed = clouds()[static_cast<std::size_t>(periodic_cloud_)].local_to_world;
    // The cell's sides are at right angles: a placement rotates and scales alike along all axes.
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d side(0);
      side[axis] = 1;
      side = transform_direction(placed, side);
      const double scale = side.length();
      for (int i = 0; i < 3; ++i) map_to_world_[axis][i] = side[i] / scale;
      if (axis < 2) map_period_[axis] = scale * f.period_m[static_cast<std::size_t>(axis)];
    }
    // By hand: Imath's setTranslation() would undo the rotation.
    const Vec3d corner = transform_point(placed, f.local_bounds.min);
    for (int i = 0; i < 3; ++i) map_to_world_[3][i] = corner[i];
  }
  world_to_map_ = map_to_world_.inverse();
  for (CloudFrame& f : frames_) {
    f.map_to_local = map_to_world_ * f.world_to_local;
    f.map_to_index = map_to_world_ * f.world_to_index;
  }
}

Vec3d World::index_point(int cloud, const Vec3d& point) const noexcept {
  const CloudFrame& f = frame(cloud);
  if (!f.periodic()) return transform_point(f.world_to_index, point);
  return transform_point(f.local_to_index, f.wrap(transform_point(f.world_to_local, point)));
}

Vec3d World::wrap(const Vec3d& point) const noexcept {
  if (!periodic()) return point;
  const CloudFrame& f = frame(periodic_cloud_);
  const Affine& placed = clouds()[static_cast<std::size_t>(periodic_cloud_)].local_to_world;
  return transform_point(placed, f.wrap(transform_point(f.world_to_local, point)));
}

}  // namespace obscura
