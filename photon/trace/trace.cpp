#include "photon/trace/trace.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <atomic>
#include <numeric>

#include "octree/base/low_discrepancy.h"
#include "octree/base/random.h"
#include "photon/optics/purpose.h"
#include "photon/world/scatter.h"

namespace obscura {
namespace {

/// Histories that fly together through the batched walk.
constexpr std::size_t kChunk = 2048;

/// The numbers of emission: eight per history.
class EmissionNumbers {
 public:
  EmissionNumbers(const TraceSettings& settings, int interval, int batch, std::uint64_t first)
      : settings_(&settings),
        interval_(interval),
        first_(first),
        // One unscrambled sequence for all batches, or one of their own for each.
        sequence_(settings.seed + 0x9E3779B97F4A7C15u * static_cast<std::uint64_t>(interval),
                  static_cast<std::uint32_t>(batch), settings.directions == Directions::stratified) {}

  std::array<double, 8> operator()(std::uint64_t i) const noexcept {
    if (settings_->directions == Directions::random) {
      std::array<double, 8> u;
      Stream stream(settings_->seed, first_ + i, purpose_id(Purpose::emission, interval_));
      for (double& x : u) x = stream.uniform();
      return u;
    }
    const bool regular = settings_->directions == Directions::regular;
    return sequence_.point(static_cast<std::uint32_t>(regular ? first_ + i : i));
  }

 private:
  const TraceSettings* settings_;
  int interval_;
  std::uint64_t first_;
  LowDiscrepancy sequence_;
};

/// Reflections after which a history ends: mirrors that lose nothing would keep it for ever.
constexpr int kMostReflections = 10000;

struct History {
  Vec3d position;
  Vec3d direction;
  double power;
  bool in_direct_set;  // until it collides or is reflected
  bool from_beyond;    // likewise
  FaceId from;         // the face that it leaves
  int collisions = 0;
  int reflections = 0;
  std::uint32_t id = 0;  // its place among the emitted of its chunk
  Stream stream;
};

/// A photon is stored with the order in which its history was emitted, so that the map does not depend on
/// who flew with whom.
using Stored = std::vector<std::pair<std::uint32_t, Photon>>;

struct ChunkResult {
  std::vector<Photon> photons;
  std::vector<Photon> surface_photons;
  EnergyTally energy;
  std::vector<FluxTally> flux;
  WorkCounts work;
  double dropped_W = 0;
  std::uint64_t emitted = 0;
  std::uint64_t anomalies = 0;
};

std::vector<Photon> in_order(Stored& stored) {
  std::stable_sort(stored.begin(), stored.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Photon> photons;
  photons.reserve(stored.size());
  for (const auto& [id, photon] : stored) photons.push_back(photon);
  return photons;
}

/// A chunk of histories of one batch, all of them one flight at a time.
class Chunk {
 public:
  Chunk(const World& world, const PhotonEmitter& emitter, const TraceSettings& settings,
        std::span<const FluxRectangle> rectangles, std::size_t batch, ChunkResult& result)
      : world_(world),
        interval_(emitter.interval()),
        focus_(emitter.focus()),
        settings_(settings),
        rectangles_(rectangles),
        batch_(batch),
        air_(world.air_extinction(interval_)),
        attenuates_(world.attenuates(interval_)),
        masked_(!world.surfaces().empty()),
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
        Ray ray{history.position, history.direction, history.from.exists() ? world_.surfaces().clearance() : 0.0,
                kInfinity};
        hits.push_back(masked_ ? world_.meet(ray, history.from, history.stream) : SurfaceHit());
        ray.t_max = hits.back().t;
        flights.push_back({ray, -std::log(history.stream.uniform())});
      }
      ends.resize(flights.size());
      if (attenuates_) world_.reach_depths(interval_, flights, ends);
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
    if (end.collided) local = world_.at_collision(interval_, flight, end);
    double t = end.collided ? end.t : hit.t;
    // The air may have taken it before; what comes from beyond is given as it arrives.
    bool lost_in_air = false;
    if (air_ > 0 && !history.from_beyond) {
      const double t_air = -std::log(history.stream.uniform()) / air_;
      lost_in_air = t_air < t;
      t = std::min(t, t_air);
    }
    for (std::size_t r = 0; r < rectangles_.size(); ++r) {
      const int count = crossings(world_, rectangles_[r], history.position, history.direction, t);
      (count > 0 ? result_.flux[r].forward : result_.flux[r].backward)[batch_] += std::abs(count) * history.power;
    }
    EnergyTally& energy = result_.energy;
    if (lost_in_air) {
      energy.absorbed[batch_] += history.power;
      return false;
    }
    if (end.collided) {
      history.position = world_.wrap(flight.ray.at(t));
      return collide(history, local);
    }
    if (hit.exists()) return land(history, world_.surface_at(interval_, flight.ray, hit));
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
    const LocalScattering scattering(world_, interval_, history.position);
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

  /// In proportion to cosine and reflectance; at the first surface half of all at the clouds, with weights.
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
    // What the weight gives or takes is as if emitted: the balance stays exact.
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
    Vec3d position = transform_point(world_.world_to_map(), history.position);
    if (!world_.surfaces().empty()) {
      // Back by what float rounds away, so that it does not come to lie behind a surface.
      const double size = std::max({std::abs(position.x), std::abs(position.y), std::abs(position.z)});
      position -= 1.2e-7 * size * transform_direction(world_.world_to_map(), history.direction);
    }
    photon.position = Vec3f(position);
    photon.direction = encode_direction(transform_direction(world_.world_to_map(), history.direction));
    photon.power = static_cast<float>(history.power);
    photon.batch = static_cast<std::uint8_t>(batch_);
    photon.collisions = label;
    list.emplace_back(history.id, photon);
  }

