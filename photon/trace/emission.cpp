// The sources of an interval, how often each is chosen, and which one a photon comes from. What each sends is in
// emission_clouds.cpp, emission_beyond.cpp and emission_surfaces.cpp.
#include "photon/trace/emission.h"

#include <algorithm>
#include <cassert>

#include "photon/optics/sampling.h"

namespace obscura {
PhotonEmitter::PhotonEmitter(SpectralWorld world, const SourceSelection& selection, const Box3d& around)
    : world_(world) {
  const auto add = [this](Kind kind, int index, double power, double chance) {
    if (!(power > 0)) return;
    power_ += power;
    sources_.push_back({kind, index, power, chance});
  };
  Box3d bounds = world->bounds();
  if (!around.isEmpty()) bounds.extendBy(around);
  if (!bounds.isEmpty()) {
    middle_ = bounds.center();
    radius_ = 0.5 * bounds.size().length();
  }
  if (world->periodic()) {
    make_faces(around);
  } else {
    make_targets();
  }

  blocks_.resize(static_cast<std::size_t>(world->cloud_count()));
  for (int c = 0; selection.emission && c < world->cloud_count(); ++c) {
    if (!world.optics(c).emits()) continue;
    Blocks& blocks = blocks_[static_cast<std::size_t>(c)];
    blocks = sum_blocks(c);
    if (!blocks.cumulative.empty()) add(Kind::cloud, c, blocks.emitted, blocks.cumulative.back());
  }
  for (std::size_t i = 0; selection.sun && i < world->suns().size(); ++i) {
    const Sun& sun = world->suns()[i];
    const double area = world->periodic() ? area_towards(sun) : kPi * radius_ * radius_;
    const double power = world.value_of(sun.irradiance) * area;
    add(Kind::sun, static_cast<int>(i), power, power);
  }
  if (selection.sky && world.sky() > 0) {
    double area = 4 * kPi * radius_ * radius_;
    if (world->periodic()) {
      area = 0;
      for (const Face& face : faces_) area += face.area;
    }
    const double power = kPi * world.sky() * area;
    add(Kind::sky, 0, power, power);
  }
  const FaceLights& lights = world.face_lights();
  if (selection.surfaces && !lights.empty()) {
    add(Kind::faces, 0, lights.power(), lights.power());
    // Light of the faces that goes through the surroundings of the clouds is emitted by a source of its own (lines).
    // Its power is not known beforehand: it is counted with the faces'.
    if (targets_.size() > 1) sources_.push_back({Kind::lines, 0, 0.0, lights.power()});
  }
  const std::vector<HotSphere>& spheres = world->spheres();
  for (std::size_t s = 0; s < spheres.size(); ++s) {
    if (!(s < world->source_count() ? selection.spheres : selection.particles)) continue;
    const double power = world.value_of(spheres[s].radiance) * 4 * kPi * kPi * spheres[s].radius * spheres[s].radius;
    add(Kind::sphere, static_cast<int>(s), power, power);
  }
  for (std::size_t b = 0; selection.beams && b < world->beams().size(); ++b) {
    const double power = world.value_of(world->beams()[b].power);
    add(Kind::beam, static_cast<int>(b), power, power);
  }
  make_groups();
  sum_chances();
}

void PhotonEmitter::make_groups() {
  const auto same_group = [](const Source& a, const Source& b) { return a.kind == b.kind && a.kind != Kind::cloud; };
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (s == 0 || !same_group(sources_[s - 1], sources_[s])) groups_.emplace_back();
    groups_.back().push_back(s);
  }
}

void PhotonEmitter::sum_chances() {
  cumulative_.clear();
  for (const Source& source : sources_) {
    cumulative_.push_back((cumulative_.empty() ? 0.0 : cumulative_.back()) + source.chance);
  }
}

PhotonEmitter PhotonEmitter::only(std::size_t group) const {
  PhotonEmitter result = *this;
  result.sources_.clear();
  result.power_ = 0;
  for (const std::size_t s : groups_[group]) {
    result.sources_.push_back(sources_[s]);
    result.power_ += sources_[s].power;
  }
  result.groups_.clear();
  result.make_groups();
  result.sum_chances();
  return result;
}

void PhotonEmitter::set_shares(std::span<const double> shares) {
  assert(shares.size() == groups_.size());
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    double sum = 0;
    for (const std::size_t s : groups_[g]) sum += sources_[s].chance;
    for (const std::size_t s : groups_[g]) sources_[s].chance *= shares[g] / sum;
  }
  sum_chances();
}

Work PhotonEmitter::work_of(Kind kind) noexcept {
  switch (kind) {
    case Kind::cloud:
      break;
    case Kind::sun:
      return Work::photons_sun;
    case Kind::sky:
      return Work::photons_sky;
    case Kind::faces:
    case Kind::lines:
      return Work::photons_faces;
    case Kind::sphere:
      return Work::photons_spheres;
    case Kind::beam:
      return Work::photons_beams;
  }
  return Work::photons_emission;
}

EmittedPhoton PhotonEmitter::emit(const std::array<double, 8>& u, Cache& cache) const noexcept {
  assert(!sources_.empty());
  double rest = u[0];
  const Source& source = sources_[choose(cumulative_, cumulative_.size(), rest)];
  EmittedPhoton photon;
  switch (source.kind) {
    case Kind::cloud:
      photon = from_cloud(source.index, rest, u, cache);
      break;
    case Kind::sun:
      photon = from_sun(source.index, u);
      break;
    case Kind::sky:
      photon = from_sky(u);
      break;
    case Kind::faces:
      photon = from_faces(rest, u);
      break;
    case Kind::lines:
      photon = from_lines(u);
      break;
    case Kind::sphere:
      photon = from_sphere(source.index, u);
      break;
    case Kind::beam:
      photon = from_beam(source.index, u);
      break;
  }
  photon.work = work_of(source.kind);
  // Chosen with probability chance / sum of chances; the source's own photon carries all its power.
  photon.power *= cumulative_.back() / source.chance;
  return photon;
}

EmittedPhoton PhotonEmitter::from_beam(int index, const std::array<double, 8>& u) const noexcept {
  const Beam& beam = world_->beams()[static_cast<std::size_t>(index)];
  const auto [x, y] = uniform_disc(u[1], u[2]);
  const auto [a, b] = orthonormal_basis(beam.direction);
  EmittedPhoton photon;
  photon.position = beam.position + beam.radius * (x * a + y * b);
  photon.direction = beam.direction;
  photon.power = world_.value_of(beam.power);
  return photon;
}

}  // namespace obscura
