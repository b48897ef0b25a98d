#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <thread>

#include "tests/scene/full_scene.h"
#include "tests/support/places.h"
#include "tests/support/run_program.h"

using obscura::test::contains;
using obscura::test::Json;
using obscura::test::run_program;
using obscura::test::Said;

namespace {

const char* const kScene = R"({
  // a comment
  "obscura": 1,
  "bands": [{"name": "lwir", "um": [8, 12]}],
  "clouds": [{"grid": {"shape": "sphere", "radius_m": 1, "voxel_m": 0.25},
              "media": [{"extinction": 1, "albedo": 0.5}], "temperature": {"K": 300}}],
  "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "resolution": [8, 6], "max_oversampling": 2},
  "render": {"photons": 1000}
})";

struct Folder : obscura::test::SceneFolder {
  explicit Folder(const std::string& name) : SceneFolder("cli_" + name) { write("scene.json", kScene); }
  std::string file(const std::string& name) const { return (path() / name).string(); }
};

long lines_with(const std::string& text, const std::string& part) {
  std::istringstream stream(text);
  long count = 0;
  for (std::string line; std::getline(stream, line);) count += contains(line, part) ? 1 : 0;
  return count;
}

}  // namespace

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

TEST_CASE("info shows the grids of a volume and what their octrees cost", "[doors][cli]") {
  const std::filesystem::path file = obscura::test::shared_path("data/openvdb_smoke1/smoke.vdb");
  if (!std::filesystem::exists(file)) {
    WARN("SKIPPED: " << file << " is absent");
    return;
  }
  const Said said = run_program("info '" + file.string() + "' --tolerance 0");
  INFO(said.out << said.err);
  CHECK(said.exit_code == 0);
  for (const char* part : {"density", "to metres", "values", "voxels of", "of dense", "leaves", "built in"}) {
    CHECK(contains(said.out, part));
  }
  CHECK(run_program("info /absent.vdb").exit_code == 2);
}

TEST_CASE("info says that nothing is in an empty volume, and which option is wrong", "[doors][cli]") {
  const Folder folder("info");
  folder.write("empty.u8", std::string(4 * 4 * 4, '\0'));
  folder.write("empty.json", R"({"raw": "empty.u8", "type": "uint8", "resolution": [4, 4, 4], "voxel_m": [1, 1, 1]})");
  const std::string command = "info '" + folder.file("empty.json") + "' ";
  Said said = run_program(command);
  INFO(said.out << said.err);
  CHECK(said.exit_code == 0);
  CHECK(contains(said.out, "no leaves"));
  said = run_program(command + "--tolerance 5");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "--tolerance: a transmission cannot be wrong by 1"));
  said = run_program(command + "--tolerance 0 --tolerance 0");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "obscura: info: --tolerance"));
}

TEST_CASE("convert writes OpenVDB and says the error it made", "[doors][cli]") {
  const Folder folder("convert");
  std::ofstream raw(folder.file("ramp.f32"), std::ios::binary);
  for (int i = 0; i < 16 * 8 * 8; ++i) {
    const float value = static_cast<float>(i % 16) + 0.001F * static_cast<float>(i % 7);
    raw.write(reinterpret_cast<const char*>(&value), sizeof value);
  }
  raw.close();
  folder.write("ramp.json", R"({"raw": "ramp.f32", "type": "float32", "resolution": [16, 8, 8], "order": "x-fastest",
                                "voxel_m": [1, 1, 1], "origin_m": [0, 0, 0], "grid": "density"})");
  const std::string command = "convert '" + folder.file("ramp.json") + "' '" + folder.file("ramp.vdb") + "' ";
  Said said = run_program(command);
  INFO(said.out << said.err);
  CHECK(said.exit_code == 0);
  CHECK(contains(said.out, "error: none"));
  said = run_program(command);
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "-f replaces it"));
  said = run_program("info '" + folder.file("ramp.vdb") + "' --tolerance 0");
  CHECK(contains(said.out, "density"));
  CHECK(contains(said.out, "to 15.006"));  // the largest of the ramp's values
  said = run_program(command + "-f --tolerance 1%");
  INFO(said.out << said.err);
  CHECK(said.exit_code == 0);
  CHECK(contains(said.out, "optical depth 5"));
  CHECK(contains(said.out, "measured on"));
  said = run_program("convert '" + folder.file("ramp.vdb") + "' '" + folder.file("ramp.vdb") + "' -f");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "would replace an input"));
  said = run_program(command + "-f --grid smoke");
  CHECK(said.exit_code == 2);
  CHECK(contains(said.err, "density"));
}

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

TEST_CASE("the schema can be printed", "[doors][cli]") {
  const Said said = run_program("schema");
  CHECK(said.exit_code == 0);
  CHECK(Json::parse(said.out)["properties"].contains("sensor"));
}

TEST_CASE("verify compares the methods on a user's scene and on cases by name", "[doors][cli][verify]") {
  const Folder folder("verify");
  const std::string scene = "verify '" + folder.file("scene.json") + "' --passes 2 --pixels 6 ";
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
