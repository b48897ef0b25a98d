#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "tests/doors/cli_folder.h"
#include "tests/support/places.h"
#include "tests/support/run_program.h"

using obscura::test::contains;
using obscura::test::Folder;
using obscura::test::Json;
using obscura::test::lines_with;
using obscura::test::run_program;
using obscura::test::Said;

TEST_CASE("a scene becomes an image and a report", "[doors][cli]") {
  const Folder folder("render");
  const std::string command = "render '" + folder.file("scene.json") + "' -o '" + folder.file("a.exr") + "' ";
  Said said = run_program(command + "--quiet");
  INFO(said.out << said.err);
  CHECK(said.exit_code == 0);
  CHECK(said.err.empty());
  CHECK(folder.has("a.exr"));
  const Json report = Json::parse(std::ifstream(folder.file("a.json")));
  CHECK(report["photons"]["emitted"] == 1000);
  CHECK(report["partial"] == false);
  CHECK(run_program(command).exit_code == 2);  // both exist

  said = run_program(command + "-f --photons 2e3 --set /environment/sky/K=250 --time 1min --report '" +
                     folder.file("r.json") + "' --preview '" + folder.file("p.png") + "'");
  INFO(said.out << said.err);
  CHECK(said.exit_code == 0);
  const Json other = Json::parse(std::ifstream(folder.file("r.json")));
  CHECK(other["photons"]["emitted"] == 2000);
  CHECK(other["hash"] != report["hash"]);
  CHECK(folder.has("p.png"));
  said = run_program(command + "-f --threads 1 --seed 1");
  CHECK(Json::parse(std::ifstream(folder.file("a.json")))["energy"] == report["energy"]);

  const Said compared = run_program("compare '" + folder.file("a.exr") + "' '" + folder.file("a.exr") + "'");
  INFO(compared.out << compared.err);
  CHECK(compared.exit_code == 0);
  CHECK(contains(compared.out, "lwir.radiance"));
  CHECK(contains(compared.out, "image error: 0\n"));
  CHECK(run_program("compare '" + folder.file("a.exr") + "' /absent.exr").exit_code == 2);
}

TEST_CASE("render and export write ENVI, counts and tables of pixels", "[doors][cli][detector]") {
  const Folder folder("exports");
  const std::string command = "render '" + folder.file("scene.json") + "' -o '" + folder.file("a.exr") + "' ";
  // Everything that cannot be is told before any work.
  Said said = run_program(command + "--counts '" + folder.file("c.jpg") + "' --csv '" + folder.file("t.csv") +
                          "' --region 0,0,9,1 --envi '" + folder.file("e.hdr") + "' --quantity detector");
  INFO(said.out << said.err);
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "--counts: there are no counts"));
  CHECK(contains(said.err, "--set /sensor/detector/bits=14"));
  CHECK(contains(said.err, "does not end in .png or .tif"));
  CHECK(contains(said.err, "--region: it leaves the image of 8 x 6 pixels"));
  CHECK(contains(said.err, "--quantity: the bands will not all have a channel \"detector\""));
  said = run_program(command + "--line 0,0,7,5");
  CHECK(contains(said.err, "--line: it says which pixels --csv gets"));
  CHECK_FALSE(folder.has("a.exr"));

  said = run_program(command + "--set /sensor/detector/bits=12 --set /sensor/detector/range=[10,30] --set " +
                     "'/bands/1={\"name\": \"mwir\", \"um\": [3, 5]}' --counts '" + folder.file("c.png") + "' --csv '" +
                     folder.file("t.csv") + "' --line 0,0,7,5 --envi '" + folder.file("e.hdr") + "' --quantity counts");
  INFO(said.out << said.err);
  CHECK(said.exit_code == 0);
  for (const char* name : {"a.exr", "a.json", "c.png", "c.mwir.png", "t.csv", "e.hdr", "e.img"})
    CHECK(folder.has(name));
  CHECK(std::filesystem::file_size(folder.path() / "e.img") == 8 * 6 * 2 * 4);
  CHECK(contains(said.err, "the detector's range cuts"));  // 3 to 5 um has less than 10 W/m2/sr
  CHECK(Json::parse(std::ifstream(folder.file("a.json")))["detector"]["mwir"]["below_range"] == 48);

  const std::string other = "export '" + folder.file("a.exr") + "' ";
  said = run_program(other + "--csv '" + folder.file("u.csv") + "' --region 1,2,3,4 --counts '" + folder.file("c.tif") +
                     "'");
  INFO(said.out << said.err);
  CHECK(said.exit_code == 0);
  CHECK(folder.has("c.mwir.tif"));
  std::ostringstream table;
  table << std::ifstream(folder.file("u.csv")).rdbuf();
  CHECK(lines_with(table.str(), ",") == 13);
  CHECK(contains(table.str(), "lwir.counts"));
  said = run_program(other + "--csv '" + folder.file("u.csv") + "'");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "-f replaces it"));
  said = run_program(other + "--envi '" + folder.file("v.hdr") + "' --quantity radience");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "the image has no channel lwir.radience"));
  CHECK(contains(run_program(other).err, "nothing is asked for"));
}

