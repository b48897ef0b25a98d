// What covers a spot: the faces that hang together with the one that its middle ray meets, and what they hide.
#include <algorithm>

#include "photon/spot/spot_search.h"

namespace obscura {
namespace {

/// Most faces of a cover for which a face in the same range of depths is compared with each.
constexpr std::size_t kMostCover = 64;

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

}  // namespace obscura
