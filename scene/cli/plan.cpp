// obscura plan: which effects a scene calls for, why, and what they will cost.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "commands.h"
#include "console.h"
#include "edits.h"
#include "quantities.h"
#include "scene/file/scene_io.h"
#include "scene/run/report.h"
#include "scene/session/session.h"

namespace obscura::cli {
namespace {

struct PlanArguments {
  std::string scene, target_error, time, method;
  std::vector<std::string> set, effects;
  bool json = false, quiet = false;
};

std::vector<SceneEdit> edits_of(const PlanArguments& a, std::vector<Problem>& problems) {
  std::vector<SceneEdit> edits = set_edits(a.set, problems);
  const auto number = [&](const char* option, const char* pointer, const std::string& text,
                          double (*parse)(const std::string&, const std::string&)) {
    if (text.empty()) return;
    try {
      edits.push_back({pointer, fmt::format("{}", parse(text, option)), option});
    } catch (const InputError& error) {
      problems.insert(problems.end(), error.problems().begin(), error.problems().end());
    }
  };
  if (!a.target_error.empty()) edits.push_back({"/render/target_error", a.target_error, "--target-error"});
  number("--time", "/time_s", a.time, parse_seconds);
  if (!a.method.empty()) edits.push_back({"/render/method", a.method, "--method"});
  const std::vector<SceneEdit> forced = effect_edits(a.effects, problems);
  edits.insert(edits.end(), forced.begin(), forced.end());
  return edits;
}

std::string percent(double fraction) { return fmt::format("{:.2g} %", 100 * fraction); }

std::string seconds_text(double s) {
  return s < 0.095 ? fmt::format("{:.0f} ms", 1000 * s)
         : s < 100 ? fmt::format("{:.2g} s", s)
                   : fmt::format("{:.0f} s", s);
}

std::string table_of(const Plan& plan) {
  std::string text = fmt::format("{:<20} {:<4} {:>9} {:>8}  {}\n", "effect", "", "bound", "cost", "why");
  for (const PlanRow& row : plan.effects) {
    text += fmt::format("{:<20} {:<4} {:>9} {:>8}  {}\n", row.effect, row.on ? "on" : "off",
                        row.bound ? *row.bound > 0 ? fmt::format("{:.1e}", *row.bound) : "0" : "",
                        row.cost_s ? seconds_text(*row.cost_s) : "", row.reason);
  }
  const char* const used = plan.method.type->word;
  const char* const cheaper = plan.choice.cheaper->word;
  text += fmt::format("\nmethod  {}: {}; with the scene's settings, photon {} and path {} on one core\n", cheaper,
                      plan.choice.reason, seconds_text(plan.choice.photon_s), seconds_text(plan.choice.path_s));
  if (std::string_view(used) != cheaper)
    text += fmt::format("        the scene is rendered by {}; --method {} takes the other\n", used, cheaper);
  text += fmt::format("budget  image error {}: {} for what is left out, {} for what is sampled\n",
                      percent(plan.budget.total), percent(plan.budget.dropped), percent(plan.budget.sampled));
  return text;
}

int plan(const PlanArguments& a) {
  std::vector<Problem> problems;
  const std::vector<SceneEdit> edits = edits_of(a, problems);
  std::optional<Description> scene;
  collect(problems, [&] { scene = read_scene(a.scene, edits); });
  if (!problems.empty()) throw InputError(std::move(problems));

  catch_interrupts();
  Console console(a.quiet);
  Session session(*scene, scene->time_s, console.progress());
  console.finish();
  std::vector<std::string> warnings = scene->warnings;
  warnings.insert(warnings.end(), session.plan().warnings.begin(), session.plan().warnings.end());
  print_warnings(warnings);
  fmt::print("{}", a.json ? to_json(session.plan().effects) : table_of(session.plan()));
  return kDone;
}

}  // namespace

Command add_plan(CLI::App& program) {
  CLI::App* app = program.add_subcommand("plan", "Say which effects a scene calls for, why, and what they will cost");
  const auto a = std::make_shared<PlanArguments>();
  app->add_option("scene", a->scene, "Scene file")->required()->type_name("SCENE");
  app->add_flag("--json", a->json, "{\"plan\": [...]} in place of the table");
  app->add_flag("--quiet", a->quiet, "No progress; warnings and errors stay");
  const char* const edits = "In place of the scene's";
  app->add_option("--target-error", a->target_error,
                  "Error that is allowed: 0.03, 3%, or of temperature 20mK; default 0.1%")
      ->type_name("E")
      ->group(edits);
  app->add_option("--time", a->time, "The picture's time: seconds, or 30s, 5min")->type_name("S")->group(edits);
  app->add_option("--method", a->method, "How scattering is found: photon, path or ordinates; default: what is cheaper")
      ->type_name("M")
      ->group(edits);
  add_effect_option(*app, a->effects)->group(edits);
  app->add_option("--set", a->set, "Change any value of the scene; may be repeated")
      ->type_name("/POINTER=VALUE")
      ->type_size(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->allow_extra_args(false)
      ->group(edits);
  app->footer(
      "bound: the image error that leaving the effect out can cause; 0: provably none. cost: of one core, by a model.\n"
      "What is left out on bounds may use a tenth of the target error together.\n\n"
      "Examples:\n"
      "  obscura plan smoke.json\n"
      "  obscura plan smoke.json --target-error 3% --effect atmosphere=on");
  return {app, [a] { return plan(*a); }};
}

}  // namespace obscura::cli
