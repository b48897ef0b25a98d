// obscura verify: photon map, path tracer and discrete ordinates on the same scenes, and whether they agree.
#include "scene/verify/verify.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>

#include "commands.h"
#include "console.h"
#include "edits.h"
#include "quantities.h"
#include "scene/file/scene_io.h"
#include "scene/file/scene_words.h"

namespace obscura::cli {
namespace {

struct VerifyArguments {
  std::string scene, report, print, resolution;
  std::vector<std::string> cases, set;
  std::uint64_t seed = 1;
  int passes = 4, pixels = 48, threads = 0;
  bool list = false, json = false, force = false, quiet = false;
};

struct Job {
  Description scene;
  std::string about;
  double resolution = 0;
};

std::vector<std::string> case_names() {
  std::vector<std::string> names;
  for (const VerifyCase& c : verify_cases()) names.push_back(c.name);
  return names;
}

const VerifyCase& find_case(const std::string& name, const char* option) {
  const auto& cases = verify_cases();
  const auto found = std::find_if(cases.begin(), cases.end(), [&](const VerifyCase& c) { return c.name == name; });
  if (found == cases.end())
    throw InputError(option, fmt::format("there is no case \"{}\"", name), detail::suggest(name, case_names()));
  return *found;
}

std::vector<Job> jobs_of(const VerifyArguments& a) {
  std::vector<Problem> problems;
  const std::vector<SceneEdit> edits = set_edits(a.set, problems);
  if (!problems.empty()) throw InputError(std::move(problems));
  std::vector<Job> jobs;
  if (!a.scene.empty()) {
    if (!a.cases.empty()) throw InputError("--case", "a scene file is given too", "give a scene or cases");
    Job job{read_scene(a.scene, edits), "from " + a.scene, 0};
    if (job.scene.name.empty()) job.scene.name = std::filesystem::path(a.scene).stem().string();
    shrink_picture(job.scene, a.pixels);
    jobs.push_back(std::move(job));
  } else {
    std::vector<std::string> names = a.cases.empty() ? case_names() : a.cases;
    for (const std::string& name : names) {
      const VerifyCase& c = find_case(name, "--case");
      jobs.push_back({parse_scene(c.scene, ".", edits, c.name), c.about, c.resolution});
    }
  }
  if (!a.resolution.empty()) {
    for (Job& job : jobs) job.resolution = parse_fraction(a.resolution, "--resolution");
  }
  return jobs;
}

int verify(const VerifyArguments& a) {
  if (a.list) {
    for (const VerifyCase& c : verify_cases()) fmt::print("{:<20} {}\n", c.name, c.about);
    return kDone;
  }
  if (!a.print.empty()) {
    fmt::print("{}", find_case(a.print, "--print").scene);
    return kDone;
  }
  std::vector<Problem> problems;
  std::vector<Job> jobs;
  collect(problems, [&] { jobs = jobs_of(a); });
  std::vector<Output> outputs;
  if (!a.report.empty()) outputs.push_back({a.report, "--output", ".html"});
  std::vector<std::filesystem::path> inputs;
  if (!a.scene.empty()) inputs.emplace_back(a.scene);
  check_outputs(outputs, a.force, inputs, std::move(problems));

  catch_interrupts();
  Console console(a.quiet);
  const auto threads = static_cast<std::size_t>(a.threads > 0 ? a.threads : tbb::this_task_arena::max_concurrency());
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  const auto begin = std::chrono::steady_clock::now();
  std::vector<VerifiedScene> scenes;
  for (const Job& job : jobs) {
    if (console.progress().cancelled()) break;
    VerifySettings settings;
    settings.seed = a.seed;
    settings.passes = a.passes;
    settings.resolution = job.resolution;
    settings.scenes = static_cast<int>(jobs.size());
    scenes.push_back(verify_scene(job.scene, settings, console.progress()));
    scenes.back().about = job.about;
  }
  console.finish();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();

  if (!a.report.empty()) write_verify_html(a.report, scenes);
  if (a.json) {
    fmt::print("{}", verify_json(scenes));
  } else {
    fmt::print("{}", verify_table(scenes));
  }
  std::size_t failures = 0, comparisons = 0, judged = 0;
  for (const VerifiedScene& scene : scenes) {
    failures += scene.failures().size();
    comparisons += scene.comparisons();
    judged += scene.judged();
  }
  std::fflush(stdout);
  const bool stopped = scenes.size() < jobs.size() || console.progress().cancelled();
  if (!a.json && failures == 0 && !stopped) {
    fmt::print("all agree: {} comparisons in {} scene{}{}, {}\n", comparisons, scenes.size(),
               scenes.size() == 1 ? "" : "s",
               judged < comparisons
                   ? fmt::format(", of which {} are not judged: too weak to see a tenth", comparisons - judged)
                   : "",
               duration_text(seconds));
  }
  if (!a.report.empty() && !a.quiet) fmt::print(stderr, "{}\n", a.report);
  if (failures > 0)
    throw NumericalError("verify", judged == 0 ? "nothing could be judged"
                                               : fmt::format("{} of {} comparisons fail", failures, comparisons));
  if (stopped) throw NumericalError("verify", "stopped before the end: nothing is said about the rest");
  return kDone;
}

}  // namespace

Command add_verify(CLI::App& program) {
  CLI::App* app = program.add_subcommand(
      "verify", "Solve scenes by photon map, path tracer and discrete ordinates, and compare within their errors");
  const auto a = std::make_shared<VerifyArguments>();
  app->add_option("scene", a->scene, "Scene file; without it the built-in cases are run")->type_name("SCENE");
  app->add_option("-o,--output", a->report, "Report to write: pictures side by side, differences, the table")
      ->type_name("REPORT.html");
  app->add_option("--case", a->cases, "Run this built-in case only; may be repeated")
      ->type_name("NAME")
      ->type_size(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->allow_extra_args(false);
  app->add_flag("--list", a->list, "List the built-in cases");
  app->add_option("--print", a->print, "Print a built-in case as a scene file")->type_name("NAME");
  app->add_flag("--json", a->json, "JSON in place of the table");
  app->add_flag("-f,--force", a->force, "Replace a report that exists");
  app->add_flag("--quiet", a->quiet, "No progress; the table and errors stay");

  const char* const how = "How";
  app->add_option("--passes", a->passes,
                  "Independent repetitions of photon map and path tracer, each with the scene's settings; default 4")
      ->type_name("N")
      ->check(CLI::Range(1, 1000))
      ->group(how);
  app->add_option("--pixels", a->pixels,
                  "Longest side of a user's picture, which is made smaller for the comparison; default 48")
      ->type_name("N")
      ->check(CLI::Range(1, 4096))
      ->group(how);
  app->add_option("--resolution", a->resolution,
                  "Difference of two means that has to be seen in 99.9 % of cases: 0.03 or 3%; weaker comparisons "
                  "fail. Default: as each built-in case states; of a scene what cannot see a tenth is not judged")
      ->type_name("E")
      ->group(how);
  app->add_option("--seed", a->seed, "Seed of all random numbers")->type_name("N")->group(how);
  app->add_option("--set", a->set, "Change any value of the scene, e.g. /render/photons=1e6; may be repeated")
      ->type_name("/POINTER=VALUE")
      ->type_size(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->allow_extra_args(false)
      ->group(how);
  app->add_option("--threads", a->threads, "Threads; default: all. Results do not depend on it")
      ->type_name("N")
      ->check(CLI::Range(1, 4096))
      ->group(how);
  app->footer(
      "A number has its standard error in per cent behind it; a difference, how many standard errors it is.\n"
      "Exit codes: 0 all agree, 4 methods differ, or nothing could be judged in a band (the last lines say which), 2 "
      "bad input.\n\n"
      "Examples:\n"
      "  obscura verify -o verify.html\n"
      "  obscura verify smoke.json --passes 8\n"
      "  obscura verify --print sphere_day > sphere.json");
  return {app, [a] { return verify(*a); }};
}

}  // namespace obscura::cli
