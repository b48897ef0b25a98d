#include "photon/trace/emission.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>

#include "photon/optics/sampling.h"

namespace obscura {
namespace {

/// Least share of a thick source's photons: below it the weights of neighbours would differ so much
/// that the noise which thick cores are spared comes back at their borders.
constexpr double kLeastChance = 0.1;

/// A bounded estimate of the chance that light leaves a cube of side a: min(1, A / (4 k_a V)).
double escape_chance(double absorption, double side) noexcept {
  return std::clamp(1.5 / std::max(absorption * side, 1e-300), kLeastChance, 1.0);
}

}  // namespace

PhotonEmitter::PhotonEmitter(const World& world, int interval, const SourceSelection& selection, const Box3d& around)
    : world_(&world), interval_(interval) {
  const auto at = [interval](const std::vector<double>& values) { return values[static_cast<std::size_t>(interval)]; };
  const auto add = [this](Kind kind, int index, double power, double chance) {
    if (!(power > 0)) return;
    power_ += power;
    sources_.push_back({kind, index, power, chance});
  };
  Box3d bounds = world.bounds();
  if (!around.isEmpty()) bounds.extendBy(around);
  if (!bounds.isEmpty()) {
    middle_ = bounds.center();
    radius_ = 0.5 * bounds.size().length();
  }
  if (world.periodic()) {
    make_faces(around);
  } else {
    make_targets();
  }

  blocks_.resize(static_cast<std::size_t>(world.cloud_count()));
  for (int c = 0; selection.emission && c < world.cloud_count(); ++c) {
    if (!world.optics(c, interval).emits()) continue;
    Blocks& blocks = blocks_[static_cast<std::size_t>(c)];
    blocks = sum_blocks(c);
    if (!blocks.cumulative.empty()) add(Kind::cloud, c, blocks.emitted, blocks.cumulative.back());
  }
  for (std::size_t i = 0; selection.sun && i < world.suns().size(); ++i) {
    const Sun& sun = world.suns()[i];
    double area = kPi * radius_ * radius_;
    if (world.periodic()) {
      area = 0;
      for (const Face& face : faces_) area += face.area * std::max(0.0, -face.inward.dot(sun.toward));
    }
    const double power = at(sun.irradiance) * area;
    add(Kind::sun, static_cast<int>(i), power, power);
  }
  if (selection.sky && world.sky(interval) > 0) {
    double area = 4 * kPi * radius_ * radius_;
    if (world.periodic()) {
      area = 0;
      for (const Face& face : faces_) area += face.area;
    }
    const double power = kPi * world.sky(interval) * area;
    add(Kind::sky, 0, power, power);
  }
  const FaceLights& lights = world.face_lights(interval);
  if (selection.surfaces && !lights.empty()) {
    add(Kind::faces, 0, lights.power(), lights.power());
    // What of that power goes through the surroundings of the clouds has a source of its own, whose power
    // only its photons know: it is counted with the faces'.
    if (targets_.size() > 1) sources_.push_back({Kind::lines, 0, 0.0, lights.power()});
  }
  const std::vector<HotSphere>& spheres = world.spheres();
  for (std::size_t s = 0; s < spheres.size(); ++s) {
    if (!(s < world.source_count() ? selection.spheres : selection.particles)) continue;
    const double power = at(spheres[s].radiance) * 4 * kPi * kPi * spheres[s].radius * spheres[s].radius;
    add(Kind::sphere, static_cast<int>(s), power, power);
  }
  for (std::size_t b = 0; selection.beams && b < world.beams().size(); ++b) {
    const double power = at(world.beams()[b].power);
    add(Kind::beam, static_cast<int>(b), power, power);
  }
  make_groups();
  sum_chances();
}

void PhotonEmitter::make_groups() {
  const auto same_group = [](const Source& a, const Source& b) { return a.kind == b.kind && a.kind != Kind::cloud; };
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (s == 0 || !same_group(sources_[s - 1], sources_[s])) groups_.emplace_back();
    groups_.back().push_back(s);
  }
}

void PhotonEmitter::sum_chances() {
  cumulative_.clear();
  for (const Source& source : sources_) {
    cumulative_.push_back((cumulative_.empty() ? 0.0 : cumulative_.back()) + source.chance);
  }
}

PhotonEmitter PhotonEmitter::only(std::size_t group) const {
  PhotonEmitter result = *this;
  result.sources_.clear();
  result.power_ = 0;
  for (const std::size_t s : groups_[group]) {
    result.sources_.push_back(sources_[s]);
    result.power_ += sources_[s].power;
  }
  result.groups_.clear();
  result.make_groups();
  result.sum_chances();
  return result;
}

