#include "scene/run/report.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace obscura {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json plan_rows(const std::vector<PlanRow>& plan) {
  Json rows = Json::array();
  for (const PlanRow& row : plan) {
    rows.push_back({{"effect", row.effect},
                    {"on", row.on},
                    {"reason", row.reason},
                    {"bound", row.bound ? number(*row.bound) : Json(nullptr)},
                    {"cost_s", row.cost_s ? number(*row.cost_s) : Json(nullptr)}});
  }
  return rows;
}

template <class T>
Json members(const std::vector<std::pair<std::string, T>>& pairs) {
  Json result = Json::object();
  for (const auto& [name, value] : pairs) {
    if constexpr (std::is_floating_point_v<T>) {
      result[name] = number(value);
    } else {
      result[name] = value;
    }
  }
  return result;
}

Json optional_number(const std::optional<double>& value) { return value ? number(*value) : Json(nullptr); }

Json accuracy_of(const AccuracyReport& a) {
  Json trials = Json::array();
  for (const TrialReport& trial : a.trials) {
    trials.push_back({{"settings", trial.settings},
                      {"seconds", number(trial.seconds)},
                      {"predicted_s", number(trial.predicted_s)},
                      {"predicted_error", number(trial.predicted_error)}});
  }
  return {{"target_error", optional_number(a.target_error)},
          {"time_limit_s", optional_number(a.time_limit_s)},
          {"unit", a.unit},
          {"error", number(a.error)},
          {"interval_95", {number(a.interval[0]), number(a.interval[1])}},
          {"noise", number(a.noise)},
          {"bias", number(a.bias)},
          {"dropped", number(a.dropped)},
          {"reached", a.reached},
          {"ended", a.ended},
          {"method", a.method},
          {"photons", a.photons},
          {"samples", a.samples},
          {"passes", a.passes},
          {"trials", std::move(trials)}};
}

// Text that is not UTF-8 (a file name) must not lose the report.
std::string text_of(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n'; }

}  // namespace

std::string to_json(const std::vector<PlanRow>& plan) {
  Json json;
  json["plan"] = plan_rows(plan);
  return text_of(json);
}

std::string to_json(const Report& report) {
  Json json;
  json["version"] = report.version;
  json["scene"] = report.scene;
  json["hash"] = report.hash;
  json["seed"] = report.seed;
  json["plan"] = plan_rows(report.plan);
  json["budget"] = {{"total", number(report.budget.total)},
                    {"dropped", number(report.budget.dropped)},
                    {"sampled", number(report.budget.sampled)}};
  json["method"] = {{"used", report.method.used}, {"cheaper", report.method.cheaper}, {"reason", report.method.reason}};
  json["energy"] = Json::object();
  for (const auto& [band, e] : report.energy) {
    json["energy"][band] = {{"emitted_W", number(e.emitted_W)},
                            {"absorbed_W", number(e.absorbed_W)},
                            {"surface_W", number(e.surface_W)},
                            {"escaped_W", number(e.escaped_W)},
                            {"truncated_W", number(e.truncated_W)},
                            {"errors_W",
                             {{"emitted_W", number(e.errors_W[0])},
                              {"absorbed_W", number(e.errors_W[1])},
                              {"surface_W", number(e.errors_W[2])},
                              {"escaped_W", number(e.errors_W[3])},
                              {"truncated_W", number(e.errors_W[4])}}}};
  }
  json["photons"] = {
      {"emitted", report.photons.emitted}, {"stored", report.photons.stored}, {"bytes", report.photons.bytes}};
  json["octree"] = Json::array();
  for (const OctreeReport& o : report.octree) {
    json["octree"].push_back({{"name", o.name},
                              {"leaves", o.leaves},
                              {"bytes", o.bytes},
                              {"bytes_dense", o.bytes_dense},
                              {"tolerance", number(o.tolerance)},
                              {"error_measured", number(o.error_measured)},
                              {"error_bound", number(o.error_bound)}});
  }
  json["footprint"] = {{"rays", report.footprint.rays},
                       {"segments", report.footprint.segments},
                       {"coarse_cells", report.footprint.coarse_cells},
                       {"voxels", number(report.footprint.voxels)},
                       {"error_bound", number(report.footprint.error_bound)}};
  if (report.accuracy) json["accuracy"] = accuracy_of(*report.accuracy);
  json["memory"] = {{"peak_MiB", number(report.peak_MiB)}};
  json["time_s"] = members(report.time_s);
  json["rays"] = members(report.rays);
  json["work"] = members(report.work);
  json["anomalies"] = members(report.anomalies);
  json["probes"] = Json::array();
  for (const ProbeReport& probe : report.probes) {
    Json entry = {{"name", probe.name}};
    for (const auto& [band, value] : probe.bands) {
      entry[band] = {{"fluence", number(value.fluence)}, {"error", number(value.error)}};
    }
    json["probes"].push_back(std::move(entry));
  }
  json["flux"] = Json::array();
  for (const FluxReport& flux : report.flux) {
    Json entry = {{"name", flux.name}};
    for (const auto& [band, value] : flux.bands) {
      entry[band] = {
          {"forward", number(value.forward)}, {"backward", number(value.backward)}, {"error", number(value.error)}};
    }
    json["flux"].push_back(std::move(entry));
  }
  for (const auto& [band, d] : report.detector) {
    json["detector"][band] = {{"dead", d.dead}, {"above_range", d.above_range}, {"below_range", d.below_range}};
  }
  json["warnings"] = report.warnings;
  json["partial"] = report.partial;
  return text_of(json);
}

}  // namespace obscura
