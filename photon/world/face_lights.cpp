#include "photon/world/face_lights.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <set>

#include "photon/optics/sampling.h"
#include "photon/world/spectral_world.h"

namespace obscura {
namespace {

/// A face's black radiance: the mean of its corners' where temperature varies over it.
double mean_black(SpectralWorld world, const FaceId& face) noexcept {
  const Object& object = world->objects()[face.surface];
  if (!object.mesh || object.mesh->vertex_K.empty()) return world.black_radiance(face, 0, 0);
  return (world.black_radiance(face, 0, 0) + world.black_radiance(face, 1, 0) + world.black_radiance(face, 0, 1)) / 3;
}

/// Flux that leaves one side of a face, W/m2.
double exitance(SpectralWorld world, const FaceId& face) noexcept {
  const MaterialOptics& material = world.material(face);
  return kPi * material.hemispherical_emissivity() * (1 - material.permeable()) * mean_black(world, face);
}

using Corners = std::array<std::array<double, 3>, 3>;

/// In an order that does not depend on how the face names them.
Corners sorted_corners(const Mesh& mesh, std::size_t face) noexcept {
  Corners corners;
  for (std::size_t c = 0; c < 3; ++c) {
    const Vec3d& v = mesh.vertices[mesh.faces[face][c]];
    corners[c] = {v.x + 0.0, v.y + 0.0, v.z + 0.0};  // no -0
  }
  std::sort(corners.begin(), corners.end());
  return corners;
}

std::uint64_t hash_of(const Corners& corners) noexcept {
  std::uint64_t hash = 0;
  for (const auto& corner : corners) {
    for (const double x : corner) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 0x9E3779B97F4A7C15u;
      hash ^= hash >> 29;
    }
  }
  return hash;
}

/// What makes two objects the same body in the same place.
auto body_of(const Object& object) {
  std::array<double, 12> map;
  for (int row = 0; row < 4; ++row) {
    for (int axis = 0; axis < 3; ++axis)
      map[static_cast<std::size_t>(3 * row + axis)] = object.local_to_world[row][axis];
  }
  return std::tuple(object.mesh.get(), object.mesh ? 0.0 : object.radius, map);
}

}  // namespace

const std::vector<bool>& TwinFaces::of(const Mesh& mesh) {
  const auto [place, added] = found_.try_emplace(&mesh);
  std::vector<bool>& twins = place->second;
  if (!added) return twins;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> faces(mesh.faces.size());
  for (std::uint32_t f = 0; f < faces.size(); ++f) faces[f] = {hash_of(sorted_corners(mesh, f)), f};
  tbb::parallel_sort(faces.begin(), faces.end());
  for (std::size_t first = 0, i = 1; i < faces.size(); ++i) {
    // Faces of equal hash are compared with the first of them, the lowest; two different faces of one hash are next to
    // impossible.
    if (faces[i].first != faces[first].first) {
      first = i;
    } else if (sorted_corners(mesh, faces[i].second) == sorted_corners(mesh, faces[first].second)) {
      twins.resize(faces.size());
      twins[faces[i].second] = true;
    }
  }
  return twins;
}

FaceLights::FaceLights(SpectralWorld world, TwinFaces& twin_faces) : emitter_of_(world->objects().size(), -1) {
  std::set<decltype(body_of(world->objects().front()))> bodies;
  std::map<const Mesh*, std::shared_ptr<const std::vector<double>>> areas;
  for (std::uint32_t o = 0; o < world->objects().size(); ++o) {
    const Object& object = world->objects()[o];
    if (!bodies.insert(body_of(object)).second) continue;
    const double sides = object.double_sided ? 2 : 1;
    double power = 0;
    Emitter emitter{o, nullptr};
    if (!object.mesh) {
      power = exitance(world, {o, 0}) * world->surfaces().area({o, 0});
    } else if (!object.mesh->faces.empty()) {
      const Mesh& mesh = *object.mesh;
      const bool alike = mesh.slots.empty() && mesh.vertex_K.empty() && mesh.face_K.empty();
      std::shared_ptr<const std::vector<double>>* shared = alike ? &areas[&mesh] : nullptr;
      if (alike && !(exitance(world, {o, 0}) > 0)) continue;
      if (shared && *shared) {
        emitter.sums = *shared;
      } else {
        const std::vector<bool>& twins = twin_faces.of(mesh);
        std::vector<double> sums;
        sums.reserve(mesh.faces.size());
        double sum = 0;
        for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
          const FaceId face{o, f};
          const bool hidden = !twins.empty() && twins[f];
          if (!hidden) sum += world->surfaces().area(face) * (alike ? 1.0 : exitance(world, face));
          sums.push_back(sum);
        }
        emitter.sums = std::make_shared<const std::vector<double>>(std::move(sums));
        if (shared) *shared = emitter.sums;
      }
      if (alike) {
        // Sums that another copy has made are in its scale.
        double first = 0;
        for (std::uint32_t f = 0; f < mesh.faces.size() && !(first > 0); ++f) {
          const double step = (*emitter.sums)[f] - (f ? (*emitter.sums)[f - 1] : 0.0);
          if (step > 0) first = world->surfaces().area({o, f}) / step;
        }
        power = emitter.sums->back() * first * exitance(world, {o, 0});
      } else {
        power = emitter.sums->back();
      }
    }
    if (!(power > 0)) continue;
    power_ += power * sides;
    emitter_of_[o] = static_cast<int>(objects_.size());
    objects_.push_back(std::move(emitter));
    cumulative_.push_back(power_);
  }
}

double FaceLights::emission(SpectralWorld world, const Place& place, double cosine) const noexcept {
  const MaterialOptics& material = world.material(place.id);
  return world.black_radiance(place.id, place.u, place.v) * material.emissivity(cosine) * (1 - material.permeable());
}

FaceLights::Place FaceLights::sample(SpectralWorld world, double u, double v, double w) const noexcept {
  const Emitter& emitter = objects_[choose(cumulative_, cumulative_.size(), u)];
  const Object& object = world->objects()[emitter.object];
  Place place;
  place.id.surface = emitter.object;
  const auto pick_side = [&] {
    if (!object.double_sided) return;
    u *= 2;
    if (u >= 1) {
      u -= 1;
      place.normal = -place.normal;
    }
  };
  if (!emitter.sums) {
    place.normal = uniform_direction(v, w);
    const double radius = std::sqrt(world->surfaces().area(place.id) / (4 * kPi));
    place.position = transform_point(object.local_to_world, Vec3d(0)) + radius * place.normal;
    place.u = place.v = 0;
    pick_side();
    return place;
  }
  place.id.face = static_cast<std::uint32_t>(choose(*emitter.sums, emitter.sums->size(), u));
  // Uniform over the triangle (Turk, Graphics Gems, 1990).
  const double root = std::sqrt(v);
  place.u = root * (1 - w);
  place.v = root * w;
  const std::array<Vec3d, 3> p = world->surfaces().corners(place.id);
  place.position = p[0] + place.u * (p[1] - p[0]) + place.v * (p[2] - p[0]);
  place.normal = world->surfaces().normal(place.id, place.position);
  pick_side();
  return place;
}

double FaceLights::density(SpectralWorld world, const FaceId& face) const noexcept {
  const int emitter = emitter_of_[face.surface];
  if (emitter < 0) return 0;
  const auto& sums = objects_[static_cast<std::size_t>(emitter)].sums;
  if (sums && !((*sums)[face.face] > (face.face ? (*sums)[face.face - 1] : 0.0))) return 0;  // no area, or a twin
  return exitance(world, face) / power_;
}

}  // namespace obscura
