// obscura export, and the same outputs for obscura render.
#include "exports.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "sensor/picture/csv_io.h"
#include "sensor/picture/envi_io.h"
#include "sensor/picture/image_io.h"

namespace obscura::cli {
namespace {

std::array<int, 4> four(const std::vector<int>& numbers) { return {numbers[0], numbers[1], numbers[2], numbers[3]}; }

std::vector<PixelPlace> places_of(const Exports& e, const std::array<int, 2>& resolution) {
  const auto [columns, rows] = resolution;
  if (!e.line.empty()) return pixels_on_line(columns, rows, four(e.line));
  return pixels_in_region(columns, rows, e.region.empty() ? std::array<int, 4>{0, 0, columns, rows} : four(e.region));
}

void check_places(const Exports& e, const ExportSource& source, std::vector<Problem>& problems) {
  const char* const option = e.line.empty() ? "--region" : "--line";
  if (e.csv.empty()) {
    if (!e.region.empty() || !e.line.empty()) {
      problems.push_back({option, "it says which pixels --csv gets", "give --csv FILE.csv"});
    }
    return;
  }
  if (!e.region.empty() && !e.line.empty()) {
    problems.push_back({"--line", "--region and --line are both given", "give one of them"});
    return;
  }
  try {
    places_of(e, source.resolution);
  } catch (const InputError& error) {
    problems.push_back({option, error.problems().front().problem, error.problems().front().hint});
  }
}

bool has_one_of(const std::string& file, const std::vector<std::string>& extensions) {
  return std::ranges::find(extensions, std::filesystem::path(file).extension().string()) != extensions.end();
}

int export_image(const std::string& file, const Exports& e, bool force, bool quiet) {
  std::vector<Problem> problems;
  if (e.envi.empty() && e.counts.empty() && e.csv.empty()) {
    problems.push_back({"export", "nothing is asked for", "give --envi, --counts or --csv"});
  }
  const Image image = read_image(file);
  ExportSource source;
  source.bands = band_names(image);
  source.resolution = {image.columns(), image.rows()};
  source.has_counts = !source.bands.empty() && image.has(source.bands.front() + ".counts");
  source.no_counts = "render it with \"bits\" in the scene's sensor/detector";
  if (source.bands.empty() && !(e.envi.empty() && e.counts.empty())) {
    problems.push_back({file, "it has no band: no channel ends in .radiance", "give an image that obscura rendered"});
  }
  const std::vector<Output> outputs = export_outputs(e, source, problems);
  for (const std::string& band : source.bands) {
    if (e.envi.empty() || image.has(band + "." + e.quantity)) continue;
    problems.push_back({"--quantity", fmt::format("the image has no channel {}.{}", band, e.quantity),
                        fmt::format("it has {}", fmt::join(image.channels(), ", "))});
  }
  check_outputs(outputs, force, {file}, std::move(problems));
  write_exports(e, image);
  if (!quiet) {
    std::vector<std::string> names;
    for (const Output& output : outputs) names.push_back(output.file.string());
    fmt::print("{}\n", fmt::join(names, ", "));
  }
  return kDone;
}

}  // namespace

std::filesystem::path file_of_band(const std::string& file, const std::vector<std::string>& bands, std::size_t band) {
  std::filesystem::path path(file);
  if (band == 0) return path;
  return path.replace_extension("." + bands[band] + path.extension().string());
}

void add_export_options(CLI::App& app, Exports& e) {
  const char* const files = "Other files";
  app.add_option("--envi", e.envi, "Header to write, with the bands in FILE.img: ENVI, float32, band sequential")
      ->type_name("FILE.hdr")
      ->group(files);
  app.add_option("--quantity", e.quantity,
                 "Of each band, for --envi: radiance, error, transmission, temperature, detector ...")
      ->type_name("Q")
      ->capture_default_str()
      ->group(files);
  app.add_option("--counts", e.counts,
                 "The detector's counts in 16 bits, .png or .tif; of several bands FILE.<band>.png ...")
      ->type_name("FILE")
      ->group(files);
  app.add_option("--csv", e.csv, "Table to write: one row for each pixel, with all channels")
      ->type_name("FILE.csv")
      ->group(files);
  app.add_option("--region", e.region, "Pixels for --csv; default: all")
      ->type_name("X,Y,COLUMNS,ROWS")
      ->delimiter(',')
      ->expected(4)
      ->group(files);
  app.add_option("--line", e.line, "Pixels for --csv, from one end to the other")
      ->type_name("X0,Y0,X1,Y1")
      ->delimiter(',')
      ->expected(4)
      ->group(files);
}

std::vector<Output> export_outputs(const Exports& e, const ExportSource& source, std::vector<Problem>& problems) {
  std::vector<Output> outputs;
  if (!e.envi.empty()) {
    outputs.push_back({e.envi, "--envi", ".hdr"});
    outputs.push_back({envi_data_file(e.envi), "--envi", ""});
  }
  if (!e.counts.empty()) {
    if (!source.has_counts) {
      problems.push_back({"--counts", "there are no counts", source.no_counts});
    }
    if (!has_one_of(e.counts, {".png", ".tif", ".tiff"})) {
      problems.push_back(
          {"--counts", fmt::format("\"{}\" does not end in .png or .tif", e.counts), "give a name that does"});
    }
    for (std::size_t band = 0; band < source.bands.size(); ++band) {
      outputs.push_back({file_of_band(e.counts, source.bands, band), "--counts", ""});
    }
  }
  if (!e.csv.empty()) outputs.push_back({e.csv, "--csv", ".csv"});
  check_places(e, source, problems);
  return outputs;
}

void write_exports(const Exports& e, const Image& image) {
  const std::vector<std::string> bands = band_names(image);
  if (!e.envi.empty()) write_envi(e.envi, image, e.quantity);
  for (std::size_t band = 0; band < bands.size() && !e.counts.empty(); ++band) {
    write_counts(file_of_band(e.counts, bands, band), image, bands[band] + ".counts");
  }
  if (!e.csv.empty()) write_csv(e.csv, image, places_of(e, {image.columns(), image.rows()}));
}

Command add_export(CLI::App& program) {
  struct Arguments {
    std::string image;
    Exports exports;
    bool force = false, quiet = false;
  };
  const auto a = std::make_shared<Arguments>();
  CLI::App* app =
      program.add_subcommand("export", "Write an image as ENVI, as counts of 16 bits, or pixels of it as a table");
  app->add_option("image", a->image, "Image that obscura render wrote")->required()->type_name("IMAGE.exr");
  add_export_options(*app, a->exports);
  app->add_flag("-f,--force", a->force, "Replace outputs that exist");
  app->add_flag("--quiet", a->quiet, "No list of what was written; errors stay");
  app->footer(
      "Examples:\n"
      "  obscura export night.exr --envi night.hdr\n"
      "  obscura export night.exr --counts night.tif --csv row.csv --line 0,120,319,120");
  return {app, [a] { return export_image(a->image, a->exports, a->force, a->quiet); }};
}

}  // namespace obscura::cli