TEST_CASE("warnings go to stderr even when quiet", "[doors][cli]") {
  const Folder folder("warnings");
  const Said said = run_program("render '" + folder.file("scene.json") + "' -o '" + folder.file("a.exr") +
                                "' --quiet --set /clouds/0/temperature=null");
  INFO(said.out << said.err);
  CHECK(said.exit_code == 0);
  CHECK(said.out.empty());
  CHECK(contains(said.err, "warning: cloud \"cloud1\" has no temperature: it does not emit in band \"lwir\""));
}

TEST_CASE("plan and render warn of a temperature in degrees Celsius, and so does the report", "[doors][cli]") {
  const Folder folder("celsius");
  const std::string scene = "'" + folder.file("scene.json") + "' --set /clouds/0/temperature/K=26.9 --quiet";
  const Said planned = run_program("plan " + scene);
  INFO(planned.out << planned.err);
  CHECK(planned.exit_code == 0);
  CHECK(contains(planned.err, "warning: cloud \"cloud1\": /clouds/0/temperature/K is 26.9"));
  const Said said = run_program("render " + scene + " -o '" + folder.file("a.exr") + "'");
  INFO(said.out << said.err);
  CHECK(said.exit_code == 0);
  CHECK(lines_with(said.err, "is it in degC? Give 300.05") == 1);
  const Json report = Json::parse(std::ifstream(folder.file("a.json")));
  REQUIRE(report["warnings"].size() == 1);
  CHECK(contains(report["warnings"][0], "is 26.9 in the thermal band"));
}

TEST_CASE("Ctrl-C writes what there is, marked partial", "[doors][cli]") {
  const Folder folder("interrupt");
  const std::string scene = folder.file("scene.json"), image = folder.file("a.exr"), log = folder.file("log");
  const std::string program = obscura::test::program_file();
  const pid_t child = fork();
  if (child == 0) {
    // Enough photons to be caught at work.
    if (std::freopen(log.c_str(), "w", stderr) && std::freopen("/dev/null", "w", stdout)) {
      execl(program.c_str(), program.c_str(), "render", scene.c_str(), "-o", image.c_str(), "--method", "photon",
            "--photons", "2e8", nullptr);
    }
    _exit(127);
  }
  REQUIRE(child > 0);
  // It works once it has said something, however long it takes to start here.
  for (int tries = 0; tries < 6000 && (!folder.has("log") || std::filesystem::file_size(log) == 0); ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  kill(child, SIGINT);
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  REQUIRE(folder.has("a.json"));
  CHECK(folder.has("a.exr"));
  CHECK(Json::parse(std::ifstream(folder.file("a.json")))["partial"] == true);
}
