// What can hardly be meant is told of with its number and a remedy; its plausible twin is not.
#include "scene/plan/plausible.h"

#include <netcdf.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>

#include "octree/base/error.h"
#include "scene/file/scene_io.h"
#include "scene/hiding/obscuration.h"
#include "scene/run/run.h"
#include "scene/session/session.h"
#include "scene/study/study_bench.h"
#include "tests/scene/full_scene.h"

using namespace obscura;
using namespace obscura::test;
using Catch::Contains;

namespace {

/// What a scene has beside its sensor, as JSON; a sphere of one metre about the origin.
struct Wish {
  std::string band = R"({"name": "lwir", "um": [8, 12]})";
  std::string grid = R"({"shape": "sphere", "radius_m": 1, "voxel_m": 0.25})";
  std::string medium = R"({"extinction": 1})";
  std::string cloud = R"("temperature": {"K": 300})";
  std::string sensor = R"("position_m": [0, -10, 0], "look_at_m": [0, 0, 0])";
  std::string more = {};
};

std::string text_of(const Wish& wish) {
  std::string text = R"({"obscura": 1, "bands": [)" + wish.band + R"(], "clouds": [{"name": "smoke", "grid": )" +
                     wish.grid + R"(, "media": [)" + wish.medium + "]";
  if (!wish.cloud.empty()) text += ", " + wish.cloud;
  text += R"(}], "sensor": {)" + wish.sensor + R"(, "resolution": [8, 6], "max_oversampling": 2})";
  return text + (wish.more.empty() ? "" : ", " + wish.more) + "}";
}

std::vector<std::string> warnings_of(const Wish& wish, const std::filesystem::path& folder = ".") {
  return Session(parse_scene(text_of(wish), folder), 0).plan().warnings;
}

std::string only(const std::vector<std::string>& warnings) {
  REQUIRE(warnings.size() == 1);
  return warnings.front();
}

/// Cells of 1 m, x fastest, beside the description that a scene names.
void write_raw(const ScratchFolder& folder, const std::string& name, const std::vector<float>& density,
               const std::vector<float>& temperature) {
  Json grids = Json::array();
  const auto add = [&](const std::string& grid, const std::vector<float>& values) {
    const std::string file = name + "." + grid;
    folder.write(file, std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)));
    grids.push_back({{"raw", file}, {"type", "float32"}, {"resolution", {2, 2, 2}}, {"grid", grid}});
  };
  add("density", density);
  add("temperature", temperature);
  folder.write(name, grids.dump());
}

/// Two variables over 2 x 2 x 2 cells of 1 m with units of their own; an empty unit is not written.
void write_netcdf(const std::filesystem::path& file, const std::string& density_units,
                  const std::string& temperature_units, double temperature) {
  int id = 0;
  std::array<int, 3> dimensions{}, axes{};
  REQUIRE(nc_create(file.c_str(), NC_NETCDF4 | NC_CLOBBER, &id) == NC_NOERR);
  const auto give_units = [id](int variable, const std::string& units) {
    if (!units.empty()) nc_put_att_text(id, variable, "units", units.size(), units.c_str());
  };
  for (std::size_t a = 0; a < 3; ++a) {
    const std::string name(1, "zyx"[a]);
    nc_def_dim(id, name.c_str(), 2, &dimensions[a]);
    nc_def_var(id, name.c_str(), NC_DOUBLE, 1, &dimensions[a], &axes[a]);
    give_units(axes[a], "m");
  }
  std::array<int, 2> variables{};
  nc_def_var(id, "q", NC_FLOAT, 3, dimensions.data(), &variables[0]);
  nc_def_var(id, "T", NC_FLOAT, 3, dimensions.data(), &variables[1]);
  give_units(variables[0], density_units);
  give_units(variables[1], temperature_units);
  nc_enddef(id);
  const std::array<double, 2> points{0, 1};
  for (const int axis : axes) nc_put_var_double(id, axis, points.data());
  const std::vector<double> density(8, 1.0), kelvin(8, temperature);
  nc_put_var_double(id, variables[0], density.data());
  nc_put_var_double(id, variables[1], kelvin.data());
  REQUIRE(nc_close(id) == NC_NOERR);
}

std::string file_grid(const std::string& name) { return R"({"file": ")" + name + R"("})"; }

const std::string kThermalGrid = R"("temperature": {"grid": "temperature")";

}  // namespace

TEST_CASE("a plausible scene has no warnings", "[scene][plausible]") { CHECK(warnings_of({}).empty()); }

