// A study as text: the table of settings to use, and its numbers for programs and spreadsheets.
#include "scene/study/study_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

namespace obscura {

using namespace detail;

namespace {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json stage_json(const StudySeconds::Stage& stage) { return {{"cpu", number(stage.cpu)}, {"wall", number(stage.wall)}}; }

Json seconds_json(const StudySeconds& s) {
  return {{"cpu", number(s.cpu())},
          {"wall", number(s.wall())},
          {"world", stage_json(s.world)},
          {"map", stage_json(s.map)},
          {"image", stage_json(s.image)}};
}

Json memory_json(const StudyBytes& b) {
  return {{"octree", b.octree}, {"map", b.map}, {"film", b.film}, {"total", b.total()}};
}

Json settings_json(const Study& study, const StudySetting& setting) {
  Json settings = Json::object();
  for (const auto& [pointer, value] : scene_edits(setting, study.grey)) settings[pointer] = Json::parse(value);
  return settings;
}

Json run_json(const Study& study, std::size_t index) {
  const StudyRun& run = study.runs[index];
  const StudySetting& s = run.setting;
  Json json = {{"run", index}, {"method", s.method.type->name}, {"label", study_label(s)}, {"purpose", run.purpose}};
  json["varies"] = run.base >= 0 ? Json(run.base) : Json(nullptr);
  json["settings"] = settings_json(study, s);
  if (!renders(s.method.type)) {
    json["ordinates"] = {{"cells", s.method.cells},
                         {"order", s.method.order},
                         {"rays", s.rays},
                         {"octree_tolerance", s.octree_tolerance},
                         {"intervals", s.intervals}};
  }
  json["seconds"] = seconds_json(run.seconds);
  json["seconds_full"] = seconds_json(run.full);
  json["memory_bytes"] = memory_json(run.bytes);
  json["memory_bytes_full"] = memory_json(run.full_bytes);
  json["peak_MiB"] = run.peak_MiB;
  const bool known = study.reference.picture.known();
  const auto error = [&](const char* name, const RootError& root) {
    json[name] = known ? number(root.value()) : Json(nullptr);
    json[std::string(name) + "_bar"] = known ? number(root.error()) : Json(nullptr);
  };
  error("error", run.error.error);
  error("bias", run.error.bias);
  error("noise", run.error.noise);
  json["band"] = known ? Json(study.bands[run.error.band]) : Json(nullptr);
  return json;
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? "\"\"" : std::string(1, c);
  return result + "\"";
}

/// One line for each target: target, setting, error, CPU, wall, memory, all of the whole picture.
std::vector<std::array<std::string, 6>> target_rows(const Study& study) {
  std::vector<std::array<std::string, 6>> rows;
  for (const StudyTarget& target : study.targets) {
    if (target.run < 0) {
      const bool told = !rows.empty() && rows.back()[2].empty();
      rows.push_back(
          {target_text(target.error), told ? std::string("not reached") : not_reached_text(study), "", "", "", ""});
      continue;
    }
    const StudyRun& run = study.runs[static_cast<std::size_t>(target.run)];
    rows.push_back({target_text(target.error), study_label(run.setting), percent_text(run.error.error),
                    seconds_text(run.full.cpu()), seconds_text(run.full.wall()), memory_text(run.full_bytes.total())});
  }
  return rows;
}

}  // namespace

namespace detail {

std::string percent_text(const RootError& error) {
  if (error.value() <= error.error()) return fmt::format("< {:.2g} %", 100 * (error.value() + error.error()));
  const int digits =
      std::clamp(1 - static_cast<int>(std::floor(std::log10(std::max(100 * error.error(), 1e-6)))), 0, 4);
  return fmt::format("{:.{}f} +- {:.{}f} %", 100 * error.value(), digits, 100 * error.error(), digits);
}

std::string seconds_text(double seconds) {
  if (!(seconds > 0)) return "0 s";
  const int digits = std::clamp(2 - static_cast<int>(std::floor(std::log10(seconds))), 0, 4);
  return fmt::format("{:.{}f} s", seconds, digits);
}

std::string memory_text(double bytes) { return fmt::format("{:.3g} MiB", bytes / 1048576); }

std::string target_text(double target) { return fmt::format("{:.4g} %", 100 * target); }

std::string reference_text(const Study& study) {
  return fmt::format("{}: {}; its own error {}", study.reference.method, study.reference.what,
                     study.reference.picture.known() ? fmt::format("{:.3g} %", 100 * study.reference.error.value())
                                                     : std::string("is not known"));
}

std::string not_reached_text(const Study& study) {
  const StudyRun* best = nullptr;
  for (const StudyRun& run : study.runs) {
    const auto high = [](const StudyRun& r) { return r.error.error.value() + r.error.error.error(); };
    if (renders(run.setting.method.type) && (!best || high(run) < high(*best))) best = &run;
  }
  if (!best || !study.reference.picture.known()) return "not reached: nothing was measured";
  return fmt::format("not reached: best was {} by {}", percent_text(best->error.error), study_label(best->setting));
}

std::string command_text(const Study& study, const StudyRun& run) {
  std::string text;
  for (const auto& [pointer, value] : scene_edits(run.setting, study.grey)) {
    std::string plain = value;
    plain.erase(std::remove(plain.begin(), plain.end(), '"'), plain.end());
    if (!text.empty()) text += ' ';
    text += fmt::format("--set {}={}", pointer, plain);
  }
  return text;
}

}  // namespace detail

std::string study_table(const Study& study) {
  std::string text =
      fmt::format("{}: {} x {} pixels for {} x {}\nreference: {}\n",
                  study.scene.empty() ? "scene " + study.hash : study.scene, study.resolution[0], study.resolution[1],
                  study.full_resolution[0], study.full_resolution[1], reference_text(study));
  std::vector<std::array<std::string, 6>> lines = {
      {"target", "cheapest setting measured to reach it", "error", "CPU", "wall", "memory"}};
  for (auto& row : target_rows(study)) lines.push_back(std::move(row));
  if (study.as_given >= 0) {
    const StudyRun& run = study.runs[static_cast<std::size_t>(study.as_given)];
    lines.push_back({"as given", study_label(run.setting), percent_text(run.error.error), seconds_text(run.full.cpu()),
                     seconds_text(run.full.wall()), memory_text(run.full_bytes.total())});
  }
  std::array<std::size_t, 6> widths{};
  for (const auto& line : lines) {
    for (std::size_t c = 0; c < line.size(); ++c) {
      if (c != 1 || !line[2].empty()) widths[c] = std::max(widths[c], line[c].size());
    }
  }
  for (const auto& line : lines) {
    std::string row;
    for (std::size_t c = 0; c < line.size(); ++c)
      row += c < 2 ? fmt::format("{:<{}}  ", line[c], widths[c]) : fmt::format("{:>{}}  ", line[c], widths[c]);
    row.erase(row.find_last_not_of(' ') + 1);
    text += row + "\n";
  }
  text += fmt::format(
      "times and memory: predicted for {} x {}, World and map included, {} thread{}; {} settings measured in {:.0f} "
      "s\n",
      study.full_resolution[0], study.full_resolution[1], study.threads, study.threads == 1 ? "" : "s",
      study.runs.size(), study.spent_s);
  for (const auto& [method, why] : study.refusals) text += fmt::format("without {}: {}\n", method->name, why);
  for (const std::string& what : study.left_out) text += fmt::format("left out: {}\n", what);
  if (study.partial) text += "stopped before the end\n";
  return text;
}

std::string study_markdown(const Study& study) {
  std::string text =
      "| error | cheapest setting measured to reach it | measured error | CPU | wall | memory "
      "|\n|---:|---|---:|---:|---:|---:|\n";
  for (const auto& row : target_rows(study)) {
    text += '|';
    for (const std::string& cell : row) {
      std::string shown = cell;
      if (const auto at = shown.find("+-"); at != std::string::npos) shown.replace(at, 2, "&plusmn;");
      text += fmt::format(" {} |", shown);
    }
    text += '\n';
  }
  text += fmt::format(
      "\nTimes and memory are predicted for {} x {} pixels on {} thread{} from {} settings at {} x {}, World and "
      "photon map included. Reference: {}.\n",
      study.full_resolution[0], study.full_resolution[1], study.threads, study.threads == 1 ? "" : "s",
      study.runs.size(), study.resolution[0], study.resolution[1], reference_text(study));
  for (const auto& [method, why] : study.refusals) text += fmt::format("Without {}: {}.\n", method->name, why);
  return text;
}

std::string study_csv(const Study& study) {
  std::string text =
      "run,method,purpose,varies,photons,nearest,kernel,samples,rays,octree_tolerance,intervals,cells,order,cpu_s,wall_"
      "s,cpu_world_s,cpu_map_s,cpu_image_s,"
      "full_cpu_s,full_wall_s,memory_bytes,full_memory_bytes,peak_MiB,error,error_bar,bias,bias_bar,noise,noise_bar,"
      "label\n";
  const bool known = study.reference.picture.known();
  for (std::size_t r = 0; r < study.runs.size(); ++r) {
    const StudyRun& run = study.runs[r];
    const StudySetting& s = run.setting;
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}", r, s.method.type->name,
                        quoted(run.purpose), run.base >= 0 ? std::to_string(run.base) : std::string(), s.method.photons,
                        s.method.nearest, name_of(s.method.kernel), s.method.samples, s.rays, s.octree_tolerance,
                        s.intervals, s.method.cells, s.method.order, run.seconds.cpu(), run.seconds.wall(),
                        run.seconds.world.cpu, run.seconds.map.cpu, run.seconds.image.cpu, run.full.cpu(),
                        run.full.wall(), run.bytes.total(), run.full_bytes.total(), run.peak_MiB);
    for (const RootError* root : {&run.error.error, &run.error.bias, &run.error.noise}) {
      text += known ? fmt::format(",{},{}", root->value(), root->error()) : std::string(",,");
    }
    text += "," + quoted(study_label(s)) + "\n";
  }
  return text;
}

