#include "photon/spot/spot_search.h"

#include <algorithm>

namespace obscura {
namespace {

/// Embree's own rounding, of the scene's size: rays see faces displaced by so much (photon/METHODS.md, "The spot").
constexpr double kFloatRounding = 3e-7;
constexpr int kMostMirrors = 4;
constexpr int kMostPermeable = 16;

}  // namespace

SpotQuery::Search::Search(const World& world, const SpotThresholds& thresholds, int specular_depth)
    : world_(world), asked_(thresholds), depth_(static_cast<std::size_t>(std::clamp(specular_depth, 0, kMostMirrors))) {
  for (const Material& material : world.materials()) {
    const bool reflects =
        !material.angle_factor.empty() ||
        std::any_of(material.emissivity.begin(), material.emissivity.end(), [](double e) { return e < 1; });
    mirror_.push_back(reflects && material.specular > 0 && !(material.roughness > 0));
    by_angle_ = by_angle_ || !material.angle_factor.empty();
  }
  for (std::size_t i = 0; i <= depth_; ++i) levels_.push_back({detail::Seen(world, thresholds), {}});
  if (world.surfaces().empty()) return;
  index_ = &world.surfaces().index();
  slack_ = kFloatRounding * index_->reach();
}

Criterion SpotQuery::Search::operator()(const Spot& spot) {
  if (asked_.polygons && *asked_.polygons <= 0) return Criterion::polygons;
  if (asked_.polygons_strict && *asked_.polygons_strict <= 0) return Criterion::polygons;
  if (asked_.materials && *asked_.materials <= 0) return Criterion::materials;
  if (!index_ && world_.suns().empty()) return Criterion::none;

  Looking looking;
  looking.spot = spot;
  looking.middle.origin = Vec3d(0);
  looking.middle.direction = Vec3d(0);
  for (const Ray& ray : spot.corners) {
    looking.middle.origin += 0.25 * ray.origin;
    looking.middle.direction += ray.direction;
    looking.middle.t_min = std::max(looking.middle.t_min, ray.t_min);
  }
  if (spot.corners[0].origin == spot.corners[2].origin) looking.middle.origin = spot.corners[0].origin;
  looking.has_middle = looking.middle.direction.length() > 0;
  if (looking.has_middle) looking.middle.direction.normalize();

  levels_[0].seen.clear();
  levels_[0].mirrors.clear();
  const Criterion found = look(looking, 0);
  return found != Criterion::none ? found : reflect(0);
}

Criterion SpotQuery::Search::reflect(std::size_t level) {
  if (level == depth_ || levels_[level].mirrors.empty()) return Criterion::none;
  levels_[level + 1].seen.clear();
  levels_[level + 1].mirrors.clear();
  for (const Looking& mirror : levels_[level].mirrors) {
    if (look(mirror, level + 1) != Criterion::none) return Criterion::reflection;
  }
  return reflect(level + 1);
}

Criterion SpotQuery::Search::look(const Looking& looking, std::size_t at) {
  Level& level = levels_[at];
  cover_.clear();
  covered_ = cover_known_ = false;
  cover_surface_ = visited_surface_ = FaceId::kNone;
  limit_ = kInfinity;
  front_.reset();
  faces_ = 0;
  if (!index_) {
    const Region region(looking.spot, Vec3d(0), 0, nullptr);
    const Criterion found = level.seen.add_sky();
    return found != Criterion::none ? found : add_discs(region, level);
  }
  double slack = slack_;
  for (const Ray& ray : looking.spot.corners) {
    slack = std::max(slack,
                     slack_ + 16 * std::numeric_limits<double>::epsilon() * (ray.origin - index_->origin()).length());
  }
  const Region region(looking.spot, index_->origin(), slack, looking.mirror ? &*looking.mirror : nullptr);
  unsure_ = 8 * std::numeric_limits<double>::epsilon() * (index_->reach() + region.eye().length());

  // What the middle ray meets may cover the spot.
  Criterion found = Criterion::none;
  if (looking.has_middle) {
    Ray ray = looking.middle;
    FaceId from = looking.from;
    for (int i = 0; i < kMostPermeable; ++i) {
      const SurfaceHit hit = world_.surfaces().intersect(ray, from);
      if (!hit.exists()) break;
      const FaceId id = hit.id;
      const bool mesh = id.surface < index_->objects().size() && index_->objects()[id.surface].mesh;
      const bool object = id.surface < index_->objects().size();
      if (object && permeable(id.surface, id.face)) {
        ray.t_min = hit.t;
        from = id;
        continue;
      }
      if (mesh) {
        found = flood(region, looking, id, level);
      } else {
        visited_surface_ = id.surface;  // not to be seen twice
        found = see(region, index_->ball(id.surface), level);
      }
      break;
    }
  }
  if (found != Criterion::none) return found;
  if (!covered_) {
    limit_ = kInfinity;
    front_.reset();
    cover_.clear();
    found = level.seen.add_sky();
    if (found == Criterion::none) found = add_discs(region, level);
    if (found != Criterion::none) return found;
  }
  return search_all(region, looking, level);
}

Criterion SpotQuery::Search::gave_up() const noexcept {
  if (asked_.polygons || asked_.polygons_strict) return Criterion::polygons;
  if (asked_.materials) return Criterion::materials;
  if (asked_.normal) return Criterion::normal;
  if (asked_.depth) return Criterion::depth;
  if (asked_.temperature_K) return Criterion::temperature;
  return asked_.emissivity ? Criterion::emissivity : Criterion::none;
}

std::size_t SpotQuery::Search::slot_of(std::uint32_t object, std::uint32_t face) const noexcept {
  const Object& o = index_->objects()[object];
  return o.mesh && !o.mesh->slots.empty() ? o.mesh->slots[face] : 0;
}

bool SpotQuery::Search::permeable(std::uint32_t object, std::uint32_t face) const noexcept {
  const int material = index_->objects()[object].materials[slot_of(object, face)];
  return world_.materials()[static_cast<std::size_t>(material)].permeable > 0;
}

Criterion SpotQuery::Search::search_all(const Region& region, const Looking& looking, Level& level) {
  std::array<HalfSpace, BoxTree::kMaxPlanes> planes, in_mesh;
  std::size_t count = region.planes().size();
  std::copy(region.planes().begin(), region.planes().end(), planes.begin());
  if (limit_ < kInfinity) planes[count++] = {-region.axis(), limit_ + region.axis().dot(region.eye())};
  if (front_) planes[count++] = *front_;
  const std::span<const HalfSpace> all(planes.data(), count);

  Criterion found = Criterion::none;
  index_->tree().any(all, [&](std::uint32_t entry) {
    const FaceIndex::Entry& one = index_->entries()[entry];
    if (one.ball) {
      if (one.object != visited_surface_ && one.object != looking.from.surface) found = see(region, *one.ball, level);
      return found != Criterion::none;
    }
    const MeshIndex& mesh = *index_->mesh(one.object);
    const Affine& map = index_->to_scene(one.object);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3d& n = planes[i].normal;
      Vec3d normal;
      for (int axis = 0; axis < 3; ++axis) normal[axis] = map[axis][0] * n.x + map[axis][1] * n.y + map[axis][2] * n.z;
      const double offset = planes[i].offset + n.dot(Vec3d(map[3][0], map[3][1], map[3][2]));
      in_mesh[i] = {normal, offset + normal.dot(mesh.middle)};
    }
    return mesh.tree.any({in_mesh.data(), count}, [&](std::uint32_t face) {
      if (one.object == visited_surface_ && visited_.contains(face)) return false;
      if (++faces_ > 4 * kMostFaces) {
        found = gave_up();
        return found != Criterion::none;
      }
      const std::array<Vec3d, 3> p = index_->corners(one.object, face);
      const Vec3d across = (p[1] - p[0]).cross(p[2] - p[0]);
      if (!(across.length2() > 0)) return false;
      Fragment part(p);
      if (!part.cut(all)) return false;
      const FaceId id{one.object, face};
      if (looking.flat) {
        double highest = -kInfinity;
        for (std::size_t i = 0; i < part.size; ++i) highest = std::max(highest, region.start().height(part.corners[i]));
        if (highest <= unsure_) return false;
      }
      if (hidden(region, id, part)) return false;
      found = see(region, looking, id, p, across.normalized(), part, level);
      return found != Criterion::none;
    });
  });
  return found;
}

}  // namespace obscura
