// Spheres in a spot, what is seen in them, and the discs of sun and moon.
#include <algorithm>

#include "photon/spot/spot_search.h"

namespace obscura {

Criterion SpotQuery::Search::see(const Region& region, const Ball& ball, Level& level) {
  if (!(ball.radius > 0)) return Criterion::none;
  const double r = ball.radius, slack = slack_ + unsure_;
  const Vec3d to_center = ball.center - region.eye();
  const double d = to_center.length();
  const bool object = ball.surface < index_->objects().size();
  // The eye is in it.
  const bool inside = region.central() && !region.mirrored() && d < r;
  if (inside && !ball.seen_from_inside) return Criterion::none;
  const double beside = region.distance_to(ball.center);
  if (beside > r + slack) return Criterion::none;
  if (region.mirrored() && region.start().height(ball.center) < -r - slack) return Criterion::none;
  if (region.height(ball.center) + r < -slack || region.height(ball.center) - r > limit_ + slack)
    return Criterion::none;

  SeenFace sight;
  sight.surface = ball.surface;
  sight.material = object ? index_->objects()[ball.surface].materials[0] : SeenFace::kHot;
  sight.normal = -region.axis();
  sight.curl = kPi;
  sight.near = std::max(0.0, inside ? r - d : region.central() ? d - r : region.height(ball.center) - r);
  sight.far = inside ? d + r : region.central() ? d : region.height(ball.center);
  sight.angle_high = 0.5 * kPi;
  sight.radiance_given = !object;
  if (object) {
    const Object& o = index_->objects()[ball.surface];
    if (inside && !o.double_sided) sight.material = SeenFace::kBack;
    sight.K_low = sight.K_high = sight.material == SeenFace::kBack ? 0.0 : o.K[0];
    sight.radiance_given =
        sight.material != SeenFace::kBack &&
        std::any_of(o.radiance.begin(), o.radiance.end(), [](const auto& given) { return given.has_value(); });
  }

  // A convex body that the edges of the spot meet is met by all of its rays.
  bool covers = region.bounded();
  double farthest_off = 0;  // of the rays from the centre: sine, or m
  for (std::size_t i = 0; i < 4 && covers && !inside; ++i) {
    const Vec3d to = ball.center - region.edge_start(i);
    const double along = to.dot(region.edge(i));
    const double off = (to - along * region.edge(i)).length();
    farthest_off = std::max(farthest_off, off);
    covers = along > 0 && off < r - slack && to.length() > r;
    if (covers && region.mirrored()) {
      const double t = along - std::sqrt(r * r - off * off);
      covers = region.start().height(region.edge_start(i) + t * region.edge(i)) > slack;
    }
  }
  double stretch = kInfinity;  // normals turn by so much per radian, or m, between rays
  if (covers) {
    const double cosine = std::sqrt(std::max(0.0, 1 - (inside ? d * d : farthest_off * farthest_off) / (r * r)));
    const auto entry = [&](double off) {
      const double height2 = std::max(0.0, r * r - off * off);
      return region.central() ? std::sqrt(std::max(0.0, d * d - off * off)) - std::sqrt(height2)
                              : region.height(ball.center) - std::sqrt(height2);
    };
    if (!inside) {
      sight.near = std::max(0.0, entry(beside));
      sight.far = entry(farthest_off);
      sight.angle_low = std::asin(std::min(1.0, beside / r));
      sight.angle_high = std::acos(cosine);
    }
    stretch = cosine > 0 ? (region.central() ? sight.far : 1.0) / (r * cosine) : kInfinity;
    sight.curl = std::min(kPi, stretch * region.spread());
    // Of the middle ray.
    const double along = to_center.dot(region.axis());
    const double off = (to_center - along * region.axis()).length();
    const double t =
        inside ? along + std::sqrt(r * r - off * off) : along - std::sqrt(std::max(0.0, r * r - off * off));
    sight.normal = (region.eye() + t * region.axis() - ball.center).normalized();
    if (inside) sight.normal = -sight.normal;
    if (!(object && permeable(ball.surface, 0)) && sight.far < limit_) {
      covered_ = true;
      cover_known_ = false;
      cover_.clear();
      limit_ = sight.far + slack;
    }
  }
  const Criterion found = level.seen.add(sight);
  if (found != Criterion::none || depth_ == 0 || !mirrors(sight.material)) return found;

  // All that is seen in it is in a cone: rays of the spot start within `patch` of the middle's point and
  // turn by at most `turn` from the middle's.
  double half = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    half =
        std::max(half, region.central() ? 2 * std::asin(std::min(1.0, 0.5 * (region.edge(i) - region.axis()).length()))
                                        : (region.edge_start(i) - region.eye()).length());
  }
  const double patch = r * stretch * half;
  const double turn = 1.01 * (2 * stretch * half + (region.central() ? half : 0.0)) + 1e-9;
  if (inside || !covers || !(turn < 0.5)) return Criterion::reflection;
  const Vec3d point = ball.center + r * sight.normal;
  const Vec3d way = detail::mirrored(region.axis(), sight.normal).normalized();
  const auto [a, b] = orthonormal_basis(way);
  const Vec3d apex = point - (1.01 * patch / std::sin(turn)) * way + index_->origin();
  Looking reflected;
  constexpr std::array<std::array<double, 2>, 4> kAround{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  for (std::size_t i = 0; i < 4; ++i) {
    const double wide = std::tan(turn);
    reflected.spot.corners[i] = {apex, (way + wide * (kAround[i][0] * a + kAround[i][1] * b)).normalized(), 0,
                                 kInfinity};
  }
  reflected.middle = {point + index_->origin(), way, world_.surfaces().clearance(), kInfinity};
  reflected.from = {ball.surface, 0};
  reflected.mirror = HalfSpace{way, -way.dot(point) + patch};
  return add_mirror(level, reflected);
}

Criterion SpotQuery::Search::add_discs(const Region& region, Level& level) {
  if (!region.central()) return Criterion::none;  // parallel rays see it all alike
  for (const Sun& sun : world_.suns()) {
    if (!(sun.diameter > 0)) continue;
    const double radius = std::sin(std::min(0.5 * kPi, 0.5 * sun.diameter));
    if (region.bounded() &&
        (sun.toward.dot(region.axis()) < 0 || region.distance_to(region.eye() + sun.toward) > radius))
      continue;
    bool whole = region.bounded();
    for (std::size_t i = 0; i < 4 && whole; ++i) whole = sun.covers(region.edge(i));
    if (whole) continue;
    const Criterion found = level.seen.add_disc();
    if (found != Criterion::none) return found;
  }
  return Criterion::none;
}

}  // namespace obscura
