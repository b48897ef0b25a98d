// Photons that objects and hot spheres emit: from faces by power, and along lines through the clouds' surroundings.
#include <algorithm>
#include <cmath>

#include "photon/optics/sampling.h"
#include "photon/trace/emission.h"

namespace obscura {

EmittedPhoton PhotonEmitter::from_faces(double u, const std::array<double, 8>& v) const noexcept {
  const FaceLights& lights = world_.face_lights();
  const FaceLights::Place place = lights.sample(world_, u, v[1], v[2]);
  EmittedPhoton photon;
  photon.position = place.position;
  photon.direction = cosine_direction(place.normal, v[4], v[5]);
  photon.in_direct_set = true;
  photon.from = place.id;
  // The face was chosen by its mean radiance; that of this place and angle gives the power.
  const double radiance = lights.emission(world_, place, place.normal.dot(photon.direction));
  photon.power = kPi * radiance / lights.density(world_, place.id);
  if (is_on_a_line(photon.position, photon.direction, place.id)) photon.power = 0;
  return photon;
}

EmittedPhoton PhotonEmitter::from_lines(const std::array<double, 8>& u) const noexcept {
  // A line through the sphere about the clouds, isotropic and uniform; it starts where it enters.
  const Target& target = targets_[1];
  const Vec3d direction = uniform_direction(u[4], u[5]);
  const auto [x, y] = uniform_disc(u[1], u[2]);
  const auto [a, b] = orthonormal_basis(direction);
  const double half = target.radius * std::sqrt(std::max(0.0, 1 - x * x - y * y));
  const Vec3d entry = target.center + target.radius * (x * a + y * b) - half * direction;

  // Faces that send light along it: the first opaque one behind the entry and the nets before it, and
  // those inside the sphere.
  struct Candidate {
    Vec3d position;
    FaceId id;
    double radiance;
  };
  constexpr std::size_t kMost = 16;
  std::array<Candidate, kMost> candidates;
  std::size_t count = 0;
  const auto offer = [&](const Ray& ray, const SurfaceHit& hit) {
    if (hit.id.surface >= world_->objects().size()) return;
    const Vec3d position = ray.at(hit.t);
    const double cosine = world_->surfaces().normal(hit.id, position).dot(direction);
    if (cosine < 0 && !world_->objects()[hit.id.surface].double_sided) return;
    const MaterialOptics& material = world_.material(hit.id);
    const double radiance = world_.black_radiance(hit.id, hit.u, hit.v) * material.emissivity(std::abs(cosine)) *
                            (1 - material.permeable());
    if (radiance > 0 && count < kMost) candidates[count++] = {position, hit.id, radiance};
  };
  for (const bool behind : {true, false}) {
    Ray ray{entry, behind ? -direction : direction, 0, behind ? kInfinity : 2 * half};
    SurfaceHit hit = world_->surfaces().intersect(ray);
    for (std::size_t i = 0; hit.exists() && i < kMost; ++i) {
      offer(ray, hit);
      if (behind && !is_net(hit.id)) break;
      ray.t_min = hit.t;
      hit = world_->surfaces().intersect(ray, hit.id);
    }
  }
  EmittedPhoton photon;
  photon.direction = direction;
  photon.in_direct_set = true;
  if (count == 0) return photon;
  const Candidate& chosen =
      candidates[std::min(count - 1, static_cast<std::size_t>(u[3] * static_cast<double>(count)))];
  photon.position = chosen.position;
  photon.from = chosen.id;
  photon.power = 4 * kPi * kPi * target.radius * target.radius * static_cast<double>(count) * chosen.radiance;
  return photon;
}

bool PhotonEmitter::is_net(const FaceId& face) const noexcept {
  return face.surface < world_->objects().size() && world_.material(face).permeable() > 0;
}

bool PhotonEmitter::is_on_a_line(const Vec3d& position, const Vec3d& direction, FaceId from) const noexcept {
  if (targets_.size() < 2) return false;
  const Target& target = targets_[1];
  const Vec3d to_center = target.center - position;
  const double r2 = target.radius * target.radius;
  if (to_center.length2() < r2) return true;
  const double along = to_center.dot(direction);
  const double half2 = r2 - (to_center - along * direction).length2();
  if (along < 0 || half2 <= 0) return false;
  // Unless something opaque stands before the sphere.
  Ray ray{position, direction, world_->surfaces().clearance(), along - std::sqrt(half2)};
  SurfaceHit hit = world_->surfaces().intersect(ray, from);
  while (hit.exists() && is_net(hit.id)) {
    ray.t_min = hit.t;
    hit = world_->surfaces().intersect(ray, hit.id);
  }
  return !hit.exists();
}

EmittedPhoton PhotonEmitter::from_sphere(int index, const std::array<double, 8>& u) const noexcept {
  const HotSphere& sphere = world_->spheres()[static_cast<std::size_t>(index)];
  const Vec3d normal = uniform_direction(u[1], u[2]);
  EmittedPhoton photon;
  photon.position = sphere.center + sphere.radius * normal;
  photon.direction = cosine_direction(normal, u[4], u[5]);
  photon.power = world_.value_of(sphere.radiance) * 4 * kPi * kPi * sphere.radius * sphere.radius;
  photon.in_direct_set = static_cast<std::size_t>(index) < world_->source_count();
  photon.from = {static_cast<std::uint32_t>(world_->objects().size()) + static_cast<std::uint32_t>(index), 0};
  return photon;
}

}  // namespace obscura
