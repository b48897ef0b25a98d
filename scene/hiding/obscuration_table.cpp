// What clouds hide as text: a table for people, JSON for programs, CSV for spreadsheets.
#include "scene/hiding/obscuration_table.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "scene/hiding/obscuration.h"

namespace obscura {
namespace {

using Json = nlohmann::ordered_json;

std::string threshold(double value) { return fmt::format("{:.4g}", value); }

Json json_of(const std::optional<Confident>& c) {
  if (!c) return nullptr;
  return {{"value", c->value}, {"low", c->low}, {"high", c->high}};
}

Json json_of(const SightContrast& c, bool nedt) {
  Json json = {{"object_radiance", json_of(c.object)},    {"surroundings_radiance", json_of(c.surroundings)},
               {"difference", json_of(c.difference)},     {"relative_contrast", json_of(c.relative)},
               {"object_K", json_of(c.object_K)},         {"surroundings_K", json_of(c.surroundings_K)},
               {"difference_K", json_of(c.difference_K)}, {"share_below_contrast", json_of(c.lost_contrast)}};
  if (nedt) json["share_below_nedt"] = json_of(c.lost_K);
  json["pixel_error"] = c.pixel_error;
  json["difference_bias"] = c.difference_bias;
  return json;
}

Json json_of(const ObjectObscuration& object, const ObscurationSettings& thresholds) {
  Json json = {{"object", object.name},
               {"pixels", object.mask.area()},
               {"pixels_whole", object.mask.interior()},
               {"ring_px", object.mask.width},
               {"ring_pixels", object.mask.ring_size()},
               {"lines_of_sight_per_pixel", object.lines_per_pixel},
               {"notes", object.notes}};
  for (const BandObscuration& band : object.bands) {
    Json transmission = {
        {"mean", json_of(band.transmission)}, {"min", band.transmission_min}, {"max", band.transmission_max}};
    for (const auto& [per_cent, value] : band.percentiles)
      transmission[fmt::format("p{:g}", per_cent)] = json_of(value);
    json["bands"][band.band] = {{"transmission", transmission},
                                {"share_obscured", json_of(band.obscured)},
                                {"with", json_of(band.with, thresholds.difference_K.has_value())},
                                {"without", json_of(band.without, thresholds.difference_K.has_value())},
                                {"difference_ratio", json_of(band.difference_ratio)},
                                {"relative_contrast_ratio", json_of(band.relative_ratio)},
                                {"difference_K_ratio", json_of(band.difference_K_ratio)},
                                {"notes", band.notes}};
  }
  return json;
}

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? std::string("\"\"") : std::string(1, c);
  return result + "\"";
}

}  // namespace

namespace detail {

std::vector<ObscurationRow> obscuration_rows(const BandObscuration& band, const ObscurationSettings& thresholds) {
  const std::string unit = band.grey ? "" : "W/m2/sr";
  std::vector<ObscurationRow> rows;
  const auto exact = [](double value) { return Confident{value, NAN, NAN}; };
  rows.push_back({"transmission, mean", "", band.transmission, std::nullopt, std::nullopt});
  rows.push_back({"transmission, least seen", "", exact(band.transmission_min), std::nullopt, std::nullopt});
  for (const auto& [per_cent, value] : band.percentiles) {
    rows.push_back({fmt::format("transmission, {:g} % are below", per_cent), "", value, std::nullopt, std::nullopt});
  }
  rows.push_back({"transmission, most seen", "", exact(band.transmission_max), std::nullopt, std::nullopt});
  std::string obscured = "share with transmission <= ";
  obscured += threshold(thresholds.transmission);
  rows.push_back({obscured, "", band.obscured, std::nullopt, std::nullopt});

  rows.push_back({"radiance of the object", unit, band.with.object, band.without.object, std::nullopt});
  rows.push_back(
      {"radiance of its surroundings", unit, band.with.surroundings, band.without.surroundings, std::nullopt});
  rows.push_back(
      {"difference of radiance", unit, band.with.difference, band.without.difference, band.difference_ratio});
  rows.push_back({"relative contrast", "", band.with.relative, band.without.relative, band.relative_ratio});
  std::string contrast = "share with relative contrast < ";
  contrast += threshold(thresholds.contrast);
  rows.push_back({contrast, "", band.with.lost_contrast, band.without.lost_contrast, std::nullopt});
  if (!band.grey) {
    rows.push_back(
        {"apparent temperature of the object", "K", band.with.object_K, band.without.object_K, std::nullopt});
    rows.push_back({"apparent temperature of its surroundings", "K", band.with.surroundings_K,
                    band.without.surroundings_K, std::nullopt});
    rows.push_back({"difference of apparent temperature", "K", band.with.difference_K, band.without.difference_K,
                    band.difference_K_ratio});
    if (thresholds.difference_K) {
      std::string lost = "share with less than ";
      lost += threshold(*thresholds.difference_K) + " K of difference";
      rows.push_back({lost, "", band.with.lost_K, band.without.lost_K, std::nullopt});
    }
  }
  return rows;
}

std::string confident_text(const std::optional<Confident>& c) {
  if (!c) return "-";
  const double half = 0.5 * (c->high - c->low);
  if (!std::isfinite(half)) return fmt::format("{:.4g}", c->value);
  // As many digits as the interval lets one believe and one more, six at most.
  const double size = std::max(std::abs(c->value), half);
  int digits = 6;
  if (half > 0)
    digits = std::clamp(2 + static_cast<int>(std::floor(std::log10(size)) - std::floor(std::log10(half))), 2, 6);
  const auto text = [&](double value) {
    return std::abs(value) < 1e-12 * size ? std::string("0") : fmt::format("{:.{}g}", value, digits);
  };
  const std::string value = text(c->value), low = text(c->low), high = text(c->high);
  if (value == low && value == high) return value;
  return fmt::format("{} [{}, {}]", value, low, high);
}

std::string object_text(const ObjectObscuration& object) {
  return fmt::format(
      "{:.4g} pixels, {} of them whole; surroundings: {} pixels within {} of it; {} lines of sight a pixel",
      object.mask.area(), object.mask.interior(), object.mask.ring_size(), object.mask.width, object.lines_per_pixel);
}

}  // namespace detail

