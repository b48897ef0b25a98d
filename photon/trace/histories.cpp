#include "photon/trace/histories.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "photon/optics/sampling.h"
#include "photon/world/scatter.h"

namespace obscura::detail {
namespace {

/// Reflections after which a history ends: mirrors that lose nothing would keep it for ever.
constexpr int kMostReflections = 10000;

/// A photon with the order in which its history was emitted: sorted by it, the map does not depend on which histories
/// flew together.
using Stored = std::vector<std::pair<std::uint32_t, Photon>>;

std::vector<Photon> in_order(Stored& stored) {
  std::stable_sort(stored.begin(), stored.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Photon> photons;
  photons.reserve(stored.size());
  for (const auto& [id, photon] : stored) photons.push_back(photon);
  return photons;
}

/// A chunk of histories of one batch, all of them one flight at a time.
class HistoryChunk {
 public:
  HistoryChunk(const PhotonEmitter& emitter, const TraceSettings& settings, std::span<const FluxRectangle> rectangles,
               std::size_t batch, TraceResult& result)
      : world_(emitter.world()),
        focus_(emitter.focus()),
        settings_(settings),
        rectangles_(rectangles),
        batch_(batch),
        air_(world_.air_extinction()),
        attenuates_(world_.attenuates()),
        masked_(!world_->surfaces().empty()),
        result_(result) {}

  /// Follows them to their ends.
  void run(std::vector<History> active) {
    std::vector<Flight> flights;
    std::vector<FreePath> ends;
    std::vector<SurfaceHit> hits;
    while (!active.empty()) {
      // Where each flight ends: at a collision, on a surface, or nowhere.
      flights.clear();
      hits.clear();
      for (History& history : active) {
        Ray ray{history.position, history.direction, history.from.exists() ? world_->surfaces().clearance() : 0.0,
                kInfinity};
        hits.push_back(masked_ ? world_->meet(ray, history.from, history.stream) : SurfaceHit());
        ray.t_max = hits.back().t;
        flights.push_back({ray, -std::log(history.stream.uniform())});
      }
      ends.resize(flights.size());
      if (attenuates_) world_.reach_depths(flights, ends);
      if (attenuates_) result_.work[Work::extinction] += flights.size();
      if (masked_) result_.work[Work::masking] += flights.size();
      if (air_ > 0) result_.work[Work::atmosphere] += flights.size();

      std::size_t kept = 0;
      for (std::size_t i = 0; i < active.size(); ++i) {
        if (!follow(active[i], flights[i], ends[i], hits[i])) continue;
        if (kept != i) active[kept] = active[i];
        ++kept;
      }
      active.erase(active.begin() + static_cast<std::ptrdiff_t>(kept), active.end());
    }
    result_.photons = in_order(collided_);
    result_.surface_photons = in_order(landed_);
  }

 private:
  /// One flight to its end; false where the history ends too.
  bool follow(History& history, const Flight& flight, FreePath& end, const SurfaceHit& hit) {
    LocalOptics local;
    if (end.collided) local = world_.at_collision(flight, end);
    double t = end.collided ? end.t : hit.t;
    // The air may absorb it before. Light from beyond is given as it arrives at the scene: the air does not dim it.
    bool lost_in_air = false;
    if (air_ > 0 && !history.from_beyond) {
      const double t_air = -std::log(history.stream.uniform()) / air_;
      lost_in_air = t_air < t;
      t = std::min(t, t_air);
    }
    for (std::size_t r = 0; r < rectangles_.size(); ++r) {
      const int count = crossings(*world_, rectangles_[r], history.position, history.direction, t);
      (count > 0 ? result_.flux[r].forward : result_.flux[r].backward)[batch_] += std::abs(count) * history.power;
    }
    EnergyTally& energy = result_.energy;
    if (lost_in_air) {
      energy.absorbed[batch_] += history.power;
      return false;
    }
    if (end.collided) {
      history.position = world_->wrap(flight.ray.at(t));
      return collide(history, local);
    }
    if (hit.exists()) return land(history, world_.surface_at(flight.ray, hit));
    energy.escaped[batch_] += history.power;
    return false;
  }

  bool collide(History& history, const LocalOptics& local) {
    ++result_.work[Work::collisions];
    const bool deep = settings_.scattering_depth && history.collisions >= *settings_.scattering_depth;
    // Store, unless the sensor pass integrates this light itself.
    if (!history.in_direct_set && !deep) {
      store(collided_, history, static_cast<std::uint16_t>(std::min(history.collisions, 65535)));
    }
    ++history.collisions;
    history.in_direct_set = history.from_beyond = false;
    history.from = {};

    // Roulette with the voxel's own albedo: survivors keep their power.
    EnergyTally& energy = result_.energy;
    if (history.stream.uniform() * local.extinction >= local.scattering) {
      energy.absorbed[batch_] += history.power;
      return false;
    }
    if (deep) {
      energy.truncated[batch_] += history.power;
      return false;
    }
    const LocalScattering scattering(world_, history.position);
    if (!(scattering.total() > 0)) {
      ++result_.anomalies;
      energy.absorbed[batch_] += history.power;
      return false;
    }
    const double u = history.stream.uniform();
    const double v = history.stream.uniform();
    history.direction = scattering.sample(history.direction, u, v, history.stream.uniform());
    return true;
  }

  bool land(History& history, const SurfacePoint& at) {
    ++result_.work[Work::surfaces];
    EnergyTally& energy = result_.energy;
    if (!at.reflects()) {
      energy.surface[batch_] += history.power;
      return false;
    }
    history.position = at.position;
    if (!history.in_direct_set) store(landed_, history, encode_normal(at.normal));
    history.in_direct_set = history.from_beyond = false;
    history.from = at.id;

    // At the first surface the reflected share goes on: land that is nearly black would else send few and
    // strong photons. Later roulette decides, and survivors keep their power.
    if (++history.reflections > kMostReflections) {
      energy.truncated[batch_] += history.power;
      return false;
    }
    const double reflectance = at.reflectance(at.cosine);
    if (history.reflections == 1 && history.collisions == 0) {
      energy.surface[batch_] += (1 - reflectance) * history.power;
      history.power *= reflectance;
      if (!(history.power > 0)) return false;
    } else if (history.stream.uniform() >= reflectance) {
      energy.surface[batch_] += history.power;
      return false;
    }
    if (history.stream.uniform() < at.material->specular()) {
      ++result_.work[Work::specular];
      bool exact;
      history.direction =
          mirror_direction(history.direction, at.normal, at.material->roughness(), history.stream, exact);
      return true;
    }
    return reflect_diffusely(history, at);
  }

  /// Draws a direction in proportion to cosine and reflectance. At the first surface half of the directions are aimed
  /// at the clouds, and weights make up for it.
  bool reflect_diffusely(History& history, const SurfacePoint& at) {
    Stream& stream = history.stream;
    const auto lambertian = [&] {
      for (;;) {
        const double u = stream.uniform();
        const Vec3d direction = cosine_direction(at.normal, u, stream.uniform());
        if (stream.uniform() < at.reflectance(direction.dot(at.normal))) return direction;
      }
    };
    const Vec3d way = focus_ ? focus_->center - at.position : Vec3d(0);
    const double distance = way.length();
    if (!focus_ || history.reflections > 1 || history.collisions > 0 || distance < 1.05 * focus_->radius) {
      history.direction = lambertian();
      return true;
    }
    const double sine = focus_->radius / distance;
    const double u = stream.uniform(), v = stream.uniform();
    const auto [aimed, solid_angle] = cone_direction(way / distance, sine, u, v);
    history.direction = stream.uniform() < 0.5 ? aimed : lambertian();
    const double cosine = history.direction.dot(at.normal);
    const double wanted =
        cosine > 0 ? cosine * at.reflectance(cosine) / (kPi * (1 - at.material->hemispherical_emissivity())) : 0.0;
    const bool in_cone = history.direction.dot(way) >= distance * std::sqrt(1 - sine * sine);
    const double weight = wanted / (0.5 * wanted + (in_cone ? 0.5 / solid_angle : 0.0));
    // Power that the weight adds or removes is booked as emitted, so that the balance of power stays exact.
    result_.energy.emitted[batch_] += (weight - 1) * history.power;
    history.power *= weight;
    return history.power > 0;
  }

  void store(Stored& list, const History& history, std::uint16_t label) {
    if (!settings_.store) return;
    if (!(history.power >= settings_.photon_power_min)) {
      result_.dropped_W += history.power;
      return;
    }
    Photon photon;
    Vec3d position = transform_point(world_->world_to_map(), history.position);
    if (!world_->surfaces().empty()) {
      // Back by what float rounds away, so that it does not come to lie behind a surface.
      const double size = std::max({std::abs(position.x), std::abs(position.y), std::abs(position.z)});
      position -= 1.2e-7 * size * transform_direction(world_->world_to_map(), history.direction);
    }
    photon.position = Vec3f(position);
    photon.direction = encode_direction(transform_direction(world_->world_to_map(), history.direction));
    photon.power = static_cast<float>(history.power);
    photon.batch = static_cast<std::uint16_t>(batch_);
    photon.collisions = label;
    list.emplace_back(history.id, photon);
  }

  SpectralWorld world_;
  std::optional<PhotonEmitter::Focus> focus_;
  const TraceSettings& settings_;
  std::span<const FluxRectangle> rectangles_;
  std::size_t batch_;
  double air_;
  bool attenuates_;
  bool masked_;
  TraceResult& result_;
  Stored collided_, landed_;
};

}  // namespace

void follow_histories(const PhotonEmitter& emitter, const TraceSettings& settings,
                      std::span<const FluxRectangle> rectangles, std::size_t batch, std::vector<History> histories,
                      TraceResult& result) {
  HistoryChunk(emitter, settings, rectangles, batch, result).run(std::move(histories));
}

}  // namespace obscura::detail
