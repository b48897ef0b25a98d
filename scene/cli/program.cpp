// Finds the command that is meant, runs it, and turns what went wrong into sentences and exit codes.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <new>
#include <optional>

#include "commands.h"
#include "console.h"
#include "scene/file/scene_schema.h"
#include "scene/file/scene_words.h"

namespace obscura::cli {
namespace {

const char* const kAbout =
    "Obscura computes what an infrared or visible sensor receives from a scene that holds clouds:\n"
    "radiance, transmission and apparent temperature in absolute units, each with its error.";

const char* const kFooter =
    "Examples:\n"
    "  obscura render smoke.json -o night.exr --preview night.png\n"
    "  obscura render smoke.json -o quick.exr --photons 1e5 --set /sensor/resolution=[80,60]\n"
    "  obscura plan smoke.json\n"
    "  obscura info cloud.vdb\n"
    "  obscura convert cloud.nc cloud.vdb --tolerance 0.1%\n"
    "  obscura export image.exr --envi image.hdr\n"
    "  obscura compare image.exr reference.exr\n"
    "  obscura verify smoke.json -o verify.html\n"
    "  obscura obscuration smoke.json --object truck -o truck.html\n"
    "  obscura study smoke.json -o study.html\n"
    "\n"
    "Units: metres, seconds, kelvin, micrometres; radiance W/m2/sr.\n"
    "Exit codes: 0 done, 2 bad input, 3 the machine's limits (disk, memory), 4 numbers not to be trusted.\n"
    "Help for one command: obscura render --help";

std::vector<std::string> names_of(const std::vector<Command>& commands) {
  std::vector<std::string> names;
  for (const Command& command : commands) names.push_back(command.app->get_name());
  return names;
}

// Arguments that CLI11 did not expect, each with what was probably meant.
std::vector<Problem> unexpected(const CLI::App& command) {
  std::vector<std::string> options;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
  }
  std::vector<Problem> problems;
  bool takes_next = false;  // what follows an unknown option is its value
  for (const std::string& argument : command.remaining()) {
    const bool value = takes_next && argument[0] != '-';
    takes_next = argument[0] == '-' && argument.find('=') == std::string::npos;
    if (argument[0] == '-') {
      const std::string option = argument.substr(0, argument.find('='));
      problems.push_back({option, "there is no such option", detail::suggest(option, options)});
    } else if (!value) {
      problems.push_back({argument, "this argument is one too many", "see obscura " + command.get_name() + " --help"});
    }
  }
  return problems;
}

int report(const std::vector<Problem>& problems) {
  print_problems(problems);
  return kBadInput;
}

// The first word is the command: say what is wrong with it before anything else is read.
std::optional<Problem> command_problem(int argc, char** argv, const std::vector<std::string>& names) {
  if (argc < 2 || argv[1][0] == '-') return {};
  const std::string word = argv[1];
  if (std::find(names.begin(), names.end(), word) != names.end()) return {};
  const auto& later = later_commands();
  if (std::find(later.begin(), later.end(), word) != later.end()) {
    return Problem{word, fmt::format("the command \"{}\" is not available yet", word),
                   fmt::format("available: {}", fmt::join(names, ", "))};
  }
  return Problem{word, "there is no such command", detail::suggest(word, names)};
}

int dispatch(int argc, char** argv) {
  CLI::App program(kAbout, "obscura");
  program.set_version_flag("--version", std::string("obscura ") + OBSCURA_VERSION, "Print the version");
  program.set_help_flag("-h,--help", "Print this help");
  program.footer(kFooter);
  const std::vector<Command> commands = {
      add_render(program), add_info(program),   add_convert(program),     add_compare(program), add_export(program),
      add_plan(program),   add_verify(program), add_obscuration(program), add_study(program),   add_schema(program)};
  const std::vector<std::string> names = names_of(commands);
  if (const auto problem = command_problem(argc, argv, names)) return report({*problem});
  try {
    program.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return program.exit(success);
  } catch (const CLI::ParseError& error) {
    for (const Command& command : commands) {
      if (!command.app->parsed()) continue;
      const std::vector<Problem> problems = unexpected(*command.app);
      if (!problems.empty()) return report(problems);
      return report({{command.app->get_name(), error.what(), "see obscura " + command.app->get_name() + " --help"}});
    }
    const std::vector<Problem> problems = unexpected(program);
    if (!problems.empty()) return report(problems);
    return report({{"", error.what(), "see obscura --help"}});
  }
  for (const Command& command : commands) {
    if (command.app->parsed()) return command.run();
  }
  fmt::print(stderr, "{}", program.help());
  return kBadInput;
}

}  // namespace

const std::vector<std::string>& later_commands() {
  static const std::vector<std::string> names = {"bake", "optics", "view"};
  return names;
}

Command add_schema(CLI::App& program) {
  CLI::App* app = program.add_subcommand("schema", "Print the JSON Schema of scene files, for editors");
  return {app, [] {
            std::fputs(scene_schema().c_str(), stdout);
            return static_cast<int>(kDone);
          }};
}

int run_program(int argc, char** argv) {
  try {
    return dispatch(argc, argv);
  } catch (const InputError& error) {
    return report(error.problems());
  } catch (const ResourceError& error) {
    fmt::print(stderr, "obscura: {}\n", error.what());
    return kResource;
  } catch (const NumericalError& error) {
    fmt::print(stderr, "obscura: {}\n", error.what());
    return kNumerical;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "obscura: there is not enough memory (make the scene smaller, or use fewer photons)\n");
    return kResource;
  } catch (const std::exception& error) {
    fmt::print(stderr, "obscura: unexpected failure: {}\n", error.what());
    return kResource;
  }
}

}  // namespace obscura::cli
