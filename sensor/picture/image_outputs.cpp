#include "sensor/picture/image_outputs.h"

#include <fmt/format.h>

#include <algorithm>

#include "octree/base/error.h"

namespace obscura {
namespace {

std::filesystem::path file_of_band(const std::filesystem::path& file, const std::vector<std::string>& bands,
                                   std::size_t band) {
  if (band == 0) return file;
  return std::filesystem::path(file).replace_extension("." + bands[band] + file.extension().string());
}

}  // namespace

const OutputFormat* output_format_of(const ImageOutput& output, const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  for (const OutputFormat& format : output.formats) {
    if (std::ranges::find(format.extensions, extension) != format.extensions.end()) return &format;
  }
  return nullptr;
}

std::string extension_list(const ImageOutput& output) {
  std::string list;
  for (std::size_t i = 0; i < output.formats.size(); ++i) {
    const char* const separator = i == 0 ? "" : i + 1 < output.formats.size() ? ", " : " or ";
    list += separator + output.formats[i].extensions.front();
  }
  return list;
}

std::vector<std::filesystem::path> files_of(const ImageOutput& output, const std::filesystem::path& file,
                                            const std::vector<std::string>& bands) {
  std::vector<std::filesystem::path> files;
  const std::size_t count = output.one_file_per_band ? std::max<std::size_t>(1, bands.size()) : 1;
  for (std::size_t band = 0; band < count; ++band) {
    files.push_back(file_of_band(file, bands, band));
    if (output.second_file) files.push_back(output.second_file(files.back()));
  }
  return files;
}

void write_output(const ImageOutput& output, const std::filesystem::path& file, const Image& image,
                  const OutputChoice& choice) {
  const OutputFormat* const format = output_format_of(output, file);
  if (!format) {
    throw InputError(output.option, fmt::format("\"{}\" does not end in {}", file.string(), extension_list(output)),
                     "give a name that does");
  }
  if (!output.one_file_per_band) {
    format->write({.file = file, .image = image, .band = "", .choice = choice});
    return;
  }
  const std::vector<std::string> bands = band_names(image);
  for (std::size_t band = 0; band < bands.size(); ++band) {
    format->write({.file = file_of_band(file, bands, band), .image = image, .band = bands[band], .choice = choice});
  }
}

}  // namespace obscura
