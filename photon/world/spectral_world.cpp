#include "photon/world/spectral_world.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace obscura {

double SpectralWorld::extinction_in_map(const Vec3d& point) const noexcept {
  double extinction = 0;
  for (int c = 0; c < world_->cloud_count(); ++c) {
    const CloudFrame& f = world_->frame(c);
    const Octree& octree = *world_->clouds()[static_cast<std::size_t>(c)].octree;
    const Vec3d index = f.periodic() ? transform_point(f.local_to_index, f.wrap(transform_point(f.map_to_local, point)))
                                     : transform_point(f.map_to_index, point);
    for (const CloudOptics::Part& part : optics(c).parts()) {
      extinction += part.extinction * static_cast<double>(octree.value(part.channel, index));
    }
  }
  return extinction;
}

bool SpectralWorld::attenuates() const noexcept {
  for (int c = 0; c < world_->cloud_count(); ++c) {
    for (const CloudOptics::Part& part : optics(c).parts()) {
      if (part.extinction > 0) return true;
    }
  }
  return false;
}

bool SpectralWorld::scatters() const noexcept {
  for (int c = 0; c < world_->cloud_count(); ++c) {
    if (optics(c).scatters()) return true;
  }
  return false;
}

bool SpectralWorld::emits() const noexcept {
  for (int c = 0; c < world_->cloud_count(); ++c) {
    if (optics(c).emits()) return true;
  }
  return false;
}

double SpectralWorld::largest_source() const noexcept {
  double largest = 0;
  for (int c = 0; c < world_->cloud_count(); ++c) largest = std::max(largest, optics(c).largest_source());
  return largest;
}

bool SpectralWorld::glows() const noexcept {
  return std::any_of(world_->contents_.clouds.begin(), world_->contents_.clouds.end(),
                     [this](const Cloud& cloud) { return !cloud.emission.empty() && cloud.emission[index()] > 0; });
}

std::optional<double> SpectralWorld::uniform_source() const noexcept {
  std::optional<double> result;
  for (int c = 0; c < world_->cloud_count(); ++c) {
    const std::optional<double> one = optics(c).uniform_source();
    if (!one || (result && *result != *one)) return std::nullopt;
    result = one;
  }
  return result;
}

LocalOptics SpectralWorld::at(const Vec3d& point) const noexcept {
  LocalOptics result;
  for (int c = 0; c < world_->cloud_count(); ++c) {
    const Octree& octree = *world_->clouds()[static_cast<std::size_t>(c)].octree;
    const Vec3d index = world_->index_point(c, point);
    result += optics(c).at([&](int channel) noexcept { return octree.value(channel, index); });
  }
  return result;
}

double SpectralWorld::background(const Vec3d& direction, bool discs) const noexcept {
  double radiance = sky();
  for (const Sun& sun : world_->suns()) {
    if (discs && sun.covers(direction)) radiance += sun.radiance(interval_);
  }
  return radiance;
}

const MaterialOptics& SpectralWorld::material(const FaceId& face) const noexcept {
  const Object& object = world_->contents_.objects[face.surface];
  return world_->materials_[index() * world_->contents_.materials.size() +
                            static_cast<std::size_t>(object.materials[world_->slot_of(face)])];
}

double SpectralWorld::black_radiance(const FaceId& face, double u, double v) const noexcept {
  const Object& object = world_->contents_.objects[face.surface];
  const bool given = !object.radiance.empty() && object.radiance[index()];
  const std::optional<PlanckTable>& planck = world_->mesh_planck_[index()];
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
  return world_->black_[index() * world_->slot_count_ + world_->first_slots_[face.surface] + world_->slot_of(face)];
}

SurfacePoint SpectralWorld::surface_at(const Ray& ray, const SurfaceHit& hit) const noexcept {
  SurfacePoint point;
  point.id = hit.id;
  point.position = ray.at(hit.t);
  point.normal = world_->surfaces_.normal(hit.id, point.position);
  const double along = -point.normal.dot(ray.direction);
  point.cosine = std::min(std::abs(along), 1.0);
  if (along < 0) point.normal = -point.normal;
  if (hit.id.surface >= world_->objects().size()) {
    point.black = world_->spheres_[hit.id.surface - world_->objects().size()].radiance[index()];
  } else if (along > 0 || world_->objects()[hit.id.surface].double_sided) {
    point.material = &material(hit.id);
    point.black = black_radiance(hit.id, hit.u, hit.v);
  }
  return point;
}

bool redirects_light(const World& world) noexcept {
  for (int i = 0; i < world.interval_count(); ++i) {
    const SpectralWorld here(world, i);
    if (here.scatters() || here.surfaces_reflect()) return true;
  }
  return false;
}

}  // namespace obscura
