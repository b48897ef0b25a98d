#include <catch2/catch.hpp>
#include <fstream>
#include <string>

#include "tests/doors/cli_folder.h"
#include "tests/support/run_program.h"

using obscura::test::contains;
using obscura::test::Folder;
using obscura::test::Json;
using obscura::test::lines_with;
using obscura::test::run_program;
using obscura::test::Said;

TEST_CASE("help and version go to stdout and exit with 0", "[doors][cli]") {
  const Said help = run_program("--help");
  CHECK(help.exit_code == 0);
  CHECK(contains(help.out, "render"));
  CHECK(contains(help.out, "Examples:"));
  CHECK(contains(help.out, "Exit codes: 0"));
  CHECK(help.err.empty());
  const Said version = run_program("--version");
  CHECK(version.exit_code == 0);
  CHECK(contains(version.out, "obscura "));
  const Said render = run_program("render --help");
  CHECK(render.exit_code == 0);
  for (const char* option : {"--method", "--photons", "--samples", "--time", "--target-error", "--time-limit", "--seed",
                             "--threads", "--memory", "--set", "--report", "--preview", "--force", "--quiet"}) {
    INFO(option);
    CHECK(contains(render.out, option));
  }
}

TEST_CASE("a misspelt command or option is told what was meant", "[doors][cli]") {
  const Said command = run_program("rendr scene.json");
  CHECK(command.exit_code == 2);
  CHECK(contains(command.err, "did you mean \"render\""));
  const Said option = run_program("render scene.json -o a.exr --photon 5");
  CHECK(option.exit_code == 2);
  CHECK(contains(option.err, "--photon: there is no such option"));
  CHECK(contains(option.err, "--photons"));
  CHECK(run_program("").exit_code == 2);
  CHECK(run_program("render").exit_code == 2);
}

TEST_CASE("plan prints a table, or JSON and nothing else", "[doors][cli]") {
  const Folder folder("plan");
  const std::string scene = "plan '" + folder.file("scene.json") + "' --quiet";
  const Said table = run_program(scene);
  INFO(table.err);
  CHECK(table.exit_code == 0);
  for (const char* row : {"\nmultiple scattering", "\nmasking", "\nmethod  ", "\nbudget  image error 0.1 %"})
    CHECK(contains(table.out, row));
  const Said json = run_program(scene + " --json");
  CHECK(json.exit_code == 0);
  CHECK(json.out.rfind("{\n  \"plan\": [", 0) == 0);
  CHECK(contains(json.out, "\"cost_s\""));
  const Said forced = run_program(scene + " --effect absorption=off --json");
  CHECK(forced.exit_code == 0);
  CHECK(contains(forced.out, "forced off"));
  CHECK(contains(forced.err, "\"absorption\" is forced off"));
  const Said wrong = run_program(scene + " --effect absorbtion=on --effect sky=maybe");
  CHECK(wrong.exit_code == 2);
  CHECK(contains(wrong.err, "did you mean \"absorption\""));
  CHECK(contains(wrong.err, "=on or =off"));
}

TEST_CASE("later commands and options are refused by name", "[doors][cli]") {
  const Folder folder("later");
  for (const char* command : {"bake", "optics", "view"}) {
    const Said said = run_program(command);
    INFO(command);
    CHECK(said.exit_code == 2);
    CHECK(contains(said.err, std::string("\"") + command + "\" is not available yet"));
  }
  const auto told = [&](const std::string& option) {
    const Said said =
        run_program("render '" + folder.file("scene.json") + "' -o '" + folder.file("a.exr") + "' " + option);
    INFO(option << said.err);
    CHECK(said.exit_code == 2);
    CHECK(contains(said.err, option.substr(0, option.find(' '))));
    return said.err;
  };
  CHECK(contains(told("--memory 100"), "not available yet"));
  CHECK(contains(told("--method baked"), "allowed: photon, path, ordinates"));
  CHECK_FALSE(folder.has("a.exr"));
}

