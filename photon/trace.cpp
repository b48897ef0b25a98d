#include "photon/trace.h"

#include <algorithm>
#include <atomic>
#include <numeric>

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include "octree/base/low_discrepancy.h"
#include "octree/base/random.h"
#include "photon/purpose.h"
#include "photon/scatter.h"

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

struct History {
  Vec3d position;
  Vec3d direction;
  double power;
  bool in_direct_set;
  int collisions = 0;
  Stream stream;
};

struct ChunkResult {
  std::vector<Photon> photons;
  EnergyTally energy;
  std::vector<FluxTally> flux;
  double dropped_W = 0;
  std::uint64_t emitted = 0;
  std::uint64_t anomalies = 0;
};

/// Follows a chunk of histories of one batch to their ends, all of them one flight at a time.
void trace_chunk(const World& world, int interval, const TraceSettings& settings,
                 std::span<const FluxRectangle> rectangles, std::size_t batch,
                 std::vector<History> active, ChunkResult& result) {
  // A photon is stored with the order in which its history was emitted, so that the map does not
  // depend on who flew with whom.
  std::vector<std::uint32_t> ids(active.size());
  std::iota(ids.begin(), ids.end(), 0u);
  std::vector<std::pair<std::uint32_t, Photon>> stored;
  std::vector<Flight> flights;
  std::vector<FreePath> ends;
  std::vector<SphereHit> hits;
  EnergyTally& energy = result.energy;
  while (!active.empty()) {
    // Where each flight ends: at a collision, on a sphere, or nowhere.
    flights.clear();
    hits.clear();
    for (History& history : active) {
      Ray ray{history.position, history.direction, 0, kInfinity};
      hits.push_back(world.spheres().intersect(ray));
      ray.t_max = hits.back().t;
      flights.push_back({ray, -std::log(history.stream.uniform())});
    }
    ends.resize(flights.size());
    world.reach_depths(interval, flights, ends);

    std::size_t kept = 0;
    for (std::size_t i = 0; i < active.size(); ++i) {
      History& history = active[i];
      LocalOptics local;
      if (ends[i].collided) local = world.at_collision(interval, flights[i], ends[i]);
      const double t = ends[i].collided ? ends[i].t : hits[i].t;
      for (std::size_t r = 0; r < rectangles.size(); ++r) {
        const int count = crossings(world, rectangles[r], history.position, history.direction, t);
        (count > 0 ? result.flux[r].forward : result.flux[r].backward)[batch] +=
            std::abs(count) * history.power;
      }
      if (!ends[i].collided) {
        (hits[i].t == kInfinity ? energy.escaped : energy.surface)[batch] += history.power;
        continue;
      }
      history.position = world.wrap(flights[i].ray.at(t));

      // Store, unless the sensor pass integrates this light itself.
      const bool direct = history.in_direct_set && history.collisions == 0;
      const bool deep = settings.scattering_depth && history.collisions >= *settings.scattering_depth;
      if (!direct && !deep) {
        if (history.power >= settings.photon_power_min) {
          Photon photon;
          photon.position = Vec3f(transform_point(world.world_to_map(), history.position));
          photon.direction = encode_direction(transform_direction(world.world_to_map(), history.direction));
          photon.power = static_cast<float>(history.power);
          photon.batch = static_cast<std::uint8_t>(batch);
          photon.collisions = static_cast<std::uint16_t>(std::min(history.collisions, 65535));
          stored.emplace_back(ids[i], photon);
        } else {
          result.dropped_W += history.power;
        }
      }
      ++history.collisions;

      // Roulette with the voxel's own albedo: survivors keep their power.
      if (history.stream.uniform() * local.extinction >= local.scattering) {
        energy.absorbed[batch] += history.power;
        continue;
      }
      if (deep) {
        energy.truncated[batch] += history.power;
        continue;
      }
      const LocalScattering scattering(world, interval, history.position);
      if (!(scattering.total() > 0)) {
        ++result.anomalies;
        energy.absorbed[batch] += history.power;
        continue;
      }
      const double u = history.stream.uniform();
      const double v = history.stream.uniform();
      history.direction = scattering.sample(history.direction, u, v, history.stream.uniform());
      if (kept != i) {
        active[kept] = active[i];
        ids[kept] = ids[i];
      }
      ++kept;
    }
    active.erase(active.begin() + static_cast<std::ptrdiff_t>(kept), active.end());
    ids.resize(kept);
  }
  std::stable_sort(stored.begin(), stored.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  result.photons.reserve(stored.size());
  for (const auto& [id, photon] : stored) result.photons.push_back(photon);
}

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

TraceResult trace_photons(const World& world, int interval, const TraceSettings& settings,
                          std::span<const FluxRectangle> rectangles, const Progress& progress) {
  TraceResult result;
  result.flux.resize(rectangles.size());
  const PhotonEmitter emitter(world, interval, settings.sources);
  if (settings.photons == 0 || !(emitter.power() > 0)) return result;

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
    std::vector<std::pair<double, std::uint32_t>> order(count);
    tbb::parallel_for(std::uint64_t{0}, count, [&](std::uint64_t i) {
      order[i] = {numbers(i)[0], static_cast<std::uint32_t>(i)};
    });
    tbb::parallel_sort(order.begin(), order.end());

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
        const std::uint64_t id = order[i].second;
        const EmittedPhoton photon = emitter.emit(numbers(id), cache);
        const double power = photon.power * share;
        if (!std::isfinite(power)) {
          ++part.anomalies;
          continue;
        }
        part.energy.emitted[batch] += power;
        ++part.emitted;
        histories.push_back({photon.position, photon.direction, power, photon.in_direct_set, 0,
                             Stream(settings.seed, first + id, purpose_id(Purpose::tracing, interval))});
      }
      trace_chunk(world, interval, settings, rectangles, batch, std::move(histories), part);
      progress.report("photons", done += end - begin, settings.photons);
    });

    // In chunk order: the same bits for any number of threads.
    for (ChunkResult& part : parts) {
      result.photons.insert(result.photons.end(), part.photons.begin(), part.photons.end());
      part.photons = {};
      result.energy += part.energy;
      for (std::size_t r = 0; r < part.flux.size(); ++r) {
        result.flux[r] += part.flux[r];
      }
      result.emitted += part.emitted;
      result.dropped_W += part.dropped_W;
      result.anomalies += part.anomalies;
    }
    first += count;
  }
  result.partial = cancelled;
  return result;
}

}  // namespace obscura