TEST_CASE("a temperature in degrees Celsius is told of where the band is thermal", "[scene][plausible]") {
  CHECK_THAT(only(warnings_of({.cloud = R"("temperature": {"K": 26.9})"})),
             Contains("/clouds/0/temperature/K is 26.9") && Contains("\"lwir\"") && Contains("degC? Give 300.05"));
  CHECK_THAT(only(warnings_of({.cloud = R"("temperature": {"K": 30000})"})), Contains("30000") || Contains("3e+04"));
  CHECK(warnings_of({.cloud = R"("temperature": {"K": 100})"}).empty());
  CHECK(warnings_of({.cloud = R"("temperature": {"K": 10000})"}).empty());
  // In the visible nothing at 300 K shines either.
  CHECK(warnings_of({.band = R"({"um": [0.4, 0.7]})", .cloud = R"("temperature": {"K": 26.9})"}).empty());
  // A source takes the temperature's place.
  CHECK(warnings_of({.cloud = R"("source": 1, "temperature": {"K": 26.9})"}).empty());
}

TEST_CASE("the hottest voxel is that of a grid where there is matter", "[scene][plausible]") {
  const ScratchFolder folder("plausible");
  // Where nothing is, no temperature counts.
  write_raw(folder, "cool.json", {1, 1, 1, 1, 1, 1, 1, 0}, {20, 26.9f, 20, 20, 20, 20, 20, 400});
  write_raw(folder, "warm.json", {1, 1, 1, 1, 1, 1, 1, 0}, {290, 300, 290, 290, 290, 290, 290, 0});
  const auto with = [&](const std::string& file, const std::string& keys) {
    return warnings_of({.grid = file_grid(file), .cloud = kThermalGrid + keys + "}"}, folder.path());
  };
  CHECK_THAT(only(with("cool.json", "")), Contains("cloud \"smoke\": its hottest voxel has 26.9 K") &&
                                              Contains("\"temperature\" in degC") &&
                                              Contains("/clouds/0/temperature/offset_K as 273.15"));
  CHECK(with("cool.json", R"(, "offset_K": 273.15)").empty());
  CHECK(with("warm.json", "").empty());
  CHECK_THAT(only(with("warm.json", R"(, "scale": 100)")), Contains("3e+04 K") && Contains("scale (100)"));
  CHECK_THAT(only(with("warm.json", R"(, "scale": 0.01, "offset_K": 5)")), Contains("8 K") && Contains("offset_K (5)"));
  // All of it below the freezing point.
  write_raw(folder, "frost.json", {1, 1, 1, 1, 1, 1, 1, 1}, {-10, -10, -10, -10, -10, -10, -10, -10});
  CHECK(with("frost.json", R"(, "offset_K": 273.15)").empty());
  CHECK_THAT(only(with("frost.json", R"(, "offset_K": 1)")), Contains("-9 K"));
  write_raw(folder, "none.json", {1, 1, 1, 1, 1, 1, 1, 1}, {0, 0, 0, 0, 0, 0, 0, 0});
  CHECK_THAT(only(with("none.json", "")), Contains("hold nothing where the density is"));
}

TEST_CASE("wavelengths in nanometres and wavenumbers are told of at their place", "[scene][plausible]") {
  const std::string K = R"("temperature": {"K": 300})";
  CHECK_THAT(only(warnings_of({.band = R"({"um": [8000, 12000]})", .cloud = K})),
             Contains("/bands/0/um: wavelengths of 8000 to 12000 um") && Contains("give 8 to 12;"));
  CHECK_THAT(only(warnings_of({.band = R"({"um": [833, 1250]})", .cloud = K})), Contains("8 to 12"));
  CHECK_THAT(only(warnings_of({.medium = R"({"extinction": {"um": [8000, 12000], "value": [1, 2]}})"})),
             Contains("/clouds/0/media/0/extinction: wavelengths of 8000 to 12000 um"));
  CHECK(warnings_of({.band = R"({"um": [100, 1000]})"}).empty());
  CHECK(warnings_of({.medium = R"({"extinction": {"um": [8, 12], "value": [1, 2]}})"}).empty());
}

namespace {

/// Pointers of all values of a scene, of those within others too.
std::vector<std::string> all_pointers(const Json& json, const std::string& at = "") {
  std::vector<std::string> pointers;
  if (!json.is_structured()) return pointers;
  for (const auto& [key, value] : json.items()) {
    const std::string here = at + "/" + key;
    pointers.push_back(here);
    const std::vector<std::string> inside = all_pointers(value, here);
    pointers.insert(pointers.end(), inside.begin(), inside.end());
  }
  return pointers;
}

}  // namespace

