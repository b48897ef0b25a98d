// What the part of a mesh's face in a spot adds to what is seen, and what the spot sees in it where it is a mirror.
#include <algorithm>

#include "photon/spot/spot_search.h"

namespace obscura {
namespace {

constexpr std::size_t kMostReflections = 8;

}  // namespace

Criterion SpotQuery::Search::see(const Region& region, const Looking& looking, FaceId id, const std::array<Vec3d, 3>& p,
                                 const Vec3d& normal, const Fragment& part, Level& level) {
  const Object& object = index_->objects()[id.surface];
  const std::size_t slot = slot_of(id.surface, id.face);
  SeenFace sight;
  sight.surface = id.surface;
  const double away = region.central() ? normal.dot(region.eye() - p[0]) : -normal.dot(region.axis());
  sight.normal = away < 0 ? -normal : normal;
  const bool back = away < 0 && !object.double_sided;
  sight.material = back ? SeenFace::kBack : object.materials[slot];

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