std::string study_json(const Study& study) {
  Json json = {
      {"version", OBSCURA_VERSION}, {"scene", study.scene},           {"hash", study.hash},
      {"threads", study.threads},   {"resolution", study.resolution}, {"full_resolution", study.full_resolution},
      {"budget_s", study.budget_s}, {"spent_s", study.spent_s}};
  const bool known = study.reference.picture.known();
  json["reference"] = {{"method", study.reference.method},
                       {"what", study.reference.what},
                       {"error", known ? number(study.reference.error.value()) : Json(nullptr)},
                       {"error_bar", known ? number(study.reference.error.error()) : Json(nullptr)},
                       {"seconds", stage_json(study.reference.seconds)}};
  json["runs"] = Json::array();
  for (std::size_t r = 0; r < study.runs.size(); ++r) json["runs"].push_back(run_json(study, r));
  json["as_given"] = study.as_given >= 0 ? Json(study.as_given) : Json(nullptr);
  json["best"] = Json::array();
  for (const StudyTarget& target : study.targets) {
    Json best = {{"target", target.error}, {"reached", target.run >= 0}};
    if (target.run >= 0) {
      const StudyRun& run = study.runs[static_cast<std::size_t>(target.run)];
      best["run"] = target.run;
      best["method"] = run.setting.method.type->name;
      best["settings"] = settings_json(study, run.setting);
      best["error"] = number(run.error.error.value());
      best["error_bar"] = number(run.error.error.error());
      best["seconds_full"] = seconds_json(run.full);
    }
    best["per_method"] = Json::object();
    for (const MethodType* method : methods()) {
      const int run = target.per_method[index_of(*method)];
      best["per_method"][method->name] = run >= 0 ? Json(run) : Json(nullptr);
    }
    json["best"].push_back(std::move(best));
  }
  json["front"] = study.front;
  json["slopes"] = Json::array();
  for (const StudySlope& slope : study.slopes) {
    json["slopes"].push_back({{"method", slope.method->name},
                              {"what", slope.what},
                              {"exponent", number(slope.law.exponent)},
                              {"exponent_error", number(slope.law.exponent_error)},
                              {"points", slope.law.points}});
  }
  json["refusals"] = Json::array();
  for (const auto& [method, why] : study.refusals)
    json["refusals"].push_back({{"method", method->name}, {"reason", why}});
  json["left_out"] = study.left_out;
  json["warnings"] = study.warnings;
  json["partial"] = study.partial;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace obscura