void PhotonEmitter::set_shares(std::span<const double> shares) {
  assert(shares.size() == groups_.size());
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    double sum = 0;
    for (const std::size_t s : groups_[g]) sum += sources_[s].chance;
    for (const std::size_t s : groups_[g]) sources_[s].chance *= shares[g] / sum;
  }
  sum_chances();
}

PhotonEmitter::Blocks PhotonEmitter::sum_blocks(int cloud) const {
  const Octree& octree = *world_->clouds()[static_cast<std::size_t>(cloud)].octree;
  const CloudOptics& optics = world_->optics(cloud, interval_);
  const Affine& placed = world_->clouds()[static_cast<std::size_t>(cloud)].local_to_world;
  const double voxel_volume = std::abs(linear_determinant(octree.index_to_local()) * linear_determinant(placed));
  const double voxel_side = std::cbrt(voxel_volume);
  const std::uint32_t count = octree.block_count();
  std::vector<double> power(count);
  Blocks blocks;
  blocks.chance.resize(count);

  // Power and mean absorption of every block, in parallel.
  tbb::parallel_for(std::uint32_t{0}, count, [&](std::uint32_t b) {
    const Block block = octree.block(b);
    std::vector<std::array<float, 512>> values(static_cast<std::size_t>(octree.channel_count()));
    for (int c = 0; c < octree.channel_count(); ++c) {
      octree.decode(b, c, std::span<float, 512>(values[static_cast<std::size_t>(c)]));
    }
    double emission = 0;
    double absorption = 0;
    const std::size_t voxels = block.uniform ? 1 : 512;
    for (std::size_t v = 0; v < voxels; ++v) {
      const LocalOptics local =
          optics.at([&](int channel) noexcept { return values[static_cast<std::size_t>(channel)][v]; });
      emission += local.emission;
      absorption += local.emission * (local.extinction - local.scattering);
    }
    const double volume = voxel_volume * (block.uniform ? std::pow(8.0, block.cell.level) : 1.0);
    power[b] = 4 * kPi * volume * emission;
    const double side = voxel_side * (block.uniform ? std::exp2(block.cell.level) : 1.0);
    blocks.chance[b] = static_cast<float>(escape_chance(emission > 0 ? absorption / emission : 0.0, side));
  });

  blocks.cumulative.resize(count);
  double sum = 0;
  for (std::uint32_t b = 0; b < count; ++b) {
    blocks.emitted += power[b];
    sum += power[b] * static_cast<double>(blocks.chance[b]);
    blocks.cumulative[b] = sum;
  }
  return blocks;
}

