// Discrete ordinates as a method: deterministic, with an error of its own from two grids and two orders.
#include <fmt/format.h>

#include <algorithm>

#include "photon/methods/method.h"
#include "photon/ordinates/ordinates_referee.h"

namespace obscura {
namespace {

using Solved = std::vector<OrdinatesReferee>;  // one per interval; fewer where it was cancelled

std::optional<NumericalError> unfit_ordinates(const World& world, const Method&, const EstimatorSettings&) {
  for (int i = 0; i < world.interval_count(); ++i) {
    if (auto refusal = unfit_for_ordinates({world, i})) return refusal;
  }
  return std::nullopt;
}

SolutionBasis basis_of(const Method& method, const EstimatorSettings&) {
  SolutionBasis basis;
  basis.method.type = &kOrdinates;
  basis.method.cells = method.cells;
  basis.method.order = method.order;
  return basis;
}

Solution solve(const World& world, const Method& method, const EstimatorSettings&, const Progress& progress) {
  OrdinatesSettings settings;
  settings.cells = ordinates_cells(world, method.cells);
  settings.order = method.order;
  auto solved = std::make_shared<Solved>();
  const auto intervals = static_cast<std::uint64_t>(world.interval_count());
  for (int i = 0; i < world.interval_count() && !progress.cancelled(); ++i) {
    solved->emplace_back(SpectralWorld(world, i), settings,
                         progress.part("ordinates", static_cast<std::uint64_t>(i), intervals));
  }
  return solved;
}

RadianceCounts radiance(const Solved& solved, int interval, std::span<const Ray> rays, std::span<Incoming> incoming) {
  RadianceCounts counts;
  counts.rays = rays.size();
  const auto i = static_cast<std::size_t>(interval);
  if (i >= solved.size()) {
    std::ranges::fill(incoming, Incoming());
    return counts;
  }
  std::vector<OrdinatesEstimate> estimates(rays.size());
  solved[i].radiance(rays, estimates, incoming);
  for (std::size_t r = 0; r < rays.size(); ++r) {
    incoming[r].direct = estimates[r].value;
    incoming[r].bias = estimates[r].error;
  }
  return counts;
}

std::string what(const Solved& solved, int order) {
  if (solved.empty()) return {};
  const Vec3i& cells = solved.front().finest().grid().cells();
  int sweeps = 0;
  for (const OrdinatesReferee& interval : solved) sweeps = std::max(sweeps, interval.finest().iterations());
  return fmt::format("{} x {} x {} cells, S{}, {} sweeps, and half of both", cells.x, cells.y, cells.z, order, sweeps);
}

Estimator by_ordinates(const World& world, const Method& method, const EstimatorSettings&, const Solution& solution) {
  auto solved = std::static_pointer_cast<const Solved>(solution);
  Estimator estimator;
  estimator.radiance = [solved](int interval, const RayShare&, std::span<const Ray> rays,
                                std::span<const std::uint64_t>,
                                std::span<Incoming> incoming) { return radiance(*solved, interval, rays, incoming); };
  estimator.fluence = [solved, &world](int band, const Vec3d& point, int, std::uint64_t) {
    Measured sum;
    for (std::size_t i = 0; i < solved->size(); ++i) {
      if (world.interval(static_cast<int>(i)).band != band) continue;
      const OrdinatesEstimate here = (*solved)[i].fluence_at(point);
      sum.value += here.value;
      sum.bias += here.error;
    }
    return sum;
  };
  estimator.crossing = [](int, std::size_t, int) { return std::optional<Crossing>(); };
  for (const OrdinatesReferee& interval : *solved)
    estimator.bytes = std::max(estimator.bytes, solver_bytes(interval.finest()));
  estimator.what = what(*solved, method.order);
  return estimator;
}

}  // namespace

const MethodType kOrdinates{.word = "ordinates",
                            .name = "ordinates",
                            .cells = true,
                            .unfit = unfit_ordinates,
                            .basis = basis_of,
                            .solve = solve,
                            .estimator = by_ordinates};

}  // namespace obscura
