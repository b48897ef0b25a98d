// The photon map, asked where light scatters into a ray, or behind one bounce (final gather). Both ask the same maps.
#include <fmt/format.h>

#include <algorithm>

#include "photon/methods/by_rays.h"
#include "photon/paths/path_tracer.h"

namespace obscura {
namespace {

/// Photons of balance(): enough to tell where power goes to some tenths of a per cent.
constexpr std::uint64_t kBalancePhotons = 65536;

TraceSettings trace_settings(const Method& method, const EstimatorSettings& settings) {
  TraceSettings trace;
  trace.photons = method.photons;
  trace.photon_power_min = method.photon_power_min;
  trace.directions = method.directions;
  trace.scattering_depth = settings.scattering ? method.scattering_depth : std::optional(0);
  trace.seed = settings.seed;
  return trace;
}

/// Whether anything asks for what photons leave behind.
bool maps_are_asked(const EstimatorSettings& settings) { return settings.again || !settings.rectangles.empty(); }

std::optional<NumericalError> unfit_map(const World& world, const Method& method, const EstimatorSettings& settings) {
  if (!maps_are_asked(settings)) return std::nullopt;
  return unfit_for_photons(world, method.photons > 0, settings.rectangles);
}

/// The bounce of a final gather finds light as paths do: where paths cannot serve, it cannot either.
std::optional<NumericalError> unfit_gather(const World& world, const Method& method,
                                           const EstimatorSettings& settings) {
  if (settings.again) {
    if (auto refusal = unfit_for_paths(world)) return refusal;
  }
  return unfit_map(world, method, settings);
}

SolutionBasis basis_of(const Method& method, const EstimatorSettings& settings) {
  SolutionBasis basis;
  basis.method.type = &kPhotonMap;
  basis.method.photons = method.photons;
  basis.method.photon_power_min = method.photon_power_min;
  basis.method.directions = method.directions;
  basis.method.scattering_depth = method.scattering_depth;
  basis.settings.scattering = settings.scattering;
  basis.settings.again = settings.again;
  basis.settings.seed = settings.seed;
  basis.settings.rectangles = settings.rectangles;
  return basis;
}

/// What becomes of the power, from a few photons of which none is stored: where nothing asks for maps.
Light balance(const World& world, TraceSettings few, const Progress& progress) {
  few.photons = std::min(few.photons, kBalancePhotons);
  few.store = false;
  if (unfit_for_photons(world, few.photons > 0, {})) return {};
  Light light = trace_light(world, few, {}, progress);
  light.maps.clear();
  return light;
}

Solution solve(const World& world, const Method& method, const EstimatorSettings& settings, const Progress& progress) {
  const TraceSettings trace = trace_settings(method, settings);
  return std::make_shared<const Light>(maps_are_asked(settings)
                                           ? trace_light(world, trace, settings.rectangles, progress)
                                           : balance(world, trace, progress));
}

Estimator by_maps(const World& world, const RadianceSettings& radiance, const Solution& solution) {
  auto light = std::static_pointer_cast<const Light>(solution);
  Estimator estimator;
  estimator.light = light.get();
  estimator.bytes = static_cast<double>(light->bytes);
  estimator.crossing = [light](int band, std::size_t rectangle, int) -> std::optional<Crossing> {
    const auto b = static_cast<std::size_t>(band);
    if (b >= light->bands.size()) return std::nullopt;
    return crossing_of(light->bands[b].flux[rectangle]);
  };
  detail::answer_by_rays(world, radiance, std::move(light), estimator);
  return estimator;
}

Estimator by_map(const World& world, const Method& method, const EstimatorSettings& settings,
                 const Solution& solution) {
  Estimator estimator = by_maps(world, detail::radiance_settings(method, settings), solution);
  estimator.what = fmt::format("{} photons, {} nearest, no final gather", method.photons, method.nearest);
  return estimator;
}

Estimator by_gather(const World& world, const Method& method, const EstimatorSettings& settings,
                    const Solution& solution) {
  RadianceSettings radiance = detail::radiance_settings(method, settings);
  if (settings.again) {
    radiance.gather_bounces = 1;
    // So many estimates are averaged that the fewest cubature points are enough for each.
    radiance.gather.rounds = 2;
  }
  Estimator estimator = by_maps(world, radiance, solution);
  estimator.what = fmt::format("{} photons, {} nearest, final gather by {} paths a pixel", method.photons,
                               method.nearest, method.samples);
  return estimator;
}

/// Batches are shares of the whole.
Measured power_of(const BatchTally& shares) {
  BatchTally batches = shares;
  for (double& watts : batches) watts *= kBatches;
  return {pairwise_sum(shares), batch_mean(batches).standard_error, kBatches - 1.0, 0};
}

}  // namespace

Crossing crossing_of(const FluxTally& tally) {
  BatchTally net;
  for (std::size_t k = 0; k < net.size(); ++k) net[k] = tally.forward[k] - tally.backward[k];
  return {power_of(tally.forward), power_of(tally.backward), power_of(net).error};
}

const MethodType kPhotonMap{.word = "photon",
                            .name = "photon map",
                            .photons = true,
                            .unfit = unfit_map,
                            .basis = basis_of,
                            .solve = solve,
                            .estimator = by_map};

const MethodType kFinalGather{.word = "photon",
                              .name = "final gather",
                              .photons = true,
                              .samples = true,
                              .unfit = unfit_gather,
                              .basis = basis_of,
                              .solve = solve,
                              .estimator = by_gather};

}  // namespace obscura