std::string obscuration_table(const Obscuration& obscuration) {
  std::string text;
  for (const ObjectObscuration& object : obscuration.objects) {
    if (!text.empty()) text += "\n";
    text += fmt::format("{}: {}\n", object.name, detail::object_text(object));
    for (const BandObscuration& band : object.bands) {
      std::vector<std::array<std::string, 4>> lines = {{band.band, "with cloud", "without", "with / without"}};
      for (const auto& row : detail::obscuration_rows(band, obscuration.wish.thresholds)) {
        std::string name = row.quantity;
        if (!row.unit.empty()) name += " [" + row.unit + "]";
        lines.push_back({name, detail::confident_text(row.with), row.without ? detail::confident_text(row.without) : "",
                         row.ratio ? detail::confident_text(row.ratio) : ""});
      }
      std::array<std::size_t, 4> widths{};
      for (const auto& line : lines) {
        for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], line[c].size());
      }
      for (const auto& line : lines) {
        std::string row;
        for (std::size_t c = 0; c < line.size(); ++c) row += fmt::format("{:<{}}  ", line[c], widths[c]);
        row.erase(row.find_last_not_of(' ') + 1);
        text += "  " + row + "\n";
      }
      for (const std::string& note : band.notes) text += "  note: " + note + "\n";
    }
    for (const std::string& note : object.notes) text += "  note: " + note + "\n";
  }
  for (const std::string& name : obscuration.left_out) text += "left out: " + name + "\n";
  text += fmt::format("value [95 % interval] from {} replicas{}\n", obscuration.replicas,
                      obscuration.partial ? "; stopped before the end" : "");
  return text;
}

std::string obscuration_json(const Obscuration& obscuration) {
  const ObscurationSettings& thresholds = obscuration.wish.thresholds;
  Json json = {{"version", OBSCURA_VERSION},
               {"scene", obscuration.scene},
               {"hash", obscuration.hash},
               {"seed", obscuration.seed},
               {"time_s", obscuration.time_s},
               {"replicas", obscuration.replicas},
               {"confidence", 0.95},
               {"thresholds",
                {{"transmission", thresholds.transmission},
                 {"contrast", thresholds.contrast},
                 {"nedt_K", thresholds.difference_K ? Json(*thresholds.difference_K) : Json(nullptr)}}}};
  json["objects"] = Json::array();
  for (const ObjectObscuration& object : obscuration.objects) json["objects"].push_back(json_of(object, thresholds));
  json["left_out"] = obscuration.left_out;
  json["warnings"] = obscuration.warnings;
  json["partial"] = obscuration.partial;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

std::string obscuration_csv(const Obscuration& obscuration) {
  std::string text = "object,band,quantity,unit,case,value,low,high\n";
  for (const ObjectObscuration& object : obscuration.objects) {
    for (const BandObscuration& band : object.bands) {
      for (const auto& row : detail::obscuration_rows(band, obscuration.wish.thresholds)) {
        const auto add = [&](const char* which, const char* unit, const std::optional<Confident>& c) {
          if (!c) return;
          const auto number = [](double value) {
            return std::isfinite(value) ? fmt::format("{}", value) : std::string();
          };
          text += fmt::format("{},{},{},{},{},{},{},{}\n", quoted(object.name), quoted(band.band), quoted(row.quantity),
                              unit, which, number(c->value), number(c->low), number(c->high));
        };
        add("with", row.unit.c_str(), row.with);
        add("without", row.unit.c_str(), row.without);
        add("ratio", "", row.ratio);
      }
    }
  }
  return text;
}

}  // namespace obscura
