// Photons of sun, moon and sky: where they enter, and from which direction.
#include <algorithm>
#include <cmath>

#include "photon/optics/sampling.h"
#include "photon/trace/emission.h"

namespace obscura {

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
      // A little farther, so that light starts before the rectangle and not on it.
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

double PhotonEmitter::area_towards(const Sun& sun) const noexcept {
  const auto across = [this](const Vec3d& toward) {
    double area = 0;
    for (const Face& face : faces_) area += face.area * std::max(0.0, -face.inward.dot(toward));
    return area;
  };
  const double half = std::sin(0.5 * sun.diameter);
  const bool on_horizon =
      std::ranges::any_of(faces_, [&](const Face& face) { return std::abs(face.inward.dot(sun.toward)) < half; });
  if (!on_horizon) return across(sun.toward);
  // A part of the disc is in front of a face and a part behind it.
  constexpr int kSide = 64;
  double sum = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const double u = (i % kSide + 0.5) / kSide, v = (i / kSide + 0.5) / kSide;
    sum += across(cone_direction(sun.toward, half, u, v).first);
  }
  return sum / (kSide * kSide);
}

void PhotonEmitter::make_targets() {
  targets_.push_back({middle_, radius_, 1.0});
  // Where the World is much larger than its clouds (terrain of kilometres about a puff of metres), most photons are
  // aimed at the surroundings of the clouds.
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

EmittedPhoton PhotonEmitter::from_sun(int index, const std::array<double, 8>& u) const noexcept {
  const Sun& sun = world_->suns()[static_cast<std::size_t>(index)];
  const double irradiance = world_.value_of(sun.irradiance);
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
    photon.power = kPi * world_.sky() * total;
    return photon;
  }
  const Vec3d from = uniform_direction(u[4], u[5]);
  const auto [position, density] = place_beyond(from, u[1], u[2], u[3]);
  photon.position = position;
  photon.direction = -from;
  photon.power = 4 * kPi * world_.sky() / density;
  return photon;
}

}  // namespace obscura