  const World& world_;
  int interval_;
  std::optional<PhotonEmitter::Focus> focus_;
  const TraceSettings& settings_;
  std::span<const FluxRectangle> rectangles_;
  std::size_t batch_;
  double air_;
  bool attenuates_;
  bool masked_;
  ChunkResult& result_;
  Stored collided_, landed_;
};

void add(BatchTally& sum, const BatchTally& part) noexcept {
  for (std::size_t b = 0; b < sum.size(); ++b) sum[b] += part[b];
}

}  // namespace

EnergyTally& EnergyTally::operator+=(const EnergyTally& other) noexcept {
  add(emitted, other.emitted);
  add(absorbed, other.absorbed);
  add(surface, other.surface);
  add(escaped, other.escaped);
  add(truncated, other.truncated);
  return *this;
}

FluxTally& FluxTally::operator+=(const FluxTally& other) noexcept {
  add(forward, other.forward);
  add(backward, other.backward);
  return *this;
}

TraceResult trace_photons(const World& world, const PhotonEmitter& emitter, const TraceSettings& settings,
                          std::span<const FluxRectangle> rectangles, const Progress& progress) {
  const int interval = emitter.interval();
  TraceResult result;
  result.flux.resize(rectangles.size());
  if (settings.photons == 0 || !emitter.emits()) return result;

  // Batches are dealt equal shares; with fewer photons than batches some stay empty.
  const std::uint64_t batches = std::min<std::uint64_t>(settings.photons, kBatches);
  std::atomic<std::uint64_t> done{0};
  std::atomic<bool> cancelled{false};
  std::uint64_t first = 0;
  for (std::uint64_t batch = 0; batch < batches; ++batch) {
    if (progress.cancelled()) cancelled = true;
    if (cancelled) break;
    const std::uint64_t count = settings.photons / batches + (batch < settings.photons % batches);
    const EmissionNumbers numbers(settings, interval, static_cast<int>(batch), first);
    const double share = 1.0 / (static_cast<double>(batches) * static_cast<double>(count));

    // In the order of the first number, neighbours come from the same voxels.
    std::vector<std::pair<double, std::uint32_t>> order;
    if (emitter.has_clouds()) {
      order.resize(count);
      tbb::parallel_for(std::uint64_t{0}, count, [&](std::uint64_t i) {
        order[i] = {numbers(i)[0], static_cast<std::uint32_t>(i)};
      });
      tbb::parallel_sort(order.begin(), order.end());
    }

    const std::size_t chunks = (count + kChunk - 1) / kChunk;
    std::vector<ChunkResult> parts(chunks);
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t c) {
      if (progress.cancelled()) cancelled = true;
      if (cancelled) return;
      const std::size_t begin = c * kChunk;
      const std::size_t end = std::min<std::size_t>(begin + kChunk, count);
      ChunkResult& part = parts[c];
      part.flux.resize(rectangles.size());
      PhotonEmitter::Cache cache;
      std::vector<History> histories;
      histories.reserve(end - begin);
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint64_t id = order.empty() ? i : order[i].second;
        const EmittedPhoton photon = emitter.emit(numbers(id), cache);
        const double power = photon.power * share;
        if (!std::isfinite(power)) {
          ++part.anomalies;
          continue;
        }
        part.energy.emitted[batch] += power;
        ++part.emitted;
        ++part.work[photon.work];
        if (power == 0) continue;
        histories.push_back({photon.position, photon.direction, power, photon.in_direct_set, photon.from_beyond,
                             photon.from, 0, 0, static_cast<std::uint32_t>(histories.size()),
                             Stream(settings.seed, first + id, purpose_id(Purpose::tracing, interval))});
      }
      Chunk(world, emitter, settings, rectangles, batch, part).run(std::move(histories));
      progress.report("photons", done += end - begin, settings.photons);
    });

    // In chunk order: the same bits for any number of threads.
    for (ChunkResult& part : parts) {
      result.photons.insert(result.photons.end(), part.photons.begin(), part.photons.end());
      result.surface_photons.insert(result.surface_photons.end(), part.surface_photons.begin(),
                                    part.surface_photons.end());
      part.photons = {};
      part.surface_photons = {};
      result.energy += part.energy;
      for (std::size_t r = 0; r < part.flux.size(); ++r) {
        result.flux[r] += part.flux[r];
      }
      result.emitted += part.emitted;
      result.work += part.work;
      result.dropped_W += part.dropped_W;
      result.anomalies += part.anomalies;
    }
    first += count;
  }
  if (world.interval(interval).interval > 0) result.work[Work::spectral] += result.emitted;
  result.partial = cancelled;
  return result;
}

}  // namespace obscura
