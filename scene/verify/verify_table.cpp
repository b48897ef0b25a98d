// The verdict as text: a table for people, JSON for programs.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "scene/verify/verify.h"

namespace obscura {
namespace {

using Line = std::vector<std::string>;

std::string value_text(const std::optional<Measured>& m) {
  if (!m) return "-";
  if (m->value == 0) return "0";
  return fmt::format("{:.5g} {:.2f}%", m->value, 100 * m->error / std::abs(m->value));
}

std::string seconds_text(const VerifyMethod& method) {
  return method.refusal.empty() ? fmt::format("{:.1f}", method.seconds) : "-";
}

/// Of all pairs of a row: whether they agree, and how many of them could see that they do not.
std::string verdict(const VerifyRow& row, bool demanded) {
  std::size_t judged = 0;
  bool agree = true;
  double factor = std::numeric_limits<double>::infinity();
  for (const VerifyPair& pair : row.pairs) {
    judged += pair.agreement.judged();
    agree = agree && pair.agreement.agree;
    factor = std::min(factor, pair.agreement.samples_factor);
  }
  if (row.pairs.empty()) return "-";
  if (!agree) return "DIFFER";
  if (judged == row.pairs.size()) return "agree";
  if (demanded) return "TOO WEAK";
  if (judged > 0) return fmt::format("agree ({} of {} judged)", judged, row.pairs.size());
  return std::isfinite(factor) ? fmt::format("not judged: {:.2g} x samples", factor) : "not judged";
}

/// Columns as wide as their widest text; the first two to the left.
std::string lay_out(const std::vector<Line>& lines) {
  std::vector<std::size_t> widths;
  for (const Line& line : lines) {
    widths.resize(std::max(widths.size(), line.size()), 0);
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], line[c].size());
  }
  std::string text;
  for (const Line& line : lines) {
    std::string row;
    for (std::size_t c = 0; c < line.size(); ++c) {
      row += c < 2 ? fmt::format("{:<{}}  ", line[c], widths[c]) : fmt::format("{:>{}}  ", line[c], widths[c]);
    }
    row.erase(row.find_last_not_of(' ') + 1);
    text += row + "\n";
  }
  return text;
}

/// The pairs of methods in the columns' order.
std::vector<std::array<std::size_t, 2>> pairs_of(std::size_t methods) {
  std::vector<std::array<std::size_t, 2>> pairs;
  for (std::size_t a = 0; a < methods; ++a) {
    for (std::size_t b = a + 1; b < methods; ++b) pairs.push_back({a, b});
  }
  return pairs;
}

template <class List>
auto find_pair(const List& list, const std::array<std::size_t, 2>& pair) {
  return std::find_if(list.begin(), list.end(),
                      [&](const auto& entry) { return entry.first == pair[0] && entry.second == pair[1]; });
}

Line header() {
  const std::vector<std::string> words = method_words();
  Line line{"case", "quantity"};
  for (const std::string& word : words) line.push_back(word + " +-");
  for (const auto& [a, b] : pairs_of(words.size())) line.push_back(words[a] + "-" + words[b] + " z");
  line.insert(line.end(), {words.front() + " bias", "verdict"});
  return line;
}