TEST_CASE("every key that takes a spectral table is looked at for its wavelengths", "[scene][plausible]") {
  const SceneFolder folder("plausible");
  int spectral = 0;
  for (const Json& scene : all_scenes()) {
    for (const std::string& pointer : all_pointers(scene)) {
      std::vector<std::string> warnings;
      try {
        warnings = detail::implausible_wavelengths(
            parse_scene(scene.dump(), folder.path(), {{pointer, R"({"um": [1, 2000], "value": [0.5, 0.25]})", ""}}));
      } catch (const InputError&) {
        continue;  // takes no table
      }
      INFO(pointer);
      ++spectral;
      CHECK_THAT(only(warnings), Catch::StartsWith(pointer + ": "));
    }
  }
  CHECK(spectral >= 15);
}

TEST_CASE("a cloud that no ray feels and one that is a wall are told of by their depth", "[scene][plausible]") {
  const auto with = [](const std::string& extinction, const std::string& more = R"("temperature": {"K": 300})") {
    return warnings_of({.medium = R"({"extinction": )" + extinction + "}", .cloud = more});
  };
  CHECK_THAT(only(with("1e-6")), Contains("cloud \"smoke\"") && Contains("an optical depth of") &&
                                     Contains("e-06 at most, in band \"lwir\"") && Contains("factor of 1000") &&
                                     Contains("/clouds/0/media/0/extinction"));
  CHECK(with("1e-4").empty());  // 2 m deep
  CHECK(with("1e5").empty());
  CHECK_THAT(only(with("1e7")), Contains("up to") && Contains("e+07") && Contains("0.001"));
  // Nothing that is meant: a glow without extinction, a band in which a gas is clear.
  CHECK(with("0", R"("emission": 1)").empty());
  CHECK(with("1e-9", R"("emission": 1)").empty());
  const std::string gas = R"({"extinction": {"um": [4, 5, 6], "value": [1, 1, 1e-9]}})";
  CHECK(warnings_of({.band = R"({"um": [3, 5]}, {"um": [8, 12]})", .medium = gas}).empty());
}

TEST_CASE("a periodic cloud is judged by one period", "[scene][plausible]") {
  const auto with = [](const std::string& extinction) {
    return warnings_of({.grid = R"({"shape": "box", "size_m": [2, 2, 2], "voxel_m": 0.5})",
                        .medium = R"({"extinction": )" + extinction + "}",
                        .cloud = R"("periodic": ["x", "y"], "temperature": {"K": 300})"});
  };
  CHECK(with("1").empty());
  CHECK_THAT(only(with("1e-7")), Contains("does not show"));
  CHECK_THAT(only(with("1e7")), Contains("wall"));
}

TEST_CASE("a cloud without any density is told of in words of its own", "[scene][plausible]") {
  const ScratchFolder folder("plausible");
  write_raw(folder, "empty.json", std::vector<float>(8, 0), std::vector<float>(8, 20));
  write_raw(folder, "one.json", {0, 0, 0, 0, 0, 0, 0, 1}, std::vector<float>(8, 300));
  const auto with = [&](const std::string& file) {
    return warnings_of({.grid = file_grid(file), .cloud = kThermalGrid + "}"}, folder.path());
  };
  CHECK_THAT(only(with("empty.json")),
             Contains("no voxel of its density (\"density\") is above 0: the cloud is not there"));
  CHECK(with("one.json").empty());
}

TEST_CASE("a sensor that looks at nothing of the scene is told where everything is", "[scene][plausible]") {
  const std::string away = R"("position_m": [0, -10, 0], "look_at_m": [0, -20, 0])";
  CHECK_THAT(only(warnings_of({.sensor = away})), Contains("/sensor: no ray meets a cloud, an object or a source") &&
                                                      Contains("between (-1, -1, -1) and (1, 1, 1) m") &&
                                                      Contains("(0, -10, 0)"));
  // Kilometres beside metres.
  CHECK(warnings_of({.sensor = R"("position_m": [0, -0.010, 5], "look_at_m": [0, 0, 5])"}).size() == 1);
  CHECK(warnings_of(
            {.sensor =
                 R"("projection": "orthographic", "width_m": 2, "position_m": [5, -10, 0], "look_at_m": [5, 0, 0])"})
            .size() == 1);
  // One thing in view is enough, if it is as small as a point between two rays; so is the sun itself.
  for (const char* thing :
       {R"("objects": [{"shape": "sphere", "radius_m": 0.001, "place": {"translate_m": [0.1, -20, 0.1]}}])",
        R"("sources": [{"position_m": [0.1, -20, 0.1], "radius_m": 0.001, "K": 900}])",
        R"("environment": {"sun": {"toward": [0, -1, 0], "irradiance": 1}})"}) {
    INFO(thing);
    CHECK(warnings_of({.sensor = away, .more = thing}).empty());
  }
  CHECK(warnings_of({.sensor = away, .more = R"("environment": {"sky": {"K": 250}, "sun": {"toward": [0, 1, 0]}})"})
            .size() == 1);
  // A scene of sky alone has nothing to miss.
  const Description sky = parse_scene(R"({"obscura": 1, "bands": [{"um": [8, 12]}], "environment": {"sky": {"K": 250}},
    "sensor": {"position_m": [0, 0, 0], "look_at_m": [0, 1, 0]}})",
                                      ".");
  CHECK(Session(sky, 0).plan().warnings.empty());
}

