// obscura render: from a scene file to an image and its report.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "commands.h"
#include "console.h"
#include "edits.h"
#include "exports.h"
#include "photon/methods/method.h"
#include "quantities.h"
#include "scene/file/scene_io.h"
#include "scene/run/run.h"

namespace obscura::cli {
namespace {

struct RenderArguments {
  std::string scene, report;
  std::string method, photons, samples, time, target_error, time_limit, seed, memory;
  std::vector<std::string> set, effects;
  Exports exports;
  int threads = 0;
  bool force = false, quiet = false;
};

// Every option that changes the scene is an edit of it: one reader checks them all.
std::vector<SceneEdit> edits_of(const RenderArguments& a, const CLI::App& app, std::vector<Problem>& problems) {
  std::vector<SceneEdit> edits = set_edits(a.set, problems);
  const auto add = [&](const char* option, const char* pointer, const std::string& value) {
    if (app.count(option) > 0) edits.push_back({pointer, value, option});
  };
  const auto number = [&](const char* option, const std::string& text,
                          double (*parse)(const std::string&, const std::string&)) -> std::string {
    if (app.count(option) == 0) return {};
    try {
      return fmt::format("{}", parse(text, option));
    } catch (const InputError& error) {
      problems.insert(problems.end(), error.problems().begin(), error.problems().end());
      return "null";
    }
  };
  add("--method", "/render/method", a.method);
  add("--photons", "/render/photons", a.photons);
  add("--samples", "/render/samples", a.samples);
  add("--time", "/time_s", number("--time", a.time, parse_seconds));
  add("--target-error", "/render/target_error", a.target_error);
  add("--time-limit", "/render/time_limit_s", number("--time-limit", a.time_limit, parse_seconds));
  add("--seed", "/render/seed", a.seed);
  add("--memory", "/render/memory_MiB", a.memory);
  const std::vector<SceneEdit> forced = effect_edits(a.effects, problems);
  edits.insert(edits.end(), forced.begin(), forced.end());
  return edits;
}

// Quantities that each band of the image will have: those of every image, and those of such a scene.
std::vector<std::string> quantities_of(const Description& scene) {
  std::vector<std::string> known = {"radiance", "error", "transmission"};
  const bool grey = std::any_of(scene.bands.begin(), scene.bands.end(), [](const auto& band) { return band.grey(); });
  if (!grey) known.push_back("temperature");
  // Where the plan is to choose, it may take paths, which have none.
  if (!scene.render.method.empty() && scene.render.method != kPathTracer.word) known.push_back("bias");
  if (scene.atmosphere) known.push_back("transmission_atmosphere");
  if (scene.sensor.detector.on()) {
    known.push_back("detector");
    if (!grey) known.push_back("detector_temperature");
    if (scene.sensor.detector.bits > 0) known.push_back("counts");
  }
  return known;
}

// What the scene says about the image to come.
ExportSource source_of(const Description& scene) {
  ExportSource source;
  for (const BandDescription& band : scene.bands) source.bands.push_back(band.name);
  source.resolution = scene.sensor.resolution;
  source.quantities = quantities_of(scene);
  source.no_counts = "give \"bits\" in the scene's sensor/detector, or --set /sensor/detector/bits=14";
  return source;
}

void check_quantity(const std::string& quantity, const ExportSource& source, std::vector<Problem>& problems) {
  const std::vector<std::string>& known = source.quantities;
  if (std::find(known.begin(), known.end(), quantity) != known.end()) return;
  problems.push_back({"--quantity", "the bands will not all have a channel \"" + quantity + "\"",
                      fmt::format("give one of {}", fmt::join(known, ", "))});
}

void print_accuracy(const AccuracyReport& a) {
  fmt::print("image error {:.2g} % (95 %: {:.2g} to {:.2g} %), noise {:.2g} %, bias {:.2g} %; {} pass{} of {}",
             100 * a.error, 100 * a.interval[0], 100 * a.interval[1], 100 * a.noise, 100 * a.bias, a.passes,
             a.passes == 1 ? "" : "es", a.method);
  if (a.photons > 0) fmt::print(", {} photons", a.photons);
  fmt::print(", {} samples\n", a.samples);
}

int render(const RenderArguments& a, const CLI::App& app) {
  std::vector<Problem> problems;
  const std::vector<SceneEdit> edits = edits_of(a, app, problems);
  std::optional<Description> scene;
  collect(problems, [&] { scene = read_scene(a.scene, edits); });

  const std::filesystem::path image_file = a.exports.files.at("--output");
  const std::filesystem::path report_file =
      a.report.empty() ? std::filesystem::path(image_file).replace_extension(".json") : std::filesystem::path(a.report);
  const ExportSource source = scene ? source_of(*scene) : ExportSource{};
  std::vector<Output> outputs = export_outputs(a.exports, OutputUse::image, source, problems);
  outputs.push_back({report_file, "--report", ""});
  const auto add_outputs = [&](OutputUse use) {
    const std::vector<Output> more = export_outputs(a.exports, use, source, problems);
    outputs.insert(outputs.end(), more.begin(), more.end());
  };
  add_outputs(OutputUse::picture);
  if (scene) {
    if (!a.exports.files.at("--rays").empty() && !scene->sensor.antialiasing.adaptive()) {
      problems.push_back(
          {"--rays", "the scene's antialiasing gives every pixel as many rays", "leave its thresholds above 0"});
    }
    if (a.exports.takes_quantity()) check_quantity(a.exports.quantity, source, problems);
    add_outputs(OutputUse::other);
  }
  check_outputs(outputs, a.force, input_files(a.scene, scene), std::move(problems));

  catch_interrupts();
  Console console(a.quiet);
  RunOptions options;
  options.threads = a.threads;
  const RunResult result = run_scene(*scene, options, console.progress());
  console.finish();

  write_exports(a.exports, OutputUse::image, result.image);
  write_report(report_file, result.report);
  write_exports(a.exports, OutputUse::picture, result.image);
  write_exports(a.exports, OutputUse::other, result.image);
  print_warnings(result.report.warnings);
  if (result.report.accuracy && !a.quiet) print_accuracy(*result.report.accuracy);
  if (!a.quiet) {
    std::vector<std::string> written;
    for (const Output& output : outputs) written.push_back(output.file.string());
    fmt::print("{}{}\n", result.report.partial ? "partial: " : "", fmt::join(written, ", "));
  }
  if (result.failure) {
    throw NumericalError(a.scene, *result.failure, "the image was written; its numbers are not to be trusted");
  }
  return kDone;
}

}  // namespace

Command add_render(CLI::App& program) {
  CLI::App* app = program.add_subcommand("render", "Render a scene to an image (OpenEXR) and a report (JSON)");
  const auto a = std::make_shared<RenderArguments>();
  app->add_option("scene", a->scene, "Scene file")->required()->type_name("SCENE");
  add_output_options(*app, a->exports, OutputUse::image);
  app->add_option("--report", a->report, "Report to write; default: the image's name, ending in .json")
      ->type_name("R.json");
  add_output_options(*app, a->exports, OutputUse::picture);
  app->add_flag("-f,--force", a->force, "Replace outputs that exist");
  app->add_flag("--quiet", a->quiet, "No progress; warnings and errors stay");

  const char* const edits = "In place of the scene's";
  app->add_option("--method", a->method,
                  "How scattering is found: photon, path or ordinates; default: what the plan calls cheaper")
      ->type_name("M")
      ->group(edits);
  app->add_option("--photons", a->photons, "Photons emitted, per band")->type_name("N")->group(edits);
  app->add_option("--samples", a->samples, "Paths per pixel of final gather and method path")
      ->type_name("N")
      ->group(edits);
  app->add_option("--time", a->time, "The picture's time: seconds, or 30s, 5min")->type_name("S")->group(edits);
  app->add_option("--seed", a->seed, "Seed of all random numbers")->type_name("N")->group(edits);
  add_effect_option(*app, a->effects)->group(edits);
  app->add_option("--set", a->set, "Change any value of the scene, e.g. /sensor/fov_deg=5; may be repeated")
      ->type_name("/POINTER=VALUE")
      ->type_size(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->allow_extra_args(false)
      ->group(edits);

  add_export_options(*app, a->exports);

  const char* const limits = "Limits";
  app->add_option("--threads", a->threads, "Threads; default: all. Results do not depend on it")
      ->type_name("N")
      ->check(CLI::Range(1, 4096))
      ->group(limits);
  const char* const goals = "Goals; photons and samples, and the method where none is given, are chosen";
  app->add_option("--target-error", a->target_error,
                  "Error to reach: of the image, 0.03 or 3%; or of temperature, 20mK or 0.1K")
      ->type_name("E")
      ->group(goals);
  app->add_option("--time-limit", a->time_limit, "The most accurate image for this time: seconds, or 30s, 5min")
      ->type_name("S")
      ->group(goals);
  const char* const later = "Not available yet";
  app->add_option("--memory", a->memory, "Memory to stay below")->type_name("MiB")->group(later);
  app->footer(
      "Ctrl-C writes what there is, marked partial.\n\n"
      "Examples:\n"
      "  obscura render smoke.json -o night.exr --preview night.png\n"
      "  obscura render smoke.json -o quick.exr -f --photons 1e5 --set /sensor/resolution=[80,60]\n"
      "  obscura render smoke.json -o seen.exr --set /sensor/detector/bits=14 --set /sensor/detector/range=[20,60] "
      "--counts seen.png");
  return {app, [a, app] { return render(*a, *app); }};
}

}  // namespace obscura::cli
