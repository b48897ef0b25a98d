#include "photon/spot/spot_search.h"

#include <algorithm>

namespace obscura {
namespace {

/// Embree's own rounding, of the scene's size: rays see faces displaced by so much (METHODS.md, "The spot").
constexpr double kFloatRounding = 3e-7;
constexpr int kMostMirrors = 4;
/// A search that has looked at more faces than this gives up: the spot is refined.
constexpr int kMostFaces = 4096;
constexpr std::size_t kMostReflections = 8;
/// Faces of a cover against which what lies in its own range of depths is judged one by one.
constexpr std::size_t kMostCover = 64;
constexpr int kMostPermeable = 16;

}  // namespace

void SpotQuery::Search::Visited::clear() noexcept { ++search_; }

bool SpotQuery::Search::Visited::insert(std::uint32_t face) noexcept {
  const std::uint64_t key = search_ << 32 | face;
  for (std::size_t i = slot(face);; i = (i + 1) % kSlots) {
    if (slots_[i] == key) return false;
    if (slots_[i] >> 32 == search_) continue;
    slots_[i] = key;
    return true;
  }
}

bool SpotQuery::Search::Visited::contains(std::uint32_t face) const noexcept {
  const std::uint64_t key = search_ << 32 | face;
  for (std::size_t i = slot(face);; i = (i + 1) % kSlots) {
    if (slots_[i] == key) return true;
    if (slots_[i] >> 32 != search_) return false;
  }
}

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

/// Through the edge and along the rays that meet it; zero where the edge is seen as a point.
HalfSpace SpotQuery::Search::through_edge(const Region& region, const Vec3d& a, const Vec3d& b) const noexcept {
  const Vec3d n = region.central() ? (a - region.eye()).cross(b - a) : region.axis().cross(b - a);
  const double length = n.length();
  const double size = region.central() ? (a - region.eye()).length() : 1.0;
  if (!(length > unsure_ * size)) return {};
  return {n / length, -(n / length).dot(a)};
}

bool SpotQuery::Search::continues(const HalfSpace& edge, double from_side, std::uint32_t object, std::uint32_t side,
                                  double noise) const noexcept {
  const std::array<Vec3d, 3> p = index_->corners(object, side / 3);
  if (!((p[1] - p[0]).cross(p[2] - p[0]).length2() > 0) || permeable(object, side / 3)) return false;
  const double height = edge.height(p[(side % 3 + 2) % 3]);
  return from_side > 0 ? height < -noise : height > noise;
}

Criterion SpotQuery::Search::flood(const Region& region, const Looking& looking, FaceId start, Level& level) {
  const MeshIndex& mesh = *index_->mesh(start.surface);
  visited_.clear();
  visited_surface_ = start.surface;
  visited_.insert(start.face);
  queue_.assign(1, start.face);
  covered_ = region.bounded();
  cover_known_ = true;
  cover_surface_ = start.surface;
  double deepest = 0;
  for (std::size_t next = 0; next < queue_.size(); ++next) {
    const std::uint32_t face = queue_[next];
    if (++faces_ > kMostFaces) return gave_up();
    const std::array<Vec3d, 3> p = index_->corners(start.surface, face);
    const Vec3d across = (p[1] - p[0]).cross(p[2] - p[0]);
    Fragment part(p);
    if (!part.cut(region.planes())) {
      // Only rounding can have led here.
      if (next == 0) covered_ = false;
      continue;
    }
    const Vec3d normal = across.normalized();
    const Criterion found = see(region, looking, {start.surface, face}, p, normal, part, level);
    if (found != Criterion::none) return found;
    for (std::size_t i = 0; i < part.size; ++i) {
      deepest = std::max(deepest, region.height(part.corners[i]));
      // What reaches back to where the rays begin may be behind some of them.
      if (region.height(part.corners[i]) <= 0 ||
          (region.mirrored() && region.start().height(part.corners[i]) <= unsure_))
        covered_ = false;
    }
    // Where an edge is in the spot, the surface must go on behind it, away from this face.
    for (std::size_t i = 0; i < part.size; ++i) {
      if (part.sides[i] == Fragment::kNoSide) continue;
      const auto corner = static_cast<std::size_t>(part.sides[i]);
      const HalfSpace edge = through_edge(region, p[corner], p[(corner + 1) % 3]);
      const double own = edge.height(p[(corner + 2) % 3]);
      bool goes_on = false;
      if (std::abs(own) > unsure_) {
        const auto first = static_cast<std::uint32_t>(3 * face + corner);
        for (std::uint32_t side = mesh.next_side[first]; side != first; side = mesh.next_side[side]) {
          if (!continues(edge, own, start.surface, side, unsure_)) continue;
          goes_on = true;
          if (visited_.insert(side / 3)) queue_.push_back(side / 3);
        }
      }
      if (!goes_on) covered_ = false;
    }
    if (!covered_) {
      // Those that wait have not been seen.
      visited_.clear();
      for (std::size_t i = 0; i <= next; ++i) visited_.insert(queue_[i]);
      return Criterion::none;
    }
    const double away = region.central() ? normal.dot(region.eye() - p[0]) : -normal.dot(region.axis());
    const Vec3d front = away < 0 ? -normal : normal;
    // Farther than all of the cover along this face's normal: hidden, as rays pass the cover before.
    if (next == 0) {
      front_ = HalfSpace{front, -kInfinity};
      if (!(std::abs(away) > unsure_)) front_.reset();
    }
    for (std::size_t i = 0; i < part.size && front_; ++i) {
      front_->offset = std::max(front_->offset, -front_->normal.dot(part.corners[i]) + unsure_);
    }
    if (cover_.size() == kMostCover) cover_known_ = false;
    if (!cover_known_) continue;
    double cosine = 1;
    for (const Ray& ray : looking.spot.corners) cosine = std::min(cosine, std::abs(front.dot(ray.direction)));
    cover_.push_back({face, {front, -front.dot(p[0])}, p, 1e-12 * index_->reach() * cosine});
  }
  limit_ = deepest + unsure_;
  return Criterion::none;
}

bool SpotQuery::Search::hidden(const Region& region, FaceId id, const Fragment& part) const noexcept {
  if (!covered_ || !cover_known_ || cover_.empty()) return false;
  for (const Cover& cover : cover_) {
    // Of two at the same distance the lower name is met.
    const double tie = id < FaceId{cover_surface_, cover.face} ? -cover.tie : cover.tie;
    const auto in_front = [&](const Fragment& fragment) {
      for (std::size_t i = 0; i < fragment.size; ++i) {
        if (cover.plane.height(fragment.corners[i]) > tie) return true;
      }
      return false;
    };
    if (!in_front(part)) continue;
    if (cover_.size() == 1) return false;
    // Only what rays meet before this very face.
    Fragment before = part;
    for (std::size_t side = 0; side < 3; ++side) {
      HalfSpace wedge = through_edge(region, cover.corners[side], cover.corners[(side + 1) % 3]);
      if (wedge.height(cover.corners[(side + 2) % 3]) < 0) wedge = {-wedge.normal, -wedge.offset};
      wedge.offset += unsure_;
      before.cut(wedge);
    }
    if (before.size > 0 && in_front(before)) return false;
  }
  return true;
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

Criterion SpotQuery::Search::see(const Region& region, const Looking& looking, FaceId id, const std::array<Vec3d, 3>& p,
                                 const Vec3d& normal, const Fragment& part, Level& level) {
  const Object& object = index_->objects()[id.surface];
  const std::size_t slot = slot_of(id.surface, id.face);
  Sight sight;
  sight.surface = id.surface;
  const double away = region.central() ? normal.dot(region.eye() - p[0]) : -normal.dot(region.axis());
  sight.normal = away < 0 ? -normal : normal;
  const bool back = away < 0 && !object.double_sided;
  sight.material = back ? Sight::kBack : object.materials[slot];

  double near = kInfinity;
  for (std::size_t i = 0; i < part.size; ++i) {
    near = std::min(near, region.height(part.corners[i]));
    sight.far = std::max(sight.far, region.distance(part.corners[i]));
  }
  const double above = region.central() ? std::abs(away) : 0.0;  // m over the face's plane
  sight.near = std::max({near, above, 0.0});
  if (by_angle_ && asked_.emissivity) {
    if (region.central()) {
      sight.angle_high = std::acos(std::clamp(above / sight.far, 0.0, 1.0));
      sight.angle_low = std::acos(std::clamp(sight.near > 0 ? above / sight.near : 1.0, 0.0, 1.0));
    } else {
      sight.angle_low = sight.angle_high = std::acos(std::min(1.0, std::abs(away)));
    }
  }

  sight.radiance_given = !back && std::any_of(object.radiance.begin(), object.radiance.end(),
                                              [](const auto& given) { return given.has_value(); });
  const Mesh& mesh = *object.mesh;
  sight.K_low = sight.K_high = back ? 0.0 : object.K[slot];
  if (!back && asked_.temperature_K && (!mesh.vertex_K.empty() || !mesh.face_K.empty())) {
    if (!mesh.vertex_K.empty()) {
      // Linear over the face, so that corners of the part are its extremes.
      const std::array<std::uint32_t, 3>& f = mesh.faces[id.face];
      const Vec3d e1 = p[1] - p[0], e2 = p[2] - p[0], n = e1.cross(e2);
      const double K0 = static_cast<double>(mesh.vertex_K[f[0]]), K1 = static_cast<double>(mesh.vertex_K[f[1]]),
                   K2 = static_cast<double>(mesh.vertex_K[f[2]]);
      if (K0 + K1 + K2 == K0 + K1 + K2) {
        sight.K_low = kInfinity;
        sight.K_high = -kInfinity;
        for (std::size_t i = 0; i < part.size; ++i) {
          const Vec3d q = part.corners[i] - p[0];
          const double u = std::clamp(q.cross(e2).dot(n) / n.length2(), 0.0, 1.0);
          const double v = std::clamp(e1.cross(q).dot(n) / n.length2(), 0.0, 1.0 - u);
          const double K = (1 - u - v) * K0 + u * K1 + v * K2;
          sight.K_low = std::min(sight.K_low, K);
          sight.K_high = std::max(sight.K_high, K);
        }
      }
    } else if (mesh.face_K[id.face] == mesh.face_K[id.face]) {
      sight.K_low = sight.K_high = static_cast<double>(mesh.face_K[id.face]);
    }
  }
  const Criterion found = level.seen.add(sight);
  if (found != Criterion::none || depth_ == 0 || !mirrors(sight.material)) return found;

  // What rays see in this face they would see from behind it.
  Looking reflected;
  const HalfSpace plane{sight.normal, -sight.normal.dot(p[0])};
  for (const Looking& known : level.mirrors) {
    if (known.flat && (known.mirror->normal - plane.normal).length() < 1e-12 &&
        std::abs(known.mirror->offset - plane.offset) < unsure_) {
      return found;
    }
  }
  const Vec3d shift = index_->origin();
  const auto behind = [&](const Ray& ray) {
    const double height = plane.height(ray.origin - shift);
    return Ray{ray.origin - 2 * height * plane.normal, detail::mirrored(ray.direction, plane.normal), 0, kInfinity};
  };
  for (std::size_t i = 0; i < 4; ++i) reflected.spot.corners[i] = behind(looking.spot.corners[i]);
  // One origin, to the bit.
  if (region.central()) {
    for (Ray& ray : reflected.spot.corners) ray.origin = reflected.spot.corners[0].origin;
  } else {
    for (Ray& ray : reflected.spot.corners) ray.direction = reflected.spot.corners[0].direction;
  }
  reflected.spot.bulge = looking.spot.bulge;
  reflected.middle = behind(looking.middle);
  const double toward = plane.normal.dot(reflected.middle.direction);
  const double below = plane.height(reflected.middle.origin - shift);
  reflected.has_middle = toward > 1e-9 && below < 0;
  if (reflected.has_middle) reflected.middle.t_min = -below / toward + world_.surfaces().clearance();
  reflected.from = id;
  reflected.mirror = plane;
  reflected.flat = true;
  return add_mirror(level, reflected);
}

Criterion SpotQuery::Search::add_mirror(Level& level, const Looking& reflected) {
  if (level.mirrors.size() == kMostReflections) return Criterion::reflection;
  level.mirrors.push_back(reflected);
  return Criterion::none;
}

}  // namespace obscura
