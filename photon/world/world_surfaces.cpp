// The World's surfaces: where they are, what they emit and reflect, what a ray meets.
#include <algorithm>
#include <limits>

#include "photon/world/spectral_world.h"

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
  for (int i = 0; i < interval_count(); ++i) face_lights_.emplace_back(SpectralWorld(*this, i), twins);
}

SurfaceHit World::meet(const Ray& ray, FaceId from, Stream& stream) const noexcept {
  SurfaceHit hit = surfaces_.intersect(ray, from);
  if (!permeable_) return hit;
  Ray rest = ray;
  while (hit.exists() && hit.id.surface < objects().size() &&
         stream.uniform() < SpectralWorld(*this, 0).material(hit.id).permeable()) {
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

}  // namespace obscura
