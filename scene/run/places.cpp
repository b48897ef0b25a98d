#include "scene/run/places.h"

#include <cmath>

namespace obscura {
namespace {

/// Directions of a probe's fluence.
constexpr int kProbeDirections = 8192;
/// Paths a side of a flux rectangle.
constexpr int kFluxPaths = 65536;

/// @param crossing of a rectangle in a band
template <class Crossings>
std::vector<FluxReport> reports_of(Session& session, const Crossings& crossing) {
  std::vector<FluxReport> reports;
  for (std::size_t r = 0; r < session.scene().flux.size(); ++r) {
    FluxReport report{session.scene().flux[r].name, {}};
    for (int band = 0; band < static_cast<int>(session.world().bands().size()); ++band) {
      const std::optional<Crossing> power = crossing(band, r);
      if (!power) return {};
      report.bands.push_back({session.world().bands()[static_cast<std::size_t>(band)].name(),
                              {power->forward.value, power->backward.value, power->net_error}});
    }
    reports.push_back(std::move(report));
  }
  return reports;
}

}  // namespace

std::vector<ProbeReport> probe(Session& session, const Method& method, const Estimator& estimator) {
  std::vector<ProbeReport> reports;
  for (const ProbeDescription& description : session.scene().probes) {
    ProbeReport& report = reports.emplace_back();
    report.name = description.name;
    const std::uint64_t history = reports.size() - 1;
    for (int band = 0; band < static_cast<int>(session.world().bands().size()); ++band) {
      const Measured here = estimator.fluence(band, description.position_m, kProbeDirections, history);
      report.bands.push_back({session.world().bands()[static_cast<std::size_t>(band)].name(),
                              {here.value, method.type->cells ? std::hypot(here.error, here.bias) : here.error}});
    }
  }
  return reports;
}

std::vector<FluxReport> fluxes(Session& session, const Estimator& estimator) {
  return reports_of(session,
                    [&](int band, std::size_t rectangle) { return estimator.crossing(band, rectangle, kFluxPaths); });
}

std::vector<FluxReport> fluxes(Session& session, const Light& light) {
  return reports_of(session, [&](int band, std::size_t rectangle) -> std::optional<Crossing> {
    return crossing_of(light.bands[static_cast<std::size_t>(band)].flux[rectangle]);
  });
}

}  // namespace obscura
