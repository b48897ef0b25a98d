// All photons of an interval: emission, batches, chunks, and the sums of what became of them.
#include "photon/trace/trace.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <atomic>

#include "octree/base/low_discrepancy.h"
#include "photon/optics/purpose.h"
#include "photon/trace/histories.h"

namespace obscura {
namespace {

/// Histories that fly together through the batched walk.
constexpr std::size_t kChunk = 2048;

/// The uniform numbers that emission draws from: eight per history.
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
      Stream stream = StreamName{settings_->seed, first_ + i, Purpose::emission, interval_}.stream();
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

PhotonTally& PhotonTally::operator+=(const PhotonTally& other) {
  energy += other.energy;
  flux.resize(std::max(flux.size(), other.flux.size()));
  for (std::size_t r = 0; r < other.flux.size(); ++r) flux[r] += other.flux[r];
  emitted += other.emitted;
  work += other.work;
  dropped_W += other.dropped_W;
  anomalies += other.anomalies;
  return *this;
}

TraceResult trace_photons(const PhotonEmitter& emitter, const TraceSettings& settings,
                          std::span<const FluxRectangle> rectangles, const Progress& progress) {
  const int interval = emitter.world().interval();
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
    std::vector<TraceResult> parts(chunks);
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t c) {
      if (progress.cancelled()) cancelled = true;
      if (cancelled) return;
      const std::size_t begin = c * kChunk;
      const std::size_t end = std::min<std::size_t>(begin + kChunk, count);
      TraceResult& part = parts[c];
      part.flux.resize(rectangles.size());
      PhotonEmitter::Cache cache;
      std::vector<detail::History> histories;
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
                             StreamName{settings.seed, first + id, Purpose::tracing, interval}.stream()});
      }
      detail::follow_histories(emitter, settings, rectangles, batch, std::move(histories), part);
      progress.report("photons", done += end - begin, settings.photons);
    });

    // In chunk order: the same bits for any number of threads.
    for (TraceResult& part : parts) {
      result.photons.insert(result.photons.end(), part.photons.begin(), part.photons.end());
      result.surface_photons.insert(result.surface_photons.end(), part.surface_photons.begin(),
                                    part.surface_photons.end());
      part.photons = {};
      part.surface_photons = {};
      result += part;
    }
    first += count;
  }
  if (emitter.world().place_in_band().interval > 0) result.work[Work::spectral] += result.emitted;
  result.partial = cancelled;
  return result;
}

}  // namespace obscura
