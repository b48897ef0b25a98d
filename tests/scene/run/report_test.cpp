#include "scene/run/report.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "octree/base/error.h"
#include "tests/support/scratch_folder.h"

using namespace obscura;

namespace {

Report example() {
  Report report;
  report.version = "0.1.0";
  report.plan = {{"sun", true, "there is one", {}}, {"scattering", false, "too thin", 1e-4}};
  report.energy = {{"lwir", {10, 6, 0, 3.9, 0.1}}};
  report.photons = {1000000, 123, 2952};
  report.octree = {{"smoke", 7, 100, 2048, 1e-3, 5e-4, std::numeric_limits<double>::infinity()}};
  report.peak_MiB = 12.5;
  report.time_s = {{"tracing", 0.1 + 0.2}};
  report.rays = {{"base", 64}};
  report.work = {{"emission", 12}};
  report.probes = {{"p", {{"lwir", {1.5, std::nan("")}}}}};
  report.flux = {{"top", {{"lwir", {2, 1, 0.1}}}}};
  report.warnings = {"the file \xff is odd"};
  report.footprint = {7, 20, 3, 30.5, 2e-4};
  report.partial = true;
  return report;
}

}  // namespace

TEST_CASE("the report holds what scene/FORMAT.md lists", "[scene][report]") {
  const auto json = nlohmann::json::parse(to_json(example()));
  CHECK(json["plan"][1]["bound"] == 1e-4);
  CHECK(json["plan"][0]["effect"] == "sun");
  CHECK(json["plan"][0]["on"] == true);
  CHECK(json["plan"][0]["reason"] == "there is one");
  const auto& energy = json["energy"]["lwir"];
  CHECK(energy["emitted_W"].get<double>() == energy["absorbed_W"].get<double>() + energy["surface_W"].get<double>() +
                                                 energy["escaped_W"].get<double>() +
                                                 energy["truncated_W"].get<double>());
  CHECK(json["photons"]["emitted"] == 1000000);
  CHECK(json["photons"]["stored"] == 123);
  CHECK(json["photons"]["bytes"] == 2952);
  for (const char* key : {"name", "leaves", "bytes", "bytes_dense", "tolerance", "error_measured", "error_bound"}) {
    CHECK(json["octree"][0].contains(key));
  }
  CHECK(json["footprint"]["rays"] == 7);
  CHECK(json["footprint"]["segments"] == 20);
  CHECK(json["footprint"]["coarse_cells"] == 3);
  CHECK(json["footprint"]["voxels"] == 30.5);
  CHECK(json["footprint"]["error_bound"] == 2e-4);
  CHECK(json["memory"]["peak_MiB"] == 12.5);
  CHECK(json["rays"]["base"] == 64);
  CHECK(json["work"]["emission"] == 12);
  CHECK(json["anomalies"].is_object());
  CHECK(json["probes"][0]["name"] == "p");
  CHECK(json["probes"][0]["lwir"]["fluence"] == 1.5);
  CHECK(json["flux"][0]["lwir"]["forward"] == 2);
  CHECK(json["flux"][0]["lwir"]["backward"] == 1);
  CHECK(json["warnings"].size() == 1);
  CHECK(json["partial"] == true);
}

TEST_CASE("a plan alone is an object with its rows", "[scene][report]") {
  const auto json = nlohmann::json::parse(to_json(example().plan));
  CHECK(json.is_object());
  CHECK(json.size() == 1);
  CHECK(json["plan"].size() == 2);
}

TEST_CASE("the report keeps every digit and writes null for what is not finite", "[scene][report]") {
  const auto json = nlohmann::json::parse(to_json(example()));
  CHECK(json["time_s"]["tracing"].get<double>() == 0.1 + 0.2);
  CHECK(json["octree"][0]["error_bound"].is_null());
  CHECK(json["probes"][0]["lwir"]["error"].is_null());
}

TEST_CASE("the report is written whole or not at all", "[scene][report]") {
  const obscura::test::ScratchFolder folder;
  write_report(folder / "r.json", example());
  CHECK(folder.file_count() == 1);
  std::ifstream stream(folder / "r.json");
  CHECK(nlohmann::json::parse(stream)["partial"] == true);
  CHECK_THROWS_AS(write_report(folder / "absent/r.json", example()), ResourceError);
}
