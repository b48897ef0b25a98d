#include "photon/trace/light.h"

#include <algorithm>

#include "photon/world/thickness.h"

namespace obscura {
namespace {

/// Divides the photons among the groups of sources so that the noise of what the maps hold is least: in proportion to
/// the root mean square of what one photon of the group stores. A pilot of a few photons of each group measures that.
void share_photons(PhotonEmitter& emitter, const TraceSettings& settings, WorkCounts& work) {
  const std::uint64_t pilots = std::clamp<std::uint64_t>(settings.photons / 50, 4096, 65536);
  constexpr double kLeast = 0.01;  // of the largest share: a pilot may have missed what a source rarely stores
  if (emitter.group_count() < 2 || settings.photons < 4 * pilots) return;
  TraceSettings pilot = settings;
  pilot.photons = pilots;
  pilot.photon_power_min = 0;
  pilot.seed = ~settings.seed;
  std::vector<double> shares;
  for (std::size_t g = 0; g < emitter.group_count(); ++g) {
    const TraceResult traced = trace_photons(emitter.only(g), pilot);
    work += traced.work;
    double squares = 0;
    for (const std::vector<Photon>* photons : {&traced.photons, &traced.surface_photons}) {
      for (const Photon& photon : *photons)
        squares += static_cast<double>(photon.power) * static_cast<double>(photon.power);
    }
    shares.push_back(std::sqrt(squares));
  }
  const double most = *std::max_element(shares.begin(), shares.end());
  if (!(most > 0)) return;
  for (double& share : shares) share = std::max(share, kLeast * most);
  emitter.set_shares(shares);
}

}  // namespace

std::optional<NumericalError> unfit_for_photons(const World& world, bool traced,
                                                std::span<const FluxRectangle> rectangles) {
  if (world.periodic()) {
    const char* remedy = "use method \"path\", or make the clouds not periodic";
    if (!world.surfaces().empty() || !world.beams().empty()) {
      return NumericalError("method \"photon\"",
                            "objects, hot spheres, particles and beams are finite, but photons of a periodic cloud "
                            "stand for those of all its copies",
                            remedy);
    }
    for (int c = 0; c < world.cloud_count(); ++c) {
      // The sides of the cloud's cell in the world, turned and scaled with it.
      for (int axis = 0; axis < 2; ++axis) {
        Vec3d side(0);
        side[axis] = world.frame(c).period_m[static_cast<std::size_t>(axis)];
        side = transform_direction(world.clouds()[static_cast<std::size_t>(c)].local_to_world, side);
        const Vec3d& cell = world.period()[static_cast<std::size_t>(axis)];
        if ((side - cell).length() > 1e-9 * cell.length())
          return NumericalError("method \"photon\"", "clouds of different periods have no common cell", remedy);
      }
    }
    for (const FluxRectangle& rectangle : rectangles) {
      const Vec3d normal = rectangle.side_u.cross(rectangle.side_v).normalized();
      for (const Vec3d& period : world.period()) {
        if (std::abs(normal.dot(period)) > 1e-9 * period.length()) {
          return NumericalError("flux", "a rectangle that stands upright is crossed without end in a periodic scene",
                                "turn its normal to the vertical");
        }
      }
    }
  }
  for (int i = 0; traced && i < world.interval_count(); ++i) {
    if (auto endless = endless_histories({world, i}, "photon")) return endless;
  }
  return std::nullopt;
}

void Light::add_tallies(const Light& other) {
  const std::uint64_t all = emitted + other.emitted;
  const double share = all > 0 ? static_cast<double>(other.emitted) / static_cast<double>(all) : 1.0;
  const auto mix = [share](BatchTally& mine, const BatchTally& theirs) {
    for (std::size_t b = 0; b < mine.size(); ++b) mine[b] += share * (theirs[b] - mine[b]);
  };
  if (bands.empty()) bands = other.bands;
  for (std::size_t k = 0; k < other.bands.size(); ++k) {
    EnergyTally& mine = bands[k].energy;
    const EnergyTally& theirs = other.bands[k].energy;
    mix(mine.emitted, theirs.emitted);
    mix(mine.absorbed, theirs.absorbed);
    mix(mine.surface, theirs.surface);
    mix(mine.escaped, theirs.escaped);
    mix(mine.truncated, theirs.truncated);
    for (std::size_t r = 0; r < bands[k].flux.size(); ++r) {
      mix(bands[k].flux[r].forward, other.bands[k].flux[r].forward);
      mix(bands[k].flux[r].backward, other.bands[k].flux[r].backward);
    }
  }
  dropped_W += share * (other.dropped_W - dropped_W);
  emitted = all;
  stored += other.stored;
  work += other.work;
  bytes = std::max(bytes, other.bytes);
  anomalies += other.anomalies;
  partial = partial || other.partial;
}

Light trace_light(const World& world, const TraceSettings& settings, std::span<const FluxRectangle> rectangles,
                  const Progress& progress) {
  if (auto refusal = unfit_for_photons(world, settings.photons > 0, rectangles)) throw *refusal;
  Light light;
  light.bands.resize(world.bands().size());
  for (BandLight& band : light.bands) band.flux.resize(rectangles.size());

  // Power of every interval's sources, and the sum of its band.
  Box3d around;
  for (const FluxRectangle& rectangle : rectangles) {
    for (const double u : {-0.5, 0.5}) {
      for (const double v : {-0.5, 0.5})
        around.extendBy(rectangle.center + u * rectangle.side_u + v * rectangle.side_v);
    }
  }
  std::vector<PhotonEmitter> emitters;
  std::vector<double> band_power(world.bands().size(), 0.0);
  for (int i = 0; i < world.interval_count(); ++i) {
    emitters.emplace_back(SpectralWorld(world, i), settings.sources, around);
    band_power[static_cast<std::size_t>(world.interval(i).band)] += emitters.back().power();
  }
  for (int i = 0; i < world.interval_count(); ++i) {
    const auto b = static_cast<std::size_t>(world.interval(i).band);
    TraceSettings share = settings;
    share.photons = 0;
    PhotonEmitter& emitter = emitters[static_cast<std::size_t>(i)];
    if (emitter.power() > 0 && settings.photons > 0) {
      const double part = emitter.power() / band_power[b];
      share.photons = std::max<std::uint64_t>(
          1, static_cast<std::uint64_t>(std::llround(part * static_cast<double>(settings.photons))));
    }
    share_photons(emitter, share, light.work);
    TraceResult traced = trace_photons(emitter, share, rectangles, progress);
    BandLight& band = light.bands[b];
    band.energy += traced.energy;
    for (std::size_t r = 0; r < rectangles.size(); ++r) band.flux[r] += traced.flux[r];
    light.emitted += traced.emitted;
    light.work += traced.work;
    light.stored += traced.photons.size() + traced.surface_photons.size();
    light.dropped_W += traced.dropped_W;
    light.anomalies += traced.anomalies;
    light.partial = light.partial || traced.partial;
    light.maps.push_back({PhotonMap(std::move(traced.photons), world.map_period()),
                          PhotonMap(std::move(traced.surface_photons), world.map_period())});
    light.bytes += light.maps.back().volume.bytes() + light.maps.back().surface.bytes();
  }
  return light;
}

}  // namespace obscura
