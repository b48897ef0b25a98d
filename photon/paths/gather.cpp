#include "photon/paths/gather.h"

#include "photon/optics/transfer.h"
#include "photon/paths/map_light.h"
#include "photon/world/world_walk.h"

namespace obscura::detail {
namespace {

/// Share of a path's first weight below which roulette decides whether it goes on.
constexpr double kFaint = 0.1;

}  // namespace

Gather::Gather(SpectralWorld world, const PhotonMaps* maps, const RadianceSettings& settings, DirectLight& direct,
               RadianceCounts& counts)
    : world_(world),
      maps_(maps),
      settings_(settings),
      direct_(direct),
      counts_(counts),
      air_(world.air_extinction()),
      attenuates_(world.attenuates()),
      sky_(settings.parts.sky ? world.sky() : 0.0),
      emits_(settings.parts.emission && (world.emits() || air_ > 0)),
      only_(world.only_medium()),
      source_(air_ > 0 ? std::nullopt : world.uniform_source()) {}

void Gather::finish(std::span<Incoming> incoming) {
  incoming_ = incoming;
  while (!legs_.empty()) fly();
  direct_.arrive([this](std::uint32_t path, double radiance) { paths_[path].direct += radiance; });

  // The sum of a ray's paths, and its variance from their scatter.
  for (std::size_t first = 0, end; first < paths_.size(); first = end) {
    const std::uint32_t owner = paths_[first].owner;
    double sum = 0, squares = 0;
    for (end = first; end < paths_.size() && paths_[end].owner == owner; ++end) {
      const double brought = paths_[end].direct + paths_[end].map;
      if (!std::isfinite(brought)) {
        ++counts_.anomalies;
        continue;
      }
      incoming[owner].direct += paths_[end].direct;
      sum += brought;
      squares += brought * brought;
    }
    const auto n = static_cast<double>(end - first);
    if (n > 1) incoming[owner].variance += std::max(0.0, n * squares - sum * sum) / (n - 1);
  }
  paths_.clear();
}

bool Gather::survives(PathLeg& leg) const noexcept {
  const double faint = kFaint * leg.first;
  if (leg.weight >= faint) return true;
  if (leg.stream.uniform() * faint >= leg.weight) return false;
  leg.weight = faint;
  return true;
}

void Gather::fly() {
  const bool masked = !world_->surfaces().empty();
  std::vector<Flight> flights;
  std::vector<SurfaceHit> hits;
  flights.reserve(legs_.size());
  hits.reserve(legs_.size());
  for (PathLeg& leg : legs_) {
    hits.push_back(masked ? world_->meet(leg.ray, leg.from, leg.stream) : SurfaceHit());
    leg.ray.t_max = hits.back().t;
    flights.push_back({leg.ray, -std::log(leg.stream.uniform())});
  }
  std::vector<FreePath> ends(legs_.size());
  if (attenuates_) world_.reach_depths(flights, ends);
  counts_.work[Work::gather] += legs_.size();
  if (attenuates_) counts_.work[Work::extinction] += legs_.size();
  if (masked) counts_.work[Work::masking] += legs_.size();
  if (air_ > 0) counts_.work[Work::atmosphere] += legs_.size();
  if (emits_ && world_.emits()) counts_.work[Work::emission] += legs_.size();

  next_.clear();
  for (std::size_t i = 0; i < legs_.size(); ++i) end_flight(legs_[i], flights[i], ends[i], hits[i]);
  legs_.swap(next_);
  direct_.arrive([this](std::uint32_t path, double radiance) { paths_[path].direct += radiance; });
}

void Gather::end_flight(PathLeg& leg, const Flight& flight, FreePath& end, const SurfaceHit& hit) {
  double& direct = paths_[leg.path].direct;
  double albedo = 0;
  if (only_) {
    albedo = only_->scattering / only_->extinction;
  } else if (end.collided) {
    const LocalOptics local = world_.at_collision(flight, end);
    albedo = local.scattering / local.extinction;
  }
  if (emits_) direct += leg.weight * emission_along(leg, end);

  if (end.collided) {
    const double weight = leg.weight * albedo * air(end.t);
    if (!(weight > 0) || (settings_.scattering_depth && leg.scatterings >= *settings_.scattering_depth)) return;
    ++leg.scatterings;
    scatter(leg, weight, CloudScatterer(world_, leg.ray, end.t));
    return;
  }
  if (!hit.exists()) {
    if (sky_ > 0) ++counts_.work[Work::sky];
    double beyond = sky_;
    if (leg.discs) beyond += direct_.discs_found(leg.ray.direction, leg.density);
    direct += leg.weight * beyond;
    return;
  }
  ++counts_.work[Work::surfaces];
  const SurfacePoint at = world_.surface_at(leg.ray, hit);
  const double seen = leg.weight * air(hit.t);
  if (hit.id.surface >= world_->objects().size()) {
    direct += seen * direct_.sphere_found(leg.ray.origin, at, leg.density);
    return;
  }
  direct += seen * direct_.face_found(at, hit.t, leg.density);
  if (at.reflects()) reflect(leg, seen, at);
}

/// What clouds and air give off between the leg's ends, seen from its beginning: the flight itself has
/// sampled the clouds' transmission.
double Gather::emission_along(const PathLeg& leg, const FreePath& end) const noexcept {
  if (source_) return *source_ * end.depth;
  Ray flown = leg.ray;
  if (end.collided) flown.t_max = end.t;
  double radiance = 0;
  if (air_ > 0 && flown.t_max < kInfinity) radiance = world_.air_radiance() * one_minus_exp(air_ * flown.t_max);
  if (!world_.emits()) return radiance;
  WorldWalk walk(world_, flown);
  while (walk.next()) {
    radiance += walk.optics().emission * air(walk.begin()) * effective_length(air_, walk.end() - walk.begin());
  }
  return radiance;
}

template <class Scatterer>
void Gather::scatter(PathLeg& leg, double weight, const Scatterer& at) {
  const bool last = leg.points >= settings_.gather_bounces;
  if (last) {
    if (!direct_.empty()) direct_.add(leg.path, weight, at, leg.stream, RandomDiscPlaces{leg.stream});
    if (!maps_ || !settings_.parts.map) return;
    const Vec3d key(leg.stream.uniform(), leg.stream.uniform(), leg.points);
    const Estimate estimate = map_light(world_, *maps_, at, settings_.gather, key);
    ++counts_.work[Work::map];
    counts_.anomalies += estimate.anomaly;
    Path& path = paths_[leg.path];
    Incoming& in = incoming_[path.owner];
    for (std::size_t b = 0; b < in.map.size(); ++b) in.map[b] += weight * estimate.batch[b];
    in.bias += weight * estimate.bias;
    path.map += weight * estimate.value;
    return;
  }
  if (!direct_.empty(Beyond::path)) {
    direct_.add(leg.path, weight, at, leg.stream, RandomDiscPlaces{leg.stream}, Beyond::path);
  }
  ++leg.points;
  if (continues(leg.scatterings) && send(leg, weight, at)) next_.push_back(leg);
}

/// The mirror's share or the Lambertian one, by chance.
void Gather::reflect(PathLeg& leg, double weight, const SurfacePoint& at) {
  const MaterialOptics& material = *at.material;
  if (leg.stream.uniform() >= material.specular()) {
    scatter(leg, weight, SurfaceScatterer(at));
    return;
  }
  bool exact;
  const Vec3d toward = mirror_direction(leg.ray.direction, at.normal, material.roughness(), leg.stream, exact);
  leg.weight = weight * material.reflectance(at.cosine);
  // A rough mirror would find the small discs too rarely.
  if (material.roughness() > 0 && direct_.suns()) {
    RandomDiscPlaces discs{leg.stream};
    direct_.add_suns(leg.path, leg.weight, RoughMirror{at, leg.ray.direction}, leg.stream, discs, Beyond::map);
  }
  leg.ray = {at.position, toward, world_->surfaces().clearance(), kInfinity};
  leg.from = at.id;
  leg.density = kInfinity;
  leg.discs = exact;
  ++counts_.work[Work::specular];
  if (survives(leg)) next_.push_back(leg);
}

}  // namespace obscura::detail