TEST_CASE("an amount in kg/m3 beside an extinction in m2/g is told of with the factor", "[scene][plausible]") {
  const ScratchFolder folder("plausible");
  const auto with = [&](const std::string& units, const std::string& extinction) {
    write_netcdf(folder / "q.nc", units, "K", 300);
    return warnings_of({.grid = file_grid("q.nc"),
                        .medium = R"({"density": "q", "extinction": )" + extinction + "}",
                        .cloud = R"("temperature": {"grid": "T"})"},
                       folder.path());
  };
  for (const char* units : {"kg m-3", "kg/m3"}) {
    CHECK_THAT(only(with(units, "0.15")), Contains("cloud \"smoke\": its grid \"q\" is in " + std::string(units)) &&
                                              Contains("/clouds/0/media/0/extinction is 0.15") &&
                                              Contains("multiply it by 1000"));
    CHECK(with(units, "150").empty());
  }
  CHECK_THAT(only(with("kg kg-1", "0.15")),
             Contains("multiply it by 1000 times the air's density") && Contains("1200"));
  CHECK(with("kg kg-1", "180").empty());
  CHECK_THAT(only(with("mg m-3", "0.15")), Contains("multiply it by 0.001"));
  for (const char* units : {"g m-3", "", "1", "m-1"}) CHECK(with(units, "0.15").empty());
}

TEST_CASE("a grid of degrees that is taken for kelvin is told of by the file's own units", "[scene][plausible]") {
  const ScratchFolder folder("plausible");
  const auto with = [&](const std::string& units, double value, const std::string& keys = "") {
    write_netcdf(folder / "t.nc", "g m-3", units, value);
    return warnings_of({.grid = file_grid("t.nc"),
                        .medium = R"({"density": "q", "extinction": 0.5})",
                        .cloud = R"("temperature": {"grid": "T")" + keys + "}"},
                       folder.path());
  };
  // Hot enough to pass for kelvin.
  for (const double value : {26.85, 500.0}) {
    CHECK_THAT(only(with("degC", value)), Contains("its grid \"T\" is in degC, and offset_K is 0") &&
                                              Contains("/clouds/0/temperature/offset_K as 273.15"));
    CHECK(with("degC", value, R"(, "offset_K": 273.15)").empty());
    CHECK(with("celsius", value, R"(, "offset_K": 273)").empty());
  }
  CHECK_THAT(only(with("degF", 80)), Contains("as 255.372 and the scale as 0.5556"));
  CHECK(with("K", 300).empty());
  CHECK_THAT(only(with("K", 300, R"(, "offset_K": 273.15)")), Contains("573") && Contains("leave"));
  CHECK(with("K", 20, R"(, "offset_K": 273.15)").empty());  // a difference to 273.15 K
}

TEST_CASE("image, study and obscuration tell what the plan warns of", "[scene][plausible]") {
  const Description scene =
      parse_scene(text_of({.cloud = R"("temperature": {"K": 26.9})",
                           .more = R"("objects": [{"name": "box", "shape": "box", "size_m": [1, 1, 1], "K": 310},
                                      {"shape": "box", "size_m": [60, 1, 60], "K": 285, "place": {"translate_m": [0, 5, 0]}}],
                          "render": {"method": "path", "samples": 4})"}),
                  ".");
  const auto told = [](const std::vector<std::string>& warnings) {
    return std::ranges::count_if(warnings, [](const std::string& w) { return w.find("26.9") != std::string::npos; });
  };
  CHECK(scene.warnings.empty());
  CHECK(told(run_scene(scene, {}).report.warnings) == 1);
  CHECK(told(SessionBench(scene, 8, StudyClock::system(), {}).describe().warnings) == 1);
  ObscurationWish wish;
  wish.replicas = 2;
  wish.objects = {"box"};
  CHECK(told(find_obscuration(scene, wish).warnings) == 1);
}
