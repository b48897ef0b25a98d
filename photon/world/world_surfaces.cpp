// The World's surfaces: where they are, what they emit and reflect, what a ray meets.
#include <algorithm>
#include <limits>

#include "photon/world/world.h"

namespace obscura {

void World::place_surfaces() {
  spheres_ = contents_.sources;
  spheres_.insert(spheres_.end(), contents_.particles.begin(), contents_.particles.end());
  for (const HotSphere& sphere : spheres_) {
    bounds_.extendBy(sphere.center - Vec3d(sphere.radius));
    bounds_.extendBy(sphere.center + Vec3d(sphere.radius));
  }
  for (const Object& object : contents_.objects) {
    const Box3d box = bounds_of(object);
    if (!box.isEmpty()) bounds_.extendBy(box);
  }
  if (!bounds_.isEmpty()) origin_ = bounds_.center();
  surfaces_ = Surfaces(contents_.objects, spheres_, origin_);
}

void World::light_surfaces() {
  for (const Object& object : contents_.objects) {
    first_slots_.push_back(slot_count_);
    slot_count_ += object.materials.size();
  }
  for (const Material& material : contents_.materials) permeable_ = permeable_ || material.permeable > 0;
  // Temperatures of meshes: their range, for a table.
  float coldest = std::numeric_limits<float>::infinity(), warmest = 0;
  for (const Object& object : contents_.objects) {
    if (!object.mesh) continue;
    for (const std::vector<float>* list : {&object.mesh->vertex_K, &object.mesh->face_K}) {
      for (const float K : *list) {
        if (!(K > 0)) continue;
        coldest = std::min(coldest, K);
        warmest = std::max(warmest, K);
      }
    }
  }
  for (int i = 0; i < interval_count(); ++i) {
    const Band& band = contents_.bands[static_cast<std::size_t>(interval(i).band)];
    for (const Material& material : contents_.materials) materials_.emplace_back(material, i);
    mesh_planck_.emplace_back();
    if (warmest > 0 && !band.grey()) {
      mesh_planck_.back().emplace(band, interval(i).interval, static_cast<double>(coldest),
                                  static_cast<double>(warmest));
    }
    bool reflect = false;
    for (const Object& object : contents_.objects) {
      const bool given = !object.radiance.empty() && object.radiance[static_cast<std::size_t>(i)];
      for (std::size_t slot = 0; slot < object.materials.size(); ++slot) {
        const double K = object.K[slot];
        black_.push_back(given                   ? *object.radiance[static_cast<std::size_t>(i)]
                         : K > 0 && !band.grey() ? band.planck(interval(i).interval, K)
                                                 : 0.0);
        reflect = reflect || materials_[static_cast<std::size_t>(i) * contents_.materials.size() +
                                        static_cast<std::size_t>(object.materials[slot])]
                                 .reflects();
      }
    }
    surfaces_reflect_.push_back(reflect);
  }
  TwinFaces twins;
  for (int i = 0; i < interval_count(); ++i) face_lights_.emplace_back(*this, i, twins);
}

SurfaceHit World::meet(const Ray& ray, FaceId from, Stream& stream) const noexcept {
  SurfaceHit hit = surfaces_.intersect(ray, from);
  if (!permeable_) return hit;
  Ray rest = ray;
  while (hit.exists() && hit.id.surface < objects().size() && stream.uniform() < material(0, hit.id).permeable()) {
    rest.t_min = hit.t;
    hit = surfaces_.intersect(rest, hit.id);
  }
  return hit;
}

bool World::blocked(const Ray& ray, FaceId from, Stream& stream) const noexcept {
  return permeable_ ? meet(ray, from, stream).exists() : surfaces_.occluded(ray, from);
}

std::size_t World::slot_of(const FaceId& face) const noexcept {
  const Object& object = contents_.objects[face.surface];
  return object.mesh && !object.mesh->slots.empty() ? object.mesh->slots[face.face] : 0;
}

const MaterialOptics& World::material(int interval, const FaceId& face) const noexcept {
  const Object& object = contents_.objects[face.surface];
  return materials_[static_cast<std::size_t>(interval) * contents_.materials.size() +
                    static_cast<std::size_t>(object.materials[slot_of(face)])];
}

double World::black_radiance(int interval, const FaceId& face, double u, double v) const noexcept {
  const Object& object = contents_.objects[face.surface];
  const bool given = !object.radiance.empty() && object.radiance[static_cast<std::size_t>(interval)];
  const std::optional<PlanckTable>& planck = mesh_planck_[static_cast<std::size_t>(interval)];
  if (object.mesh && planck && !given) {
    const Mesh& mesh = *object.mesh;
    double K = std::numeric_limits<double>::quiet_NaN();
    if (!mesh.vertex_K.empty()) {
      const auto& f = mesh.faces[face.face];
      K = (1 - u - v) * static_cast<double>(mesh.vertex_K[f[0]]) + u * static_cast<double>(mesh.vertex_K[f[1]]) +
          v * static_cast<double>(mesh.vertex_K[f[2]]);
    } else if (!mesh.face_K.empty()) {
      K = static_cast<double>(mesh.face_K[face.face]);
    }
    if (K == K) return (*planck)(K);
  }
  return black_[static_cast<std::size_t>(interval) * slot_count_ + first_slots_[face.surface] + slot_of(face)];
}

SurfacePoint World::surface_at(int interval, const Ray& ray, const SurfaceHit& hit) const noexcept {
  SurfacePoint point;
  point.id = hit.id;
  point.position = ray.at(hit.t);
  point.normal = surfaces_.normal(hit.id, point.position);
  const double along = -point.normal.dot(ray.direction);
  point.cosine = std::min(std::abs(along), 1.0);
  if (along < 0) point.normal = -point.normal;
  if (hit.id.surface >= objects().size()) {
    point.black = spheres_[hit.id.surface - objects().size()].radiance[static_cast<std::size_t>(interval)];
  } else if (along > 0 || objects()[hit.id.surface].double_sided) {
    point.material = &material(interval, hit.id);
    point.black = black_radiance(interval, hit.id, hit.u, hit.v);
  }
  return point;
}

}  // namespace obscura
