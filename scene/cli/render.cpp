// obscura render: from a scene file to an image and its report.
#include "commands.h"
#include "console.h"
#include "quantities.h"
#include "scene/run.h"
#include "scene/scene_io.h"
#include "sensor/image_io.h"
#include "sensor/preview.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>

namespace obscura::cli {
namespace {

struct RenderArguments {
  std::string scene, output, report, preview;
  std::string method, photons, samples, time, target_error, time_limit, seed, memory;
  std::vector<std::string> set;
  int threads = 0;
  bool force = false, quiet = false;
};

// Every option that changes the scene is an edit of it: one reader checks them all.
std::vector<SceneEdit> edits_of(const RenderArguments& a, const CLI::App& app, std::vector<Problem>& problems) {
  std::vector<SceneEdit> edits;
  for (const std::string& text : a.set) {
    const auto equals = text.find('=');
    if (equals == std::string::npos) {
      problems.push_back({"--set " + text, "there is no \"=\"", "give /json/pointer=value"});
    } else {
      edits.push_back({text.substr(0, equals), text.substr(equals + 1), "--set"});
    }
  }
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
  add("--target-error", "/render/target_error", number("--target-error", a.target_error, parse_fraction));
  add("--time-limit", "/render/time_limit_s", number("--time-limit", a.time_limit, parse_seconds));
  add("--seed", "/render/seed", a.seed);
  add("--memory", "/render/memory_MiB", a.memory);
  return edits;
}

// p.png for one band; p.png and p.<band>.png for several.
std::filesystem::path preview_file(const std::string& preview, const Description& scene, std::size_t band) {
  std::filesystem::path file(preview);
  if (band == 0) return file;
  return file.replace_extension("." + scene.bands[band].name + ".png");
}

int render(const RenderArguments& a, const CLI::App& app) {
  std::vector<Problem> problems;
  const std::vector<SceneEdit> edits = edits_of(a, app, problems);
  std::optional<Description> scene;
  try {
    scene = read_scene(a.scene, edits);
  } catch (const InputError& error) {
    problems.insert(problems.end(), error.problems().begin(), error.problems().end());
  }

  const std::filesystem::path report_file =
      a.report.empty() ? std::filesystem::path(a.output).replace_extension(".json") : std::filesystem::path(a.report);
  std::vector<Output> outputs = {{a.output, "--output", ".exr"}, {report_file, "--report", ""}};
  if (!a.preview.empty()) {
    for (std::size_t band = 0; band < (scene ? scene->bands.size() : 1); ++band) {
      outputs.push_back({scene ? preview_file(a.preview, *scene, band) : std::filesystem::path(a.preview), "--preview", ".png"});
    }
  }
  std::vector<std::filesystem::path> inputs = {a.scene};
  if (scene) {
    for (const CloudDescription& cloud : scene->clouds) {
      if (cloud.grid && !cloud.grid->file.empty()) inputs.push_back(cloud.grid->file);
    }
  }
  check_outputs(outputs, a.force, inputs, std::move(problems));

  catch_interrupts();
  Console console(a.quiet);
  RunOptions options;
  options.threads = a.threads;
  const RunResult result = run_scene(*scene, options, console.progress());
  console.finish();

  write_image(a.output, result.image);
  write_report(report_file, result.report);
  if (!a.preview.empty()) {
    for (std::size_t band = 0; band < scene->bands.size(); ++band) {
      write_preview_sheet(preview_file(a.preview, *scene, band), result.image, scene->bands[band].name);
    }
  }
  print_warnings(result.report.warnings);
  if (!a.quiet) {
    std::string written = a.output + ", " + report_file.string();
    for (std::size_t i = 2; i < outputs.size(); ++i) written += ", " + outputs[i].file.string();
    fmt::print("{}{}\n", result.report.partial ? "partial: " : "", written);
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
  app->add_option("-o,--output", a->output, "Image to write: radiance, error, transmission, temperature ...")
      ->required()->type_name("IMAGE.exr");
  app->add_option("--report", a->report, "Report to write; default: the image's name, ending in .json")->type_name("R.json");
  app->add_option("--preview", a->preview, "Picture to look at")->type_name("P.png");
  app->add_flag("-f,--force", a->force, "Replace outputs that exist");
  app->add_flag("--quiet", a->quiet, "No progress; warnings and errors stay");

  const char* const wish = "In place of the scene's";
  app->add_option("--method", a->method, "How scattering is found: photon (baked and path are not available yet)")
      ->type_name("M")->group(wish);
  app->add_option("--photons", a->photons, "Photons emitted, per band")->type_name("N")->group(wish);
  app->add_option("--samples", a->samples, "Paths per pixel of final gather and method path")->type_name("N")->group(wish);
  app->add_option("--time", a->time, "The picture's time: seconds, or 30s, 5min")->type_name("S")->group(wish);
  app->add_option("--seed", a->seed, "Seed of all random numbers")->type_name("N")->group(wish);
  app->add_option("--set", a->set, "Change any value of the scene, e.g. /sensor/fov_deg=5; may be repeated")
      ->type_name("/POINTER=VALUE")->type_size(1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->allow_extra_args(false)->group(wish);

  const char* const limits = "Limits";
  app->add_option("--threads", a->threads, "Threads; default: all. Results do not depend on it")
      ->type_name("N")->check(CLI::Range(1, 4096))->group(limits);
  const char* const later = "Not available yet";
  app->add_option("--target-error", a->target_error, "Image error to reach: 0.03 or 3%")->type_name("E")->group(later);
  app->add_option("--time-limit", a->time_limit, "Time to stop at: seconds, or 30s, 5min")->type_name("S")->group(later);
  app->add_option("--memory", a->memory, "Memory to stay below")->type_name("MiB")->group(later);
  app->footer(
      "Ctrl-C writes what there is, marked partial.\n\n"
      "Examples:\n"
      "  obscura render smoke.json -o night.exr --preview night.png\n"
      "  obscura render smoke.json -o quick.exr -f --photons 1e5 --set /sensor/resolution=[80,60]");
  return {app, [a, app] { return render(*a, *app); }};
}

}  // namespace obscura::cli
