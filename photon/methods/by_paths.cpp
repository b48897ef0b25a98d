// The path tracer: no map, no bias.
#include <fmt/format.h>

#include "photon/methods/by_rays.h"
#include "photon/paths/path_tracer.h"

namespace obscura {
namespace {

std::optional<NumericalError> unfit_paths(const World& world, const Method&, const EstimatorSettings& settings) {
  return settings.again ? unfit_for_paths(world) : std::nullopt;
}

SolutionBasis basis_of(const Method&, const EstimatorSettings&) { return {}; }

Solution solve(const World&, const Method&, const EstimatorSettings&, const Progress&) { return nullptr; }

Crossing crossing_by_paths(const World& world, const RadianceSettings& radiance, int band,
                           const FluxRectangle& rectangle, std::size_t number, int paths) {
  PathSettings settings;
  settings.specular_depth = radiance.specular_depth;
  settings.scattering_depth = radiance.scattering_depth;
  settings.seed = radiance.seed;
  Crossing sum;
  for (int i = 0; i < world.interval_count(); ++i) {
    if (world.interval(i).band != band) continue;
    const PathFlux power = path_flux({world, i}, settings, rectangle, paths, number);
    const auto add = [](Measured& side, const BatchMean& here) {
      side.value += here.mean;
      side.error = std::hypot(side.error, here.standard_error);
    };
    add(sum.forward, power.forward);
    add(sum.backward, power.backward);
    sum.net_error = std::hypot(sum.net_error, std::hypot(power.forward.standard_error, power.backward.standard_error));
  }
  return sum;
}

Estimator by_paths(const World& world, const Method& method, const EstimatorSettings& settings, const Solution&) {
  RadianceSettings radiance = detail::radiance_settings(method, settings);
  // Where nothing goes on after its first scattering, the pass along the camera's rays is all there is.
  radiance.gather_bounces = settings.again ? kAllBounces : 0;
  Estimator estimator;
  detail::answer_by_rays(world, radiance, nullptr, estimator);
  estimator.crossing = [&world, radiance, rectangles = settings.rectangles](int band, std::size_t rectangle,
                                                                            int paths) -> std::optional<Crossing> {
    return crossing_by_paths(world, radiance, band, rectangles[rectangle], rectangle, paths);
  };
  estimator.what = fmt::format("{} paths a pixel", method.samples);
  return estimator;
}

}  // namespace

const MethodType kPathTracer{.word = "path",
                             .name = "path tracer",
                             .samples = true,
                             .unfit = unfit_paths,
                             .basis = basis_of,
                             .solve = solve,
                             .estimator = by_paths};

}  // namespace obscura
