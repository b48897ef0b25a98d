// obscura obscuration: how well the clouds of a scene hide its objects from its sensor.
#include "scene/hiding/obscuration.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cstdio>
#include <memory>
#include <ostream>

#include "commands.h"
#include "console.h"
#include "edits.h"
#include "quantities.h"
#include "sensor/picture/whole_file_io.h"

namespace obscura::cli {
namespace {

struct ObscurationArguments {
  std::string scene, page, json, csv, threshold, contrast, time, seed, method;
  std::vector<std::string> objects, set;
  double nedt_K = 0;
  int ring_px = 0, replicas = 8, threads = 0;
  bool force = false, quiet = false;
};

int obscuration(const ObscurationArguments& a, const CLI::App& app) {
  std::vector<Problem> problems;
  std::vector<SceneEdit> edits = set_edits(a.set, problems);
  if (!a.method.empty()) edits.push_back({"/render/method", a.method, "--method"});
  if (!a.seed.empty()) edits.push_back({"/render/seed", a.seed, "--seed"});
  std::optional<Description> scene;
  collect(problems, [&] { scene = read_scene(a.scene, edits); });

  ObscurationWish wish;
  wish.objects = a.objects;
  wish.replicas = a.replicas;
  wish.ring_px = a.ring_px;
  wish.pictures = !a.page.empty();
  if (!a.time.empty()) collect(problems, [&] { wish.time_s = parse_seconds(a.time, "--time"); });
  if (!a.threshold.empty())
    collect(problems, [&] { wish.thresholds.transmission = parse_fraction(a.threshold, "--threshold"); });
  if (wish.thresholds.transmission > 1)
    problems.push_back({"--threshold", "a transmission is at most 1", "give 0.1 or 10%"});
  if (!a.contrast.empty())
    collect(problems, [&] { wish.thresholds.contrast = parse_fraction(a.contrast, "--contrast"); });
  if (app.count("--nedt") > 0) wish.thresholds.difference_K = a.nedt_K;

  std::vector<Output> outputs;
  if (!a.page.empty()) outputs.push_back({a.page, "--output", ".html"});
  if (!a.json.empty()) outputs.push_back({a.json, "--json", ".json"});
  if (!a.csv.empty()) outputs.push_back({a.csv, "--csv", ".csv"});
  check_outputs(outputs, a.force, input_files(a.scene, scene), std::move(problems));

  catch_interrupts();
  Console console(a.quiet);
  const auto threads = static_cast<std::size_t>(a.threads > 0 ? a.threads : tbb::this_task_arena::max_concurrency());
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  const Obscuration result = find_obscuration(*scene, wish, console.progress());
  console.finish();

  if (!a.page.empty()) write_obscuration_html(a.page, result);
  const auto write = [](const std::string& file, const std::string& text) {
    if (!file.empty()) write_whole_stream(file, [&](std::ostream& stream) { stream << text; });
  };
  write(a.json, obscuration_json(result));
  write(a.csv, obscuration_csv(result));
  fmt::print("{}", obscuration_table(result));
  std::fflush(stdout);
  print_warnings(result.warnings);
  if (!a.quiet) {
    for (const Output& output : outputs)
      fmt::print(stderr, "{}{}\n", result.partial ? "partial: " : "", output.file.string());
  }
  if (result.failure)
    throw NumericalError(a.scene, *result.failure, "the outputs were written; their numbers are not to be trusted");
  return kDone;
}

}  // namespace

Command add_obscuration(CLI::App& program) {
  CLI::App* app = program.add_subcommand(
      "obscuration",
      "How well clouds hide objects: transmission, contrast and temperature difference with and without them");
  const auto a = std::make_shared<ObscurationArguments>();
  const auto several = [](CLI::Option* option) {
    return option->type_size(1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)->allow_extra_args(false);
  };
  app->add_option("scene", a->scene, "Scene file")->required()->type_name("SCENE");
  app->add_option("-o,--output", a->page, "Page to write: pictures with and without the clouds, the tables")
      ->type_name("PAGE.html");
  app->add_option("--json", a->json, "The numbers for programs")->type_name("F.json");
  app->add_option("--csv", a->csv, "The numbers for spreadsheets, one a line")->type_name("F.csv");
  app->add_flag("-f,--force", a->force, "Replace outputs that exist");
  app->add_flag("--quiet", a->quiet, "No progress; the table, warnings and errors stay");

  const char* const what = "What";
  several(app->add_option("--object", a->objects,
                          "Object to look at; may be repeated. Default: every object that is wholly in the picture"))
      ->type_name("NAME")
      ->group(what);
  app->add_option("--threshold", a->threshold,
                  "A line of sight with no more transmission is obscured: 0.1 or 10%; default 0.1")
      ->type_name("T")
      ->group(what);
  app->add_option("--contrast", a->contrast, "A part of the object with less relative contrast is lost; default 0.02")
      ->type_name("C")
      ->group(what);
  app->add_option("--nedt", a->nedt_K,
                  "Likewise with less difference of apparent temperature: what the sensor can tell, kelvin; default: "
                  "the detector's nedt_K, where the scene has one")
      ->type_name("K")
      ->check(CLI::Range(1e-9, 1e6))
      ->group(what);
  app->add_option(
         "--ring", a->ring_px,
         "Width of the surroundings in pixels; default: half the side of a square of the object's area, at least 2")
      ->type_name("PX")
      ->check(CLI::Range(1, 100000))
      ->group(what);

  const char* const how = "How";
  app->add_option("--replicas", a->replicas,
                  "Independent repetitions, each with photons of its own: they give the intervals; default 8")
      ->type_name("N")
      ->check(CLI::Range(2, 1000))
      ->group(how);
  app->add_option("--method", a->method, "How scattering is found: photon or path; default: the scene's")
      ->type_name("M")
      ->group(how);
  app->add_option("--time", a->time, "The picture's time: seconds, or 30s, 5min; default: the scene's")
      ->type_name("S")
      ->group(how);
  app->add_option("--seed", a->seed, "Seed of all random numbers; default: the scene's")->type_name("N")->group(how);
  several(app->add_option("--set", a->set, "Change any value of the scene, e.g. /render/photons=1e6; may be repeated"))
      ->type_name("/POINTER=VALUE")
      ->group(how);
  app->add_option("--threads", a->threads, "Threads; default: all. Results do not depend on it")
      ->type_name("N")
      ->check(CLI::Range(1, 4096))
      ->group(how);
  app->footer(
      "Transmission is that of the clouds, from the sensor to the object. Contrast: the object's mean radiance against "
      "that of a\n"
      "ring around it, with the clouds and in the same scene without them. Numbers stand with their 95 % intervals.\n"
      "An object that the picture's border cuts (terrain, a floor) is taken only where --object names it.\n"
      "Exit codes: 0 done, 2 bad input, 3 the machine's limits, 4 numbers not to be trusted.\n\n"
      "Examples:\n"
      "  obscura obscuration smoke.json --object truck -o truck.html --nedt 0.1\n"
      "  obscura obscuration smoke.json --threshold 5% --csv smoke.csv");
  return {app, [a, app] { return obscuration(*a, *app); }};
}

}  // namespace obscura::cli
