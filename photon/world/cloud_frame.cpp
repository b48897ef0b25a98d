#include "photon/world/cloud_frame.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "octree/base/error.h"

namespace obscura {
namespace {

/// Of a cell of this level in the world, m.
double longest_side(const Cloud& cloud, int level) noexcept {
  double side = 0;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3d edge(0);
    edge[axis] = std::ldexp(1.0, level);
    side = std::max(side, transform_direction(cloud.octree->index_to_local() * cloud.local_to_world, edge).length());
  }
  return side;
}

}  // namespace

CloudFrame make_cloud_frame(const Cloud& cloud) {
  CloudFrame frame;
  if (!(std::abs(linear_determinant(cloud.local_to_world)) > 0)) {
    throw InputError("cloud \"" + cloud.name + "\"", "its placement has no volume", "give a scale greater than 0");
  }
  if (cloud.octree->channel_count() > Cloud::kMaxChannels) {
    throw InputError("cloud \"" + cloud.name + "\"", std::to_string(cloud.octree->channel_count()) + " channels",
                     "divide them among clouds: at most " + std::to_string(Cloud::kMaxChannels) + " in one");
  }
  frame.world_to_local = cloud.local_to_world.inverse();
  frame.local_to_index = cloud.octree->local_to_index();
  frame.world_to_index = frame.world_to_local * frame.local_to_index;
  const Box3i domain = cloud.octree->domain();
  if (!domain.isEmpty()) {
    frame.local_bounds = transform_box(cloud.octree->index_to_local(), Box3d(Vec3d(domain.min), Vec3d(domain.max)));
  }
  frame.period_m = cloud.period_m;
  frame.voxel_m = longest_side(cloud, 0);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const int a = static_cast<int>(axis);
    const double size = frame.local_bounds.max[a] - frame.local_bounds.min[a];
    if (cloud.period_m[axis] > 0 && !domain.isEmpty() && cloud.period_m[axis] < size * (1 - 1e-9)) {
      throw InputError("cloud \"" + cloud.name + "\"",
                       "its period along " + std::string(axis ? "y" : "x") + ", " +
                           std::to_string(cloud.period_m[axis]) + " m, is smaller than the grid, " +
                           std::to_string(size) + " m",
                       "give a period_m of at least the grid's size");
    }
  }
  return frame;
}

double largest_leaf_m(const Cloud& cloud) noexcept {
  int level = 3;
  for (std::uint32_t i = 0; i < cloud.octree->block_count(); ++i)
    level = std::max(level, cloud.octree->block(i).cell.level);
  return longest_side(cloud, level);
}

Vec3d CloudFrame::wrap(Vec3d local) const noexcept {
  for (int axis = 0; axis < 2; ++axis) {
    const double period = period_m[static_cast<std::size_t>(axis)];
    if (period > 0) {
      local[axis] -= period * std::floor((local[axis] - local_bounds.min[axis]) / period);
    }
  }
  return local;
}

CellRays::CellRays(const CloudFrame& frame, const Ray& world_ray) noexcept : frame_(&frame) {
  if (!frame.periodic()) {
    local_ = world_ray;
    return;
  }
  local_ = transform_ray(frame.world_to_local, world_ray);
  // The layer that the cells fill: bounded only where the cloud does not repeat.
  Box3d layer = frame.local_bounds;
  for (int axis = 0; axis < 2; ++axis) {
    if (frame.period_m[static_cast<std::size_t>(axis)] > 0) {
      layer.min[axis] = -kInfinity;
      layer.max[axis] = kInfinity;
    }
  }
  const auto [enter, leave] = clip(local_, layer);
  done_ = frame.local_bounds.isEmpty() || !(enter < leave);
  if (done_) return;
  local_.t_min = t_ = enter;
  local_.t_max = leave;
  for (int axis = 0; axis < 2; ++axis) {
    const double period = frame.period_m[static_cast<std::size_t>(axis)];
    if (period <= 0) continue;
    const double cell = (local_.at(t_)[axis] - frame.local_bounds.min[axis]) / period;
    // On a border the ray is in the cell that it goes into.
    cell_[static_cast<std::size_t>(axis)] = local_.direction[axis] < 0 ? std::ceil(cell) - 1 : std::floor(cell);
  }
}

std::optional<Ray> CellRays::next() noexcept {
  if (done_) return std::nullopt;
  if (!frame_->periodic()) {
    done_ = true;
    return transform_ray(frame_->world_to_index, local_);
  }
  for (;;) {
    if (t_ >= local_.t_max || cells_++ >= kMaxCells) {
      done_ = true;
      return std::nullopt;
    }
    // Where the ray leaves the present cell.
    double leave = local_.t_max;
    std::size_t leave_axis = 2;
    Ray piece = local_;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double period = frame_->period_m[axis];
      if (period <= 0) continue;
      const int a = static_cast<int>(axis);
      const double d = local_.direction[a];
      piece.origin[a] -= cell_[axis] * period;
      if (d == 0) continue;
      const double border = frame_->local_bounds.min[a] + (cell_[axis] + (d > 0 ? 1 : 0)) * period;
      const double t = (border - local_.origin[a]) / d;
      if (t < leave) {
        leave = t;
        leave_axis = axis;
      }
    }
    piece.t_min = t_;
    piece.t_max = std::max(leave, t_);
    t_ = piece.t_max;
    if (leave_axis < 2) {
      cell_[leave_axis] += local_.direction[static_cast<int>(leave_axis)] > 0 ? 1 : -1;
    } else {
      done_ = true;
    }
    if (piece.t_max > piece.t_min) return transform_ray(frame_->local_to_index, piece);
  }
}

}  // namespace obscura
