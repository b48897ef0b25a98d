// obscura study: what accuracy costs on this machine, for one scene, by every method.
#include "scene/study/study.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <unistd.h>

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

struct StudyArguments {
  std::string scene, page, plot, budget;
  std::vector<std::string> set;
  int pixels = 64, threads = 0;
  std::uint64_t seed = 1;
  bool markdown = false, force = false, quiet = false;
};

int study(const StudyArguments& a) {
  std::vector<Problem> problems;
  const std::vector<SceneEdit> edits = set_edits(a.set, problems);
  std::optional<Description> scene;
  collect(problems, [&] { scene = read_scene(a.scene, edits); });
  StudySettings settings;
  settings.pixels = a.pixels;
  settings.seed = a.seed;
  if (!a.budget.empty()) collect(problems, [&] { settings.budget_s = parse_seconds(a.budget, "--budget"); });
  if (!(settings.budget_s > 0)) problems.push_back({"--budget", "there is no time", "give one above 0, such as 5min"});

  std::filesystem::path json = a.page, csv = a.page;
  json.replace_extension(".json");
  csv.replace_extension(".csv");
  std::vector<Output> outputs = {{a.page, "--output", ".html"}, {json, "--output", ""}, {csv, "--output", ""}};
  if (!a.plot.empty()) outputs.push_back({a.plot, "--plot", ".svg"});
  check_outputs(outputs, a.force, input_files(a.scene, scene), std::move(problems));

  catch_interrupts();
  Console console(a.quiet);
  if (!a.quiet) {
    const bool terminal = isatty(2) != 0;
    settings.tell = [terminal](const std::string& line) {
      fmt::print(stderr, "{}{}\n", terminal ? "\r\x1b[K" : "", line);
    };
  }
  const auto threads = static_cast<std::size_t>(a.threads > 0 ? a.threads : tbb::this_task_arena::max_concurrency());
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  Study result = run_study(*scene, settings, console.progress());
  result.threads = static_cast<int>(threads);
  console.finish();

  write_study_html(a.page, result);
  const auto write = [](const std::filesystem::path& file, const std::string& text) {
    write_whole_stream(file, [&](std::ostream& stream) { stream << text; });
  };
  write(json, study_json(result));
  write(csv, study_csv(result));
  if (!a.plot.empty()) write(a.plot, study_svg(result));
  fmt::print("{}", a.markdown ? study_markdown(result) : study_table(result));
  std::fflush(stdout);
  print_warnings(result.warnings);
  if (!a.quiet) {
    for (const Output& output : outputs)
      fmt::print(stderr, "{}{}\n", result.partial ? "partial: " : "", output.file.string());
  }
  return kDone;
}

}  // namespace

Command add_study(CLI::App& program) {
  CLI::App* app = program.add_subcommand(
      "study", "What accuracy costs: error of every method against time and memory, for one scene on this machine");
  const auto a = std::make_shared<StudyArguments>();
  app->add_option("scene", a->scene, "Scene file")->required()->type_name("SCENE");
  app->add_option("-o,--output", a->page,
                  "Page to write, with plots and pictures; beside it the numbers, ending in .json and .csv")
      ->required()
      ->type_name("STUDY.html");
  app->add_option("--plot", a->plot, "Write error against time as a picture too")->type_name("PLOT.svg");
  app->add_flag("--markdown", a->markdown, "Print the settings to use as a table in Markdown");
  app->add_flag("-f,--force", a->force, "Replace outputs that exist");
  app->add_flag("--quiet", a->quiet, "No progress; the table, warnings and errors stay");

  const char* const how = "How";
  app->add_option("--budget", a->budget, "Time to spend: seconds, or 30s, 5min; default 5min")
      ->type_name("S")
      ->group(how);
  app->add_option("--pixels", a->pixels, "Longest side of the picture, which is made smaller for the study; default 64")
      ->type_name("N")
      ->check(CLI::Range(4, 4096))
      ->group(how);
  app->add_option("--seed", a->seed, "Seed of all random numbers")->type_name("N")->group(how);
  app->add_option("--set", a->set, "Change any value of the scene, e.g. /sensor/fov_deg=5; may be repeated")
      ->type_name("/POINTER=VALUE")
      ->type_size(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->allow_extra_args(false)
      ->group(how);
  app->add_option("--threads", a->threads, "Threads; default: all")
      ->type_name("N")
      ->check(CLI::Range(1, 4096))
      ->group(how);
  app->footer(
      "Error: RMS over pixels of the difference from a long reference, over the radiance or 5 % of its largest; the\n"
      "reference's own error is taken off. Every setting runs twice with random numbers of its own, so that bias and "
      "noise\n"
      "come apart. Ctrl-C writes what there is.\n\n"
      "Examples:\n"
      "  obscura study smoke.json -o smoke_study.html\n"
      "  obscura study smoke.json -o smoke_study.html -f --budget 30min --pixels 128");
  return {app, [a] { return study(*a); }};
}

}  // namespace obscura::cli
