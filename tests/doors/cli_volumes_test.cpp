#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/doors/cli_folder.h"
#include "tests/support/places.h"
#include "tests/support/run_program.h"

using obscura::test::contains;
using obscura::test::Folder;
using obscura::test::run_program;
using obscura::test::Said;

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