void PhotonEmitter::make_faces(const Box3d& around) {
  // The cell is a box in the frame of the first periodic cloud, which reaches as far as what light has to
  // pass; light enters through the faces that have no neighbour.
  for (int c = 0; c < world_->cloud_count(); ++c) {
    const CloudFrame& frame = world_->frame(c);
    if (!frame.periodic()) continue;
    const Affine& placed = world_->clouds()[static_cast<std::size_t>(c)].local_to_world;
    Box3d cell;
    for (int other = 0; other < world_->cloud_count(); ++other) {
      const Box3d& bounds = world_->frame(other).local_bounds;
      if (bounds.isEmpty()) continue;
      const Affine there = world_->clouds()[static_cast<std::size_t>(other)].local_to_world;
      cell.extendBy(transform_box(there * frame.world_to_local, bounds));
    }
    if (cell.isEmpty()) return;
    if (!around.isEmpty()) {
      // A little farther: what starts on a rectangle has passed it.
      Box3d reach = transform_box(frame.world_to_local, around);
      const Vec3d margin(1e-3 * (cell.size().length() + reach.size().length()));
      cell.extendBy(Box3d(reach.min - margin, reach.max + margin));
    }
    for (int axis = 0; axis < 2; ++axis) {
      if (frame.period_m[static_cast<std::size_t>(axis)] > 0) {
        cell.min[axis] = frame.local_bounds.min[axis];
        cell.max[axis] = cell.min[axis] + frame.period_m[static_cast<std::size_t>(axis)];
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      if (axis < 2 && frame.period_m[static_cast<std::size_t>(axis)] > 0) continue;
      const int u = (axis + 1) % 3;
      const int v = (axis + 2) % 3;
      for (const bool upper : {false, true}) {
        Vec3d corner = cell.min;
        if (upper) corner[axis] = cell.max[axis];
        Vec3d side_u(0), side_v(0), inward(0);
        side_u[u] = cell.max[u] - cell.min[u];
        side_v[v] = cell.max[v] - cell.min[v];
        inward[axis] = upper ? -1 : 1;
        Face face;
        face.corner = transform_point(placed, corner);
        face.side_u = transform_direction(placed, side_u);
        face.side_v = transform_direction(placed, side_v);
        face.inward = transform_direction(placed, inward).normalized();
        face.area = face.side_u.cross(face.side_v).length();
        faces_.push_back(face);
      }
    }
    return;
  }
}

void PhotonEmitter::make_targets() {
  targets_.push_back({middle_, radius_, 1.0});
  // What is far from all clouds matters little to them: terrain of kilometres about a puff of metres.
  const Box3d& clouds = world_->cloud_bounds();
  if (clouds.isEmpty()) return;
  constexpr double kAround = 1.5, kMuchLarger = 3, kShare = 0.75;
  const double radius = kAround * 0.5 * clouds.size().length();
  if (radius_ < kMuchLarger * radius) return;
  targets_.push_back({clouds.center(), radius, kShare});
  targets_.front().share = 1 - kShare;
}

std::pair<Vec3d, double> PhotonEmitter::place_beyond(const Vec3d& toward, double u, double v,
                                                     double which) const noexcept {
  const Target& target = targets_[targets_.size() > 1 && which < targets_[1].share ? 1 : 0];
  const auto [x, y] = uniform_disc(u, v);
  const auto [a, b] = orthonormal_basis(toward);
  const Vec3d across = target.center + target.radius * (x * a + y * b);
  // Discs overlap: the density is that of all.
  double density = 0;
  for (const Target& other : targets_) {
    const Vec3d offset = across - other.center;
    const double along = offset.dot(toward);
    if (&other == &target || offset.length2() - along * along < other.radius * other.radius) {
      density += other.share / (kPi * other.radius * other.radius);
    }
  }
  return {across + (radius_ - (across - middle_).dot(toward)) * toward, density};
}

Work PhotonEmitter::work_of(Kind kind) noexcept {
  switch (kind) {
    case Kind::cloud:
      break;
    case Kind::sun:
      return Work::photons_sun;
    case Kind::sky:
      return Work::photons_sky;
    case Kind::faces:
    case Kind::lines:
      return Work::photons_faces;
    case Kind::sphere:
      return Work::photons_spheres;
    case Kind::beam:
      return Work::photons_beams;
  }
  return Work::photons_emission;
}

EmittedPhoton PhotonEmitter::emit(const std::array<double, 8>& u, Cache& cache) const noexcept {
  assert(!sources_.empty());
  double rest = u[0];
  const Source& source = sources_[choose(cumulative_, cumulative_.size(), rest)];
  EmittedPhoton photon;
  switch (source.kind) {
    case Kind::cloud:
      photon = from_cloud(source.index, rest, u, cache);
      break;
    case Kind::sun:
      photon = from_sun(source.index, u);
      break;
    case Kind::sky:
      photon = from_sky(u);
      break;
    case Kind::faces:
      photon = from_faces(rest, u);
      break;
    case Kind::lines:
      photon = from_lines(u);
      break;
    case Kind::sphere:
      photon = from_sphere(source.index, u);
      break;
    case Kind::beam:
      photon = from_beam(source.index, u);
      break;
  }
  photon.work = work_of(source.kind);
  // Chosen with probability chance / sum of chances; the source's own photon carries all its power.
  photon.power *= cumulative_.back() / source.chance;
  return photon;
}

EmittedPhoton PhotonEmitter::from_cloud(int cloud, double u, const std::array<double, 8>& v,
                                        Cache& cache) const noexcept {
  const Octree& octree = *world_->clouds()[static_cast<std::size_t>(cloud)].octree;
  const CloudOptics& optics = world_->optics(cloud, interval_);
  const Blocks& blocks = blocks_[static_cast<std::size_t>(cloud)];
  const auto b = static_cast<std::uint32_t>(choose(blocks.cumulative, blocks.cumulative.size(), u));
  const Block block = octree.block(b);

  // A voxel of the block in proportion to its emission, then a place in it.
  Vec3d corner(block.cell.corner);
  double side = 1;
  if (block.uniform) {
    side = std::exp2(block.cell.level);
  } else {
    if (cache.cloud != cloud || cache.block != b) {
      std::array<std::array<float, 512>, Cloud::kMaxChannels> values;
      for (int c = 0; c < octree.channel_count(); ++c) {
        octree.decode(b, c, std::span<float, 512>(values[static_cast<std::size_t>(c)]));
      }
      double sum = 0;
      for (std::size_t i = 0; i < 512; ++i) {
        sum += optics.at([&](int channel) noexcept { return values[static_cast<std::size_t>(channel)][i]; }).emission;
        cache.cumulative[i] = static_cast<float>(sum);
      }
      cache.cloud = cloud;
      cache.block = b;
    }
    const std::size_t i = choose(cache.cumulative, 512, u);
    corner += Vec3d(static_cast<double>(i & 7), static_cast<double>((i >> 3) & 7), static_cast<double>(i >> 6));
  }
  const Vec3d index = corner + side * Vec3d(v[1], v[2], v[3]);
  const Affine& placed = world_->clouds()[static_cast<std::size_t>(cloud)].local_to_world;

  EmittedPhoton photon;
  photon.position = transform_point(placed, transform_point(octree.index_to_local(), index));
  photon.direction = uniform_direction(v[4], v[5]);
  photon.power = blocks.cumulative.back() / static_cast<double>(blocks.chance[b]);
  return photon;
}

EmittedPhoton PhotonEmitter::from_sun(int index, const std::array<double, 8>& u) const noexcept {
  const Sun& sun = world_->suns()[static_cast<std::size_t>(index)];
  const double irradiance = sun.irradiance[static_cast<std::size_t>(interval_)];
  const Vec3d toward = cone_direction(sun.toward, std::sin(0.5 * sun.diameter), u[4], u[5]).first;
  EmittedPhoton photon;
  photon.direction = -toward;
  photon.in_direct_set = true;
  photon.from_beyond = true;
  if (!faces_.empty()) {
    double total = 0;
    for (const Face& face : faces_) total += face.area * std::max(0.0, -face.inward.dot(toward));
    double target = u[3] * total;
    const Face* chosen = nullptr;
    for (const Face& face : faces_) {
      const double part = face.area * std::max(0.0, -face.inward.dot(toward));
      if (part <= 0) continue;
      chosen = &face;
      if (target < part) break;
      target -= part;
    }
    if (!chosen) return photon;  // the whole disc of a sun at the horizon is behind the faces
    photon.position = chosen->corner + u[1] * chosen->side_u + u[2] * chosen->side_v;
    photon.power = irradiance * total;
    return photon;
  }
  const auto [position, density] = place_beyond(toward, u[1], u[2], u[3]);
  photon.position = position;
  photon.power = irradiance / density;
  return photon;
}

EmittedPhoton PhotonEmitter::from_sky(const std::array<double, 8>& u) const noexcept {
  EmittedPhoton photon;
  photon.in_direct_set = true;
  photon.from_beyond = true;
  if (!faces_.empty()) {
    double total = 0;
    for (const Face& face : faces_) total += face.area;
    double target = u[3] * total;
    const Face* chosen = &faces_.back();
    for (const Face& face : faces_) {
      if (target < face.area) {
        chosen = &face;
        break;
      }
      target -= face.area;
    }
    photon.position = chosen->corner + u[1] * chosen->side_u + u[2] * chosen->side_v;
    photon.direction = cosine_direction(chosen->inward, u[4], u[5]);
    photon.power = kPi * world_->sky(interval_) * total;
    return photon;
  }
  const Vec3d from = uniform_direction(u[4], u[5]);
  const auto [position, density] = place_beyond(from, u[1], u[2], u[3]);
  photon.position = position;
  photon.direction = -from;
  photon.power = 4 * kPi * world_->sky(interval_) / density;
  return photon;
}

EmittedPhoton PhotonEmitter::from_faces(double u, const std::array<double, 8>& v) const noexcept {
  const FaceLights& lights = world_->face_lights(interval_);
  const FaceLights::Place place = lights.sample(*world_, u, v[1], v[2]);
  EmittedPhoton photon;
  photon.position = place.position;
  photon.direction = cosine_direction(place.normal, v[4], v[5]);
  photon.in_direct_set = true;
  photon.from = place.id;
  // The face was chosen by its mean radiance over all angles; here and there it differs.
  const double radiance = lights.emission(*world_, place, place.normal.dot(photon.direction));
  photon.power = kPi * radiance / lights.density(*world_, place.id);
  if (is_on_a_line(photon.position, photon.direction, place.id)) photon.power = 0;
  return photon;
}

EmittedPhoton PhotonEmitter::from_lines(const std::array<double, 8>& u) const noexcept {
  // A line through the sphere about the clouds, isotropic and uniform; it starts where it enters.
  const Target& target = targets_[1];
  const Vec3d direction = uniform_direction(u[4], u[5]);
  const auto [x, y] = uniform_disc(u[1], u[2]);
  const auto [a, b] = orthonormal_basis(direction);
  const double half = target.radius * std::sqrt(std::max(0.0, 1 - x * x - y * y));
  const Vec3d entry = target.center + target.radius * (x * a + y * b) - half * direction;

  // Faces that send light along it: the first opaque one behind the entry and the nets before it, and
  // those inside the sphere.
  struct Candidate {
    Vec3d position;
    FaceId id;
    double radiance;
  };
  constexpr std::size_t kMost = 16;
  std::array<Candidate, kMost> candidates;
  std::size_t count = 0;
  const auto offer = [&](const Ray& ray, const SurfaceHit& hit) {
    if (hit.id.surface >= world_->objects().size()) return;
    const Vec3d position = ray.at(hit.t);
    const double cosine = world_->surfaces().normal(hit.id, position).dot(direction);
    if (cosine < 0 && !world_->objects()[hit.id.surface].double_sided) return;
    const MaterialOptics& material = world_->material(interval_, hit.id);
    const double radiance = world_->black_radiance(interval_, hit.id, hit.u, hit.v) *
                            material.emissivity(std::abs(cosine)) * (1 - material.permeable());
    if (radiance > 0 && count < kMost) candidates[count++] = {position, hit.id, radiance};
  };
  for (const bool behind : {true, false}) {
    Ray ray{entry, behind ? -direction : direction, 0, behind ? kInfinity : 2 * half};
    SurfaceHit hit = world_->surfaces().intersect(ray);
    for (std::size_t i = 0; hit.exists() && i < kMost; ++i) {
      offer(ray, hit);
      if (behind && !is_net(hit.id)) break;
      ray.t_min = hit.t;
      hit = world_->surfaces().intersect(ray, hit.id);
    }
  }
  EmittedPhoton photon;
  photon.direction = direction;
  photon.in_direct_set = true;
  if (count == 0) return photon;
  const Candidate& chosen =
      candidates[std::min(count - 1, static_cast<std::size_t>(u[3] * static_cast<double>(count)))];
  photon.position = chosen.position;
  photon.from = chosen.id;
  photon.power = 4 * kPi * kPi * target.radius * target.radius * static_cast<double>(count) * chosen.radiance;
  return photon;
}

bool PhotonEmitter::is_net(const FaceId& face) const noexcept {
  return face.surface < world_->objects().size() && world_->material(interval_, face).permeable() > 0;
}

bool PhotonEmitter::is_on_a_line(const Vec3d& position, const Vec3d& direction, FaceId from) const noexcept {
  if (targets_.size() < 2) return false;
  const Target& target = targets_[1];
  const Vec3d to_center = target.center - position;
  const double r2 = target.radius * target.radius;
  if (to_center.length2() < r2) return true;
  const double along = to_center.dot(direction);
  const double half2 = r2 - (to_center - along * direction).length2();
  if (along < 0 || half2 <= 0) return false;
  // Unless something opaque stands before the sphere.
  Ray ray{position, direction, world_->surfaces().clearance(), along - std::sqrt(half2)};
  SurfaceHit hit = world_->surfaces().intersect(ray, from);
  while (hit.exists() && is_net(hit.id)) {
    ray.t_min = hit.t;
    hit = world_->surfaces().intersect(ray, hit.id);
  }
  return !hit.exists();
}

EmittedPhoton PhotonEmitter::from_sphere(int index, const std::array<double, 8>& u) const noexcept {
  const HotSphere& sphere = world_->spheres()[static_cast<std::size_t>(index)];
  const Vec3d normal = uniform_direction(u[1], u[2]);
  EmittedPhoton photon;
  photon.position = sphere.center + sphere.radius * normal;
  photon.direction = cosine_direction(normal, u[4], u[5]);
  photon.power = sphere.radiance[static_cast<std::size_t>(interval_)] * 4 * kPi * kPi * sphere.radius * sphere.radius;
  photon.in_direct_set = static_cast<std::size_t>(index) < world_->source_count();
  photon.from = {static_cast<std::uint32_t>(world_->objects().size()) + static_cast<std::uint32_t>(index), 0};
  return photon;
}

EmittedPhoton PhotonEmitter::from_beam(int index, const std::array<double, 8>& u) const noexcept {
  const Beam& beam = world_->beams()[static_cast<std::size_t>(index)];
  const auto [x, y] = uniform_disc(u[1], u[2]);
  const auto [a, b] = orthonormal_basis(beam.direction);
  EmittedPhoton photon;
  photon.position = beam.position + beam.radius * (x * a + y * b);
  photon.direction = beam.direction;
  photon.power = beam.power[static_cast<std::size_t>(interval_)];
  return photon;
}

}  // namespace obscura