TEST_CASE("six mistakes are six lines with pointer, problem and remedy", "[doors][cli]") {
  const Folder folder("six");
  folder.write("six.json", R"({
    "obscura": 1,
    "bands": [{"name": "lwir", "um": [12, 8]}],
    "clouds": [{"grid": {"file": "absent.vdb"}, "media": [{"density": "density", "extinction": -1}]}],
    "sensor": {"position_m": [0, -10, 1], "look_at_m": [0, 0], "fov": 20},
    "render": {"photons": "many"}
  })");
  const Said said = run_program("render '" + folder.file("six.json") + "' -o '" + folder.file("six.exr") + "'");
  INFO(said.err);
  CHECK(said.exit_code == 2);
  CHECK(said.out.empty());
  for (const char* pointer : {"/bands/0/um", "/clouds/0/grid/file", "/clouds/0/media/0/extinction", "/sensor/look_at_m",
                              "/sensor/fov:", "/render/photons"}) {
    INFO(pointer);
    CHECK(lines_with(said.err, pointer) == 1);
  }
  CHECK(contains(said.err, "did you mean \"fov_deg\"?"));
  CHECK_FALSE(folder.has("six.exr"));
}

TEST_CASE("text that is not JSON is told with line and column", "[doors][cli]") {
  const Folder folder("json");
  folder.write("bad.json", "{\n  \"obscura\": 1,\n  \"bands\": [}\n");
  const Said said = run_program("render '" + folder.file("bad.json") + "' -o '" + folder.file("a.exr") + "'");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "bad.json: line 3, column 13"));
  const Said absent = run_program("render '" + folder.file("absent.json") + "' -o '" + folder.file("a.exr") + "'");
  CHECK(absent.exit_code == 2);
  CHECK(contains(absent.err, "there is no such file"));
}

TEST_CASE("outputs that exist are refused before any work, and inputs always", "[doors][cli]") {
  const Folder folder("outputs");
  const std::string scene = "render '" + folder.file("scene.json") + "' --set /render/photons=-1 ";
  // The scene's own mistake shows that all is told in one run.
  folder.write("a.exr", "precious");
  Said said = run_program(scene + "-o '" + folder.file("a.exr") + "'");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "-f replaces it"));
  CHECK(contains(said.err, "/render/photons"));
  folder.write("b.json", "precious");
  said = run_program(scene + "-o '" + folder.file("b.exr") + "'");
  CHECK(contains(said.err, "b.json\" exists"));
  said = run_program(scene + "-f -o '" + folder.file("scene.exr") + "'");  // its report would be the scene
  CHECK(contains(said.err, "would replace an input"));
  said = run_program(scene + "-o '" + folder.file("absent/a.exr") + "'");
  CHECK(contains(said.err, "does not exist"));
  said = run_program(scene + "-o '" + folder.file("a.png") + "'");
  CHECK(contains(said.err, "does not end in .exr"));
  std::ifstream stream(folder.file("a.exr"));
  std::string text;
  std::getline(stream, text);
  CHECK(text == "precious");
}

TEST_CASE("what an option changes is checked like the scene, and the option is named", "[doors][cli]") {
  const Folder folder("set");
  const std::string scene = "render '" + folder.file("scene.json") + "' -o '" + folder.file("a.exr") + "' ";
  Said said = run_program(scene + "--photons many --seed -1 --set /sensor/fov=5 --set /render/nearest=0");
  INFO(said.err);
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "/render/photons: expected a whole number, found the text \"many\", from --photons"));
  CHECK(contains(said.err, "/render/seed: -1 is out of range, from --seed"));
  CHECK(contains(said.err, "/sensor/fov: unknown key \"fov\", from --set"));
  CHECK(contains(said.err, "/render/nearest: 0 is out of range, from --set"));
  said = run_program(scene + "--set sensor=5 --set /sensor --time 5parsec");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "--set /sensor: there is no \"=\""));
  CHECK(contains(said.err, "a JSON pointer begins with"));
  CHECK(contains(said.err, "--time: \"5parsec\" is not a time"));
}

TEST_CASE("the schema can be printed", "[doors][cli]") {
  const Said said = run_program("schema");
  CHECK(said.exit_code == 0);
  CHECK(Json::parse(said.out)["properties"].contains("sensor"));
}
