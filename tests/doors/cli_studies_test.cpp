#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/doors/cli_folder.h"
#include "tests/support/run_program.h"

using obscura::test::contains;
using obscura::test::Folder;
using obscura::test::Json;
using obscura::test::lines_with;
using obscura::test::run_program;
using obscura::test::Said;

TEST_CASE("verify compares the methods on a user's scene and on cases by name", "[doors][cli][verify]") {
  const Folder folder("verify");
  const std::string scene = "verify '" + folder.file("scene.json") +
                            "' --passes 2 --pixels 6 --set /sensor/fov_deg=8 --set /render/photons=20000 ";
  Said said = run_program(scene + "-o '" + folder.file("a.html") + "'");
  INFO(said.out << said.err);
  CHECK(said.exit_code == 0);
  for (const char* part :
       {"case", "photon", "path", "ordinates", "mean", "photon bias", "verdict", "seconds", "all agree: "}) {
    CHECK(contains(said.out, part));
  }
  CHECK(folder.has("a.html"));
  said = run_program(scene + "-o '" + folder.file("a.html") + "'");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "-f replaces it"));
  said = run_program(scene + "--quiet --json");
  CHECK(said.err.empty());
  CHECK(Json::parse(said.out)["agree"] == true);
  // A comparison that is asked for more than it can tell fails.
  said = run_program(scene + "--resolution 0.01%");
  CHECK(said.exit_code == 4);
  CHECK(contains(said.out, "too weak"));
  CHECK(contains(said.err, "comparisons fail"));
}

TEST_CASE("verify lists its cases and prints them as scenes", "[doors][cli][verify]") {
  const Folder folder("verify_cases");
  Said said = run_program("verify --list");
  CHECK(said.exit_code == 0);
  CHECK(lines_with(said.out, "sphere_night") == 1);
  CHECK(lines_with(said.out, "puffs_day") == 1);
  said = run_program("verify --print sphere_day");
  CHECK(said.exit_code == 0);
  folder.write("printed.json", said.out);
  said = run_program("render '" + folder.file("printed.json") + "' -o '" + folder.file("a.exr") +
                     "' --quiet --photons 1000 --samples 1 --set /sensor/resolution=[4,4]");
  INFO(said.err);
  CHECK(said.exit_code == 0);
}

TEST_CASE("verify tells what is wrong with its arguments before any work", "[doors][cli][verify]") {
  const Folder folder("verify_wrong");
  Said said = run_program("verify --case spere_day");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "did you mean \"sphere_day\"?"));
  said = run_program("verify --print ball");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "there is no case \"ball\""));
  said = run_program("verify '" + folder.file("absent.json") + "' -o '" + folder.file("a.txt") + "'");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "there is no such file"));
  CHECK(contains(said.err, "does not end in .html"));
  said = run_program("verify '" + folder.file("scene.json") + "' --case cube_day");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "give a scene or cases"));
  said = run_program("verify --passes 0");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "--passes"));
}

TEST_CASE("obscuration tells what a cloud hides, on stdout and as page, JSON and CSV", "[doors][cli][obscuration]") {
  const Folder folder("obscuration");
  folder.write("hidden.json", R"({"obscura": 1, "name": "hidden & seen",
    "bands": [{"name": "lwir", "um": [8, 12]}],
    "clouds": [{"grid": {"shape": "box", "size_m": [4, 1, 4], "voxel_m": 1}, "media": [{"extinction": 3}], "temperature": {"K": 290},
                "place": {"translate_m": [0, -3, 0]}}],
    "objects": [{"name": "wall", "shape": "box", "size_m": [20, 1, 20], "K": 285, "place": {"translate_m": [0, 3, 0]}},
                {"name": "truck", "shape": "box", "size_m": [1, 1, 1], "K": 310}],
    "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "resolution": [16, 12], "max_oversampling": 4},
    "render": {"photons": 1000}})");
  const std::string command = "obscuration '" + folder.file("hidden.json") + "' --replicas 3 ";
  Said said = run_program(command + "--nedt 0.1 --threshold 10% -o '" + folder.file("p.html") + "' --json '" +
                          folder.file("r.json") + "' --csv '" + folder.file("t.csv") + "'");
  INFO(said.err);
  CHECK(said.exit_code == 0);
  CHECK(contains(said.out, "truck:"));
  CHECK(contains(said.out, "share with transmission <= 0.1"));
  CHECK(contains(said.out, "left out: wall reaches beyond the picture"));
  const Json json = Json::parse(std::ifstream(folder.file("r.json")));
  CHECK(json["objects"][0]["bands"]["lwir"]["share_obscured"]["value"] == 1);
  CHECK(std::abs(json["objects"][0]["bands"]["lwir"]["without"]["difference_K"]["value"].get<double>() - 25) < 0.01);
  const auto text_of = [&](const char* name) {
    std::ostringstream text;
    text << std::ifstream(folder.file(name)).rdbuf();
    return text.str();
  };
  CHECK(contains(text_of("t.csv"), "object,band,quantity,unit,case,value,low,high\n"));
  const std::string page = text_of("p.html");
  CHECK(contains(page, "hidden &amp; seen"));
  CHECK(contains(page, "data:image/png;base64,"));
  for (const char* outside : {"http", "src=\"/", "<script", "<link"}) CHECK_FALSE(contains(page, outside));

  said = run_program(command + "-o '" + folder.file("p.html") + "'");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "-f replaces it"));
  said = run_program(command + "--object trcuk --quiet");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "did you mean \"truck\""));
  said = run_program(command + "--threshold 2 --csv '" + folder.file("t.txt") + "'");
  CHECK(said.exit_code == 2);
  CHECK(lines_with(said.err, "--threshold") == 1);
  CHECK(lines_with(said.err, "--csv") == 1);
}

TEST_CASE("study writes page, numbers and plot, keeps its budget and what exists", "[doors][cli][study]") {
  const Folder folder("study");
  const std::string command = "study '" + folder.file("scene.json") + "' -o '" + folder.file("costs.html") + "' ";
  const auto begin = std::chrono::steady_clock::now();
  Said said = run_program(command + "--budget 3s --plot '" + folder.file("costs.svg") +
                          "' --set /sensor/resolution=[32,24] --pixels 16");
  INFO(said.err);
  CHECK(said.exit_code == 0);
  CHECK(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() < 20);
  CHECK(contains(said.out, "16 x 12 pixels for 32 x 24"));
  CHECK(contains(said.out, "reference: path tracer"));
  CHECK(contains(said.err, "path tracer, 1 sample"));
  const Json json = Json::parse(std::ifstream(folder.file("costs.json")));
  CHECK(json["budget_s"] == 3);
  CHECK(json["runs"].size() > 3);
  CHECK(json["partial"] == false);
  for (const char* name : {"costs.html", "costs.csv", "costs.svg"})
    CHECK(std::filesystem::file_size(folder.file(name)) > 500);

  said = run_program(command + "--budget 1s");
  CHECK(said.exit_code == 2);
  CHECK(lines_with(said.err, "-f replaces it") == 3);
  // Its JSON would be the scene.
  said = run_program("study '" + folder.file("scene.json") + "' -f -o '" + folder.file("scene.html") + "'");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "would replace an input"));
  said = run_program(command + "-f --budget 0 --pixels 16");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "--budget"));
  said = run_program(command + "-f --quiet --budget 2s --markdown");
  CHECK(said.exit_code == 0);
  CHECK(contains(said.out, "| error | cheapest setting"));
}