void add_lines(const VerifiedScene& scene, std::vector<Line>& lines) {
  const auto quantity_name = [&](const std::string& quantity, const std::string& band) {
    return scene.bands.size() > 1 ? quantity + " " + band : quantity;
  };
  for (const VerifyRow& row : scene.rows) {
    Line line{scene.name, quantity_name(row.quantity, row.band)};
    for (const auto& m : row.measured) line.push_back(value_text(m));
    for (const auto& wanted : pairs_of(scene.methods.size())) {
      const auto pair = find_pair(row.pairs, wanted);
      if (pair == row.pairs.end()) {
        line.push_back("-");
        continue;
      }
      const Agreement& a = pair->agreement;
      line.push_back(fmt::format("{:+.2f}% {:+.1f}", 100 * a.relative, a.z));
    }
    const auto& photon = row.measured[0];
    line.push_back(photon && photon->value != 0 ? fmt::format("{:.2f}%", 100 * photon->bias / std::abs(photon->value))
                                                : "-");
    line.push_back(verdict(row, scene.demands_resolution));
    lines.push_back(std::move(line));
  }
  for (const std::string& band : scene.bands) {
    std::vector<VerifyPixels> of_band;
    std::copy_if(scene.pixels.begin(), scene.pixels.end(), std::back_inserter(of_band),
                 [&](const VerifyPixels& p) { return p.band == band; });
    Line line{scene.name, quantity_name("pixels: rms, z", band), "", "", ""};
    bool agree = true;
    for (const auto& wanted : pairs_of(scene.methods.size())) {
      const auto pair = find_pair(of_band, wanted);
      if (pair == of_band.end()) {
        line.push_back("-");
        continue;
      }
      line.push_back(fmt::format("{:.2f}% {:.2f}", 100 * pair->agreement.image_error, pair->agreement.rms_z));
      agree = agree && pair->agreement.agree;
    }
    line.push_back("");
    line.push_back(of_band.empty() ? "-" : agree ? "agree" : "DIFFER");
    lines.push_back(std::move(line));
  }
  Line seconds{scene.name, "seconds"};
  for (const VerifyMethod& method : scene.methods) seconds.push_back(seconds_text(method));
  lines.push_back(std::move(seconds));
}

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json json_of(const VerifiedScene& scene) {
  Json json;
  json["case"] = scene.name;
  json["agree"] = scene.failures().empty() && !scene.partial;
  json["failures"] = scene.failures();
  json["partial"] = scene.partial;
  json["resolution"] = scene.resolution;
  for (const VerifyMethod& m : scene.methods) {
    json["methods"][m.name] = {{"what", m.what}, {"seconds", number(m.seconds)}, {"refusal", m.refusal}};
  }
  json["quantities"] = Json::array();
  for (const VerifyRow& row : scene.rows) {
    Json entry = {{"quantity", row.quantity}, {"band", row.band}};
    for (std::size_t method = 0; method < row.measured.size(); ++method) {
      const auto& m = row.measured[method];
      entry[scene.methods[method].name] =
          m ? Json{{"value", number(m->value)}, {"error", number(m->error)}, {"bias", number(m->bias)}} : Json(nullptr);
    }
    entry["pairs"] = Json::array();
    for (const VerifyPair& pair : row.pairs) {
      const Agreement& a = pair.agreement;
      entry["pairs"].push_back({{"methods", {scene.methods[pair.first].name, scene.methods[pair.second].name}},
                                {"difference", number(a.difference)},
                                {"relative", number(a.relative)},
                                {"error", number(a.error)},
                                {"z", number(a.z)},
                                {"limit", number(a.limit)},
                                {"detectable", number(a.detectable)},
                                {"agree", a.agree},
                                {"sharp", a.sharp},
                                {"judged", a.judged()},
                                {"samples_factor", number(a.samples_factor)}});
    }
    json["quantities"].push_back(std::move(entry));
  }
  json["pixels"] = Json::array();
  for (const VerifyPixels& p : scene.pixels) {
    const PixelAgreement& a = p.agreement;
    json["pixels"].push_back({{"band", p.band},
                              {"methods", {scene.methods[p.first].name, scene.methods[p.second].name}},
                              {"image_error", number(a.image_error)},
                              {"rms_z", number(a.rms_z)},
                              {"rms_z_without_bias", number(a.z)},
                              {"limit", number(a.high)},
                              {"inside_95", number(a.inside)},
                              {"pixels", a.pixels},
                              {"agree", a.agree}});
  }
  return json;
}

}  // namespace

std::string verify_table(const std::vector<VerifiedScene>& scenes) {
  std::vector<Line> lines{header()};
  for (const VerifiedScene& scene : scenes) add_lines(scene, lines);
  std::string text = lay_out(lines);
  for (const VerifiedScene& scene : scenes) {
    for (const VerifyMethod& method : scene.methods) {
      if (!method.refusal.empty()) text += fmt::format("{}: without {}: {}\n", scene.name, method.name, method.refusal);
    }
    if (scene.partial) text += scene.name + ": stopped before the end, nothing compared\n";
  }
  for (const VerifiedScene& scene : scenes) {
    for (const std::string& sentence : scene.failures()) text += "DIFFER " + sentence + "\n";
  }
  return text;
}

std::string verify_json(const std::vector<VerifiedScene>& scenes) {
  Json json;
  bool agree = true;
  json["agree"] = agree;
  json["scenes"] = Json::array();
  for (const VerifiedScene& scene : scenes) {
    json["scenes"].push_back(json_of(scene));
    agree = agree && json["scenes"].back()["agree"].get<bool>();
  }
  json["agree"] = agree;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace obscura
