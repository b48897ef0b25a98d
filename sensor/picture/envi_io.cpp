#include "sensor/picture/envi_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <ostream>
#include <vector>

#include "sensor/picture/whole_file_io.h"

namespace obscura {
namespace {

struct Wavelengths {
  double centre_um, width_um;
};

std::optional<Wavelengths> wavelengths_of(const Image& image, const std::string& band) {
  const auto number = [&](const char* name) -> const double* {
    const auto found = image.metadata.find("obscura:band." + band + name);
    return found == image.metadata.end() ? nullptr : std::get_if<double>(&found->second);
  };
  const double* const low = number(".um_min");
  const double* const high = number(".um_max");
  if (!low || !high) return {};
  return Wavelengths{0.5 * (*low + *high), *high - *low};
}

// Text inside braces; what would end it or its entry becomes a line below.
std::string entry(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return c == ',' || c == '{' || c == '}' || static_cast<unsigned char>(c) < ' '; }, '_');
  return text;
}

std::string header_text(const Image& image, const std::vector<std::string>& bands, const std::string& quantity) {
  std::vector<std::string> names, centres, widths;
  for (const std::string& band : bands) {
    names.push_back(entry(band + "." + quantity));
    if (const auto um = wavelengths_of(image, band)) {
      centres.push_back(fmt::format("{:.10g}", um->centre_um));
      widths.push_back(fmt::format("{:.10g}", um->width_um));
    }
  }
  std::string scene;
  if (const auto found = image.metadata.find("obscura:scene"); found != image.metadata.end()) {
    if (const auto* text = std::get_if<std::string>(&found->second); text && !text->empty())
      scene = ": " + entry(*text);
  }
  std::string text = "ENVI\n";
  text += fmt::format("description = {{Obscura, {}{}}}\n", quantity, scene);
  text += fmt::format("samples = {}\nlines = {}\nbands = {}\n", image.columns(), image.rows(), bands.size());
  text += "header offset = 0\nfile type = ENVI Standard\ndata type = 4\ninterleave = bsq\nbyte order = 0\n";
  text += fmt::format("data ignore value = {}\n", kEnviIgnore);
  text += fmt::format("band names = {{{}}}\n", fmt::join(names, ", "));
  if (!bands.empty() && centres.size() == bands.size()) {
    text += "wavelength units = Micrometers\n";
    text += fmt::format("wavelength = {{{}}}\n", fmt::join(centres, ", "));
    text += fmt::format("fwhm = {{{}}}\n", fmt::join(widths, ", "));
  }
  return text;
}

void write_plane(std::ostream& out, std::span<const float> values, std::span<const float> rays) {
  std::vector<char> bytes(4 * values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool known = std::isfinite(values[i]) && (rays.empty() || rays[i] > 0);
    const auto bits = std::bit_cast<std::uint32_t>(known ? values[i] : kEnviIgnore);
    for (std::size_t k = 0; k < 4; ++k) bytes[4 * i + k] = static_cast<char>(bits >> (8 * k) & 0xFFu);
  }
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

std::filesystem::path envi_data_file(const std::filesystem::path& header) {
  return std::filesystem::path(header).replace_extension(".img");
}

void write_envi(const std::filesystem::path& header, const Image& image, const std::string& quantity) {
  const std::vector<std::string> bands = band_names(image);
  if (bands.empty()) throw InputError("image", "has no band", "give one with channels <band>.radiance");
  std::vector<std::span<const float>> planes;
  for (const std::string& band : bands) planes.push_back(image.channel(band + "." + quantity));
  const std::span<const float> rays = image.has("rays.N") ? image.channel("rays.N") : std::span<const float>();
  write_whole_stream(envi_data_file(header), [&](std::ostream& out) {
    for (const auto plane : planes) write_plane(out, plane, rays);
  });
  const std::string text = header_text(image, bands, quantity);
  write_whole_stream(header, [&](std::ostream& out) { out << text; });
}

}  // namespace obscura
