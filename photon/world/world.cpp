#include "photon/world/world.h"

#include <algorithm>
#include <utility>

#include "octree/base/error.h"
#include "photon/world/world_walk.h"

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

CloudFrame make_frame(const Cloud& cloud) {
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

/// One flight by the world walk, in double. Returns the optics of the segment that it collided in; the
/// end is kept off that segment's faces, so that a look-up there finds the same.
LocalOptics walk_to_depth(const World& world, int interval, const Flight& flight, FreePath& end) noexcept {
  end = {flight.ray.t_max, 0.0, false};
  WorldWalk walk(world, interval, flight.ray);
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

/// The batched walk is right to 2e-5 of a leaf: in one of this optical depth that is farther than light goes.
constexpr double kThick = 100;

/// The longest side of a cloud's leaves in the world, of bricks at least, m.
double largest_leaf(const Cloud& cloud) noexcept {
  int level = 3;
  for (std::uint32_t i = 0; i < cloud.octree->block_count(); ++i)
    level = std::max(level, cloud.octree->block(i).cell.level);
  return longest_side(cloud, level);
}

}  // namespace

CloudOptics::CloudOptics(const Cloud& cloud, const Band& band, int interval, int index)
    : temperature_(cloud.temperature) {
  const auto at = [index](const std::vector<double>& values) { return values[static_cast<std::size_t>(index)]; };
  weights_.assign(static_cast<std::size_t>(cloud.octree->channel_count()), 0.0);
  bool one_albedo = true;
  for (const Medium& medium : cloud.media) {
    const double extinction = at(medium.extinction);
    const double scattering = extinction * at(medium.albedo);
    blunted_.push_back(std::make_shared<const PhaseFunction>(medium.phase.blunted(kMapPeak)));
    parts_.push_back({medium.channel, extinction, scattering, &medium.phase, blunted_.back().get()});
    weights_[static_cast<std::size_t>(medium.channel)] += extinction;
    scatters_ = scatters_ || scattering > 0;
    one_albedo = one_albedo && at(medium.albedo) == at(cloud.media.front().albedo);
  }

  // Emission: the given source, or Planck's where there is a temperature.
  if (!cloud.source.empty() && cloud.source[static_cast<std::size_t>(index)]) {
    constant_source_ = *cloud.source[static_cast<std::size_t>(index)];
    temperature_.channel = -1;
  } else if (band.grey()) {
    temperature_.channel = -1;
  } else if (temperature_.channel < 0) {
    constant_source_ = temperature_.constant_K > 0 ? band.planck(interval, temperature_.constant_K) : 0.0;
  } else {
    const Bounds range = cloud.octree->bounds(temperature_.channel);
    const double a = temperature_.scale * range.min + temperature_.offset_K;
    const double b = temperature_.scale * range.max + temperature_.offset_K;
    // Cells without density are at 0 K: the table serves what a cloud can be, the rest is computed.
    const double warmest = std::max({a, b, 2.0});
    planck_.emplace(band, interval, std::clamp(std::min(a, b), 2.0, warmest), warmest);
  }
  if (!cloud.emission.empty()) added_ = at(cloud.emission);
  emits_ = temperature_.channel >= 0 || constant_source_ > 0 || added_ > 0;
  if (temperature_.channel < 0 && added_ == 0 && one_albedo && !cloud.media.empty()) {
    uniform_source_ = (1 - at(cloud.media.front().albedo)) * constant_source_;
  }
  if (emits_) {
    double largest_share = 0;
    for (const Part& part : parts_) {
      if (part.extinction > 0) largest_share = std::max(largest_share, 1 - part.scattering / part.extinction);
    }
    double warmest = constant_source_;
    if (temperature_.channel >= 0) warmest = source_range(cloud.octree->bounds(temperature_.channel)).second;
    largest_source_ = added_ > 0 ? kInfinity : largest_share * warmest;
  }
}

std::pair<double, double> CloudOptics::source_range(const Bounds& value) const noexcept {
  const double a = temperature_.scale * static_cast<double>(value.min) + temperature_.offset_K;
  const double b = temperature_.scale * static_cast<double>(value.max) + temperature_.offset_K;
  return {(*planck_)(std::min(a, b)), (*planck_)(std::max(a, b))};
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

World::World(WorldContents contents) : contents_(std::move(contents)) {
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
    frames_.push_back(make_frame(cloud));
    largest_leaf_m_ = std::max(largest_leaf_m_, largest_leaf(cloud));
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
  // A cloud that does nothing to light has no say in where anything lies: it must not change a bit.
  for (int c = 0; c < cloud_count(); ++c) {
    const Cloud& cloud = contents_.clouds[static_cast<std::size_t>(c)];
    bool acts = false;
    for (int i = 0; i < interval_count(); ++i) {
      for (const CloudOptics::Part& part : optics(c, i).parts()) {
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

double World::extinction_in_map(int interval, const Vec3d& point) const noexcept {
  double extinction = 0;
  for (int c = 0; c < cloud_count(); ++c) {
    const CloudFrame& f = frame(c);
    const Octree& octree = *clouds()[static_cast<std::size_t>(c)].octree;
    const Vec3d index = f.periodic() ? transform_point(f.local_to_index, f.wrap(transform_point(f.map_to_local, point)))
                                     : transform_point(f.map_to_index, point);
    for (const CloudOptics::Part& part : optics(c, interval).parts()) {
      extinction += part.extinction * static_cast<double>(octree.value(part.channel, index));
    }
  }
  return extinction;
}

bool World::attenuates(int interval) const noexcept {
  for (int c = 0; c < cloud_count(); ++c) {
    for (const CloudOptics::Part& part : optics(c, interval).parts()) {
      if (part.extinction > 0) return true;
    }
  }
  return false;
}

bool World::scatters(int interval) const noexcept {
  for (int c = 0; c < cloud_count(); ++c) {
    if (optics(c, interval).scatters()) return true;
  }
  return false;
}

bool World::emits(int interval) const noexcept {
  for (int c = 0; c < cloud_count(); ++c) {
    if (optics(c, interval).emits()) return true;
  }
  return false;
}

double World::largest_source(int interval) const noexcept {
  double largest = 0;
  for (int c = 0; c < cloud_count(); ++c) largest = std::max(largest, optics(c, interval).largest_source());
  return largest;
}

bool World::glows(int interval) const noexcept {
  return std::any_of(contents_.clouds.begin(), contents_.clouds.end(), [interval](const Cloud& cloud) {
    return !cloud.emission.empty() && cloud.emission[static_cast<std::size_t>(interval)] > 0;
  });
}

std::optional<double> World::uniform_source(int interval) const noexcept {
  std::optional<double> result;
  for (int c = 0; c < cloud_count(); ++c) {
    const std::optional<double> one = optics(c, interval).uniform_source();
    if (!one || (result && *result != *one)) return std::nullopt;
    result = one;
  }
  return result;
}

Vec3d World::index_point(int cloud, const Vec3d& point) const noexcept {
  const CloudFrame& f = frame(cloud);
  if (!f.periodic()) return transform_point(f.world_to_index, point);
  return transform_point(f.local_to_index, f.wrap(transform_point(f.world_to_local, point)));
}

LocalOptics World::at(int interval, const Vec3d& point) const noexcept {
  LocalOptics result;
  for (int c = 0; c < cloud_count(); ++c) {
    const Octree& octree = *clouds()[static_cast<std::size_t>(c)].octree;
    const Vec3d index = index_point(c, point);
    result += optics(c, interval).at([&](int channel) noexcept { return octree.value(channel, index); });
  }
  return result;
}

bool World::has_thick_leaves(int interval) const noexcept {
  double most = 0;
  for (int c = 0; c < cloud_count(); ++c) {
    for (const CloudOptics::Part& part : optics(c, interval).parts()) {
      most +=
          part.extinction * static_cast<double>(clouds()[static_cast<std::size_t>(c)].octree->bounds(part.channel).max);
    }
  }
  return most * largest_leaf_m_ > kThick;
}

LocalOptics World::at_collision(int interval, const Flight& flight, FreePath& end) const noexcept {
  const LocalOptics here = at(interval, flight.ray.at(end.t));
  if (here.extinction > 0 && here.extinction * largest_leaf_m_ <= kThick) return here;
  return walk_to_depth(*this, interval, flight, end);
}

Vec3d World::wrap(const Vec3d& point) const noexcept {
  if (!periodic()) return point;
  const CloudFrame& f = frame(periodic_cloud_);
  const Affine& placed = clouds()[static_cast<std::size_t>(periodic_cloud_)].local_to_world;
  return transform_point(placed, f.wrap(transform_point(f.world_to_local, point)));
}

double World::background(int interval, const Vec3d& direction, bool discs) const noexcept {
  double radiance = sky(interval);
  for (const Sun& sun : suns()) {
    if (discs && sun.covers(direction)) radiance += sun.radiance(interval);
  }
  return radiance;
}

void World::optical_depths(int interval, std::span<const Ray> rays, std::span<double> depths) const {
  std::vector<Ray> pieces;
  if (cloud_count() == 1 && !frame(0).periodic()) {
    pieces.resize(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) pieces[i] = transform_ray(frame(0).world_to_index, rays[i]);
    obscura::optical_depths(*clouds().front().octree, pieces, optics(0, interval).extinction_weights(), depths);
    return;
  }
  std::fill(depths.begin(), depths.end(), 0.0);
  std::vector<double> parts;
  for (int c = 0; c < cloud_count(); ++c) {
    const Octree& octree = *clouds()[static_cast<std::size_t>(c)].octree;
    const std::vector<double>& weights = optics(c, interval).extinction_weights();
    if (!frame(c).periodic()) {
      pieces.clear();
      for (const Ray& ray : rays) pieces.push_back(transform_ray(frame(c).world_to_index, ray));
      parts.resize(rays.size());
      obscura::optical_depths(octree, pieces, weights, parts);
      for (std::size_t i = 0; i < rays.size(); ++i) depths[i] += parts[i];
      continue;
    }
    // One round per cell that the rays cross.
    std::vector<CellRays> cells;
    cells.reserve(rays.size());
    for (const Ray& ray : rays) cells.emplace_back(frame(c), ray);
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

void World::reach_depths(int interval, std::span<const Flight> flights, std::span<FreePath> ends) const {
  if (cloud_count() == 1) {
    const Octree& octree = *clouds().front().octree;
    const std::vector<double>& weights = optics(0, interval).extinction_weights();
    // The batched walk is right to about 2e-5 of the cloud's size: too little for flights that are short
    // beside it, whose walk in double is short too.
    const Vec3d extent = frame(0).local_bounds.max - frame(0).local_bounds.min;
    const double size = transform_direction(clouds().front().local_to_world, extent).length();
    const auto refine = [&](const Flight& flight, FreePath& end) {
      if (end.t - flight.ray.t_min < 2e-3 * size) walk_to_depth(*this, interval, flight, end);
    };
    if (!frame(0).periodic()) {
      std::vector<Flight> own(flights.begin(), flights.end());
      for (Flight& flight : own) flight.ray = transform_ray(frame(0).world_to_index, flight.ray);
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
    for (const Flight& flight : flights) cells.emplace_back(frame(0), flight.ray);
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
  for (std::size_t i = 0; i < flights.size(); ++i) walk_to_depth(*this, interval, flights[i], ends[i]);
}

}  // namespace obscura
