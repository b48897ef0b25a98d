// obscura export, and the same outputs for obscura render.
#include "exports.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

namespace obscura::cli {
namespace {

std::array<int, 4> four(const std::vector<int>& numbers) { return {numbers[0], numbers[1], numbers[2], numbers[3]}; }

std::vector<PixelPlace> places_of(const Exports& e, const std::array<int, 2>& resolution) {
  const auto [columns, rows] = resolution;
  if (!e.line.empty()) return pixels_on_line(columns, rows, four(e.line));
  return pixels_in_region(columns, rows, e.region.empty() ? std::array<int, 4>{0, 0, columns, rows} : four(e.region));
}

// The file that is asked for; empty: none.
std::string file_of(const Exports& e, const ImageOutput& output) {
  const auto found = e.files.find(output.option);
  return found == e.files.end() ? std::string() : found->second;
}

// Whether any output is asked for of which `holds` is true.
template <class F>
bool any_asked(const Exports& e, F&& holds) {
  return std::ranges::any_of(image_outputs(),
                             [&](const ImageOutput& output) { return !file_of(e, output).empty() && holds(output); });
}

// "--envi, --counts or --csv": those of which `holds` is true.
template <class F>
std::string options_list(F&& holds, bool with_placeholder = false) {
  std::vector<std::string> options;
  for (const ImageOutput& output : image_outputs()) {
    if (holds(output)) options.push_back(output.option + (with_placeholder ? " " + output.placeholder : ""));
  }
  std::string list;
  for (std::size_t i = 0; i < options.size(); ++i) {
    list += (i == 0 ? "" : i + 1 < options.size() ? ", " : " or ") + options[i];
  }
  return list;
}

bool takes_pixels(const ImageOutput& output) { return output.takes_pixels; }
bool takes_quantity(const ImageOutput& output) { return output.takes_quantity; }

void check_places(const Exports& e, const ExportSource& source, std::vector<Problem>& problems) {
  const char* const option = e.line.empty() ? "--region" : "--line";
  if (!any_asked(e, takes_pixels)) {
    if (!e.region.empty() || !e.line.empty()) {
      problems.push_back({option, fmt::format("it says which pixels {} gets", options_list(takes_pixels)),
                          "give " + options_list(takes_pixels, true)});
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

// What each band of an image has.
std::vector<std::string> quantities_of(const Image& image, const std::vector<std::string>& bands) {
  std::vector<std::string> quantities;
  for (const std::string& channel : image.channels()) {
    const std::string quantity = channel.substr(channel.rfind('.') + 1);
    const auto has_it = [&](const std::string& band) { return image.has(band + "." + quantity); };
    if (!bands.empty() && std::ranges::all_of(bands, has_it)) quantities.push_back(quantity);
  }
  return quantities;
}

int export_image(const std::string& file, const Exports& e, bool force, bool quiet) {
  std::vector<Problem> problems;
  const auto exported = [](const ImageOutput& output) { return output.use == OutputUse::other; };
  if (!any_asked(e, exported)) {
    problems.push_back({"export", "nothing is asked for", "give " + options_list(exported)});
  }
  const Image image = read_image(file);
  ExportSource source;
  source.bands = band_names(image);
  source.resolution = {image.columns(), image.rows()};
  source.quantities = quantities_of(image, source.bands);
  source.no_counts = "render it with \"bits\" in the scene's sensor/detector";
  const auto of_bands = [](const ImageOutput& output) { return output.one_file_per_band || output.takes_quantity; };
  if (source.bands.empty() && any_asked(e, of_bands)) {
    problems.push_back({file, "it has no band: no channel ends in .radiance", "give an image that obscura rendered"});
  }
  const std::vector<Output> outputs = export_outputs(e, OutputUse::other, source, problems);
  for (const std::string& band : source.bands) {
    if (!e.takes_quantity() || image.has(band + "." + e.quantity)) continue;
    problems.push_back({"--quantity", fmt::format("the image has no channel {}.{}", band, e.quantity),
                        fmt::format("it has {}", fmt::join(image.channels(), ", "))});
  }
  check_outputs(outputs, force, {file}, std::move(problems));
  write_exports(e, OutputUse::other, image);
  if (!quiet) {
    std::vector<std::string> names;
    for (const Output& output : outputs) names.push_back(output.file.string());
    fmt::print("{}\n", fmt::join(names, ", "));
  }
  return kDone;
}

}  // namespace

bool Exports::takes_quantity() const { return any_asked(*this, cli::takes_quantity); }

void add_output_options(CLI::App& app, Exports& e, OutputUse use) {
  for (const ImageOutput& output : image_outputs()) {
    if (output.use != use) continue;
    CLI::Option* option = app.add_option(use == OutputUse::image ? "-o," + output.option : output.option,
                                         e.files[output.option], output.what)
                              ->type_name(output.placeholder);
    if (use == OutputUse::image) option->required();
    if (use == OutputUse::other) option->group("Other files");
  }
}

void add_export_options(CLI::App& app, Exports& e) {
  add_output_options(app, e, OutputUse::other);
  const char* const files = "Other files";
  app.add_option("--quantity", e.quantity,
                 fmt::format("Of each band, for {}: radiance, error, transmission, temperature, detector ...",
                             options_list(takes_quantity)))
      ->type_name("Q")
      ->capture_default_str()
      ->group(files);
  app.add_option("--region", e.region, fmt::format("Pixels for {}; default: all", options_list(takes_pixels)))
      ->type_name("X,Y,COLUMNS,ROWS")
      ->delimiter(',')
      ->expected(4)
      ->group(files);
  app.add_option("--line", e.line, fmt::format("Pixels for {}, from one end to the other", options_list(takes_pixels)))
      ->type_name("X0,Y0,X1,Y1")
      ->delimiter(',')
      ->expected(4)
      ->group(files);
}

std::vector<Output> export_outputs(const Exports& e, OutputUse use, const ExportSource& source,
                                   std::vector<Problem>& problems) {
  std::vector<Output> outputs;
  for (const ImageOutput& output : image_outputs()) {
    const std::string name = file_of(e, output);
    if (output.use != use || name.empty()) continue;
    if (!output.needs.empty() && std::ranges::find(source.quantities, output.needs) == source.quantities.end()) {
      problems.push_back({output.option, "there are no " + output.needs, source.no_counts});
    }
    if (!output_format_of(output, name)) {
      problems.push_back({output.option, fmt::format("\"{}\" does not end in {}", name, extension_list(output)),
                          "give a name that does"});
      continue;
    }
    for (std::filesystem::path& file : files_of(output, name, source.bands)) {
      outputs.push_back({std::move(file), output.option, ""});
    }
  }
  if (use == OutputUse::other) check_places(e, source, problems);
  return outputs;
}

void write_exports(const Exports& e, OutputUse use, const Image& image) {
  for (const ImageOutput& output : image_outputs()) {
    const std::string name = file_of(e, output);
    if (output.use != use || name.empty()) continue;
    OutputChoice choice;
    choice.quantity = e.quantity;
    if (output.takes_pixels) choice.pixels = places_of(e, {image.columns(), image.rows()});
    write_output(output, name, image, choice);
  }
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
