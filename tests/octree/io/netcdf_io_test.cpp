// NetCDF: the CF rules one by one on files made here, and the real fire files.
#include <netcdf.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "octree/base/error.h"
#include "octree/io/import.h"
#include "octree/io/netcdf_axes.h"
#include "tests/support/dense_stream.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shared_data.h"

using namespace obscura;
using namespace obscura::test;

namespace {

struct Axis {
  std::string name;
  std::vector<double> points;
  std::string units;
};

/// Writes one variable over the axes in their order; value(index per axis).
template <class F>
void write_file(const std::filesystem::path& path, const std::vector<Axis>& axes, nc_type type, F&& value,
                const std::vector<std::pair<std::string, double>>& attributes = {}) {
  int file = 0, variable = 0;
  REQUIRE(nc_create(path.c_str(), NC_NETCDF4 | NC_CLOBBER, &file) == NC_NOERR);
  std::vector<int> dimensions(axes.size()), coordinates(axes.size());
  std::size_t total = 1;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    REQUIRE(nc_def_dim(file, axes[a].name.c_str(), axes[a].points.size(), &dimensions[a]) == NC_NOERR);
    total *= axes[a].points.size();
    if (axes[a].units == "none") continue;
    nc_def_var(file, axes[a].name.c_str(), NC_DOUBLE, 1, &dimensions[a], &coordinates[a]);
    nc_put_att_text(file, coordinates[a], "units", axes[a].units.size(), axes[a].units.c_str());
  }
  nc_def_var(file, "smoke", type, static_cast<int>(axes.size()), dimensions.data(), &variable);
  for (const auto& [name, number] : attributes) {
    const nc_type attribute_type = name == "_FillValue" || name == "missing_value" ? type : nc_type(NC_DOUBLE);
    REQUIRE(nc_put_att_double(file, variable, name.c_str(), attribute_type, 1, &number) == NC_NOERR);
  }
  nc_enddef(file);
  for (std::size_t a = 0; a < axes.size(); ++a)
    if (axes[a].units != "none") nc_put_var_double(file, coordinates[a], axes[a].points.data());
  std::vector<double> values(total);
  std::vector<std::size_t> index(axes.size(), 0);
  for (double& v : values) {
    v = value(index);
    for (std::size_t a = axes.size(); a-- > 0;) {
      if (++index[a] < axes[a].points.size()) break;
      index[a] = 0;
    }
  }
  REQUIRE(nc_put_var_double(file, variable, values.data()) == NC_NOERR);
  REQUIRE(nc_close(file) == NC_NOERR);
}

std::vector<double> even(double first, double step, int n) {
  std::vector<double> points;
  for (int i = 0; i < n; ++i) points.push_back(first + step * i);
  return points;
}

const std::vector<std::string> kSmoke{"smoke"};

}  // namespace

TEST_CASE("a variable's dimensions may come in any order, in metres or kilometres", "[octree][import][netcdf]") {
  const ScratchFolder folder;
  const auto at = [](std::size_t x, std::size_t y, std::size_t z) { return 1.0 + double(x + 10 * y + 100 * z); };
  write_file(folder / "zyx.nc", {{"z", even(1, 0.5, 4), "m"}, {"y", even(0, 1, 9), "m"}, {"x", even(0, 2, 10), "m"}},
             NC_FLOAT, [&](const auto& i) { return at(i[2], i[1], i[0]); });
  write_file(folder / "xzy.nc",
             {{"x", even(0, 0.002, 10), "km"}, {"z", even(0.001, 0.0005, 4), "km"}, {"y", even(0, 0.001, 9), "km"}},
             NC_DOUBLE, [&](const auto& i) { return at(i[0], i[2], i[1]); });
  for (const char* name : {"zyx.nc", "xzy.nc"}) {
    const VoxelStream stream = open_volume(folder / name, kSmoke).at(0);
    CHECK(stream.bounds.max == Vec3i(10, 9, 4));
    // Coordinates are centres of cells.
    CHECK((transform_point(stream.index_to_local, Vec3d(0.5)) - Vec3d(0, 0, 1)).length() < 1e-9);
    CHECK((transform_point(stream.index_to_local, Vec3d(1.5)) - Vec3d(2, 1, 1.5)).length() < 1e-9);
    const Dense dense(stream);
    for (int z = 0; z < 4; ++z)
      for (int y = 0; y < 9; ++y)
        for (int x = 0; x < 10; ++x)
          REQUIRE(dense.at(0, {x, y, z}) == float(at(std::size_t(x), std::size_t(y), std::size_t(z))));
  }
}

TEST_CASE("packed values are unpacked and missing ones are nothing", "[octree][import][netcdf]") {
  const ScratchFolder folder;
  write_file(folder / "a.nc", {{"z", even(0, 1, 3), "m"}, {"y", even(0, 1, 3), "m"}, {"x", even(0, 1, 3), "m"}},
             NC_SHORT, [](const auto& i) { return i[2] == 0   ? -999.0
                                                  : i[2] == 1 ? -5.0
                                                              : 20.0; },
             {{"scale_factor", 0.5}, {"add_offset", 4}, {"_FillValue", -999}, {"missing_value", -5}});
  const Dense dense(open_volume(folder / "a.nc", kSmoke).at(0));
  CHECK(dense.at(0, {0, 1, 1}) == 0.0f);
  CHECK(dense.at(0, {1, 1, 1}) == 0.0f);
  CHECK(dense.at(0, {2, 1, 1}) == 14.0f);
}

TEST_CASE("a descending axis is turned round", "[octree][import][netcdf]") {
  const ScratchFolder folder;
  write_file(folder / "a.nc", {{"z", even(5, -1, 3), "m"}, {"y", even(0, 1, 3), "m"}, {"x", even(0, 1, 3), "m"}},
             NC_FLOAT, [](const auto& i) { return double(i[0] + 1); });
  const VoxelStream stream = open_volume(folder / "a.nc", kSmoke).at(0);
  CHECK((transform_point(stream.index_to_local, Vec3d(0.5)) - Vec3d(0, 0, 3)).length() < 1e-9);
  const Dense dense(stream);
  CHECK(dense.at(0, {0, 0, 0}) == 3.0f);
  CHECK(dense.at(0, {0, 0, 2}) == 1.0f);
}

TEST_CASE("uneven levels keep their mass on even cells", "[octree][import][netcdf]") {
  const ScratchFolder folder;
  const std::vector<double> levels{1, 2, 4, 8, 13};
  const std::vector<double> edges{0.5, 1.5, 3, 6, 10.5, 15.5};
  write_file(folder / "a.nc", {{"z", levels, "m"}, {"y", even(0, 1, 2), "m"}, {"x", even(0, 1, 2), "m"}}, NC_FLOAT,
             [](const auto& i) { return double(1 + i[0] * i[0]); });
  const VoxelStream stream = open_volume(folder / "a.nc", kSmoke).at(0);
  const Dense dense(stream);
  double mass = 0;
  for (std::size_t k = 0; k < 5; ++k) mass += 4 * double(1 + k * k) * (edges[k + 1] - edges[k]);
  CHECK(dense.sum(0) * linear_determinant(stream.index_to_local) == Approx(mass).epsilon(1e-6));
  CHECK(dense.at(0, {0, 0, 0}) == 1.0f);
  CHECK(dense.at(0, {0, 0, dense.size().z - 1}) == 17.0f);
}

TEST_CASE("a step of a time-dependent variable is chosen by its index", "[octree][import][netcdf]") {
  const ScratchFolder folder;
  write_file(
      folder / "a.nc",
      {{"time", even(0, 1, 4), "s"}, {"z", even(0, 1, 3), "m"}, {"y", even(0, 1, 3), "m"}, {"x", even(0, 1, 3), "m"}},
      NC_FLOAT, [](const auto& i) { return double(i[0] + 1); });
  CHECK(inspect_volume(folder / "a.nc").at(0).times == 4);
  CHECK(Dense(open_volume(folder / "a.nc", kSmoke).at(0)).max(0) == 1.0f);
  CHECK(Dense(open_volume(folder / "a.nc", std::vector<GridRequest>{{"smoke", true, false, 3}}).at(0)).max(0) == 4.0f);
  CHECK_THROWS_WITH(open_volume(folder / "a.nc", std::vector<GridRequest>{{"smoke", true, false, 4}}),
                    Catch::Contains("no step 4"));
}

TEST_CASE("the fire files are read", "[octree][import][netcdf]") {
  const auto file = shared_file("data/fds_steckler_room_fire/steckler.nc");
  if (!file.empty()) {
    const auto grids = inspect_volume(file);
    REQUIRE(grids.size() == 3);
    CHECK(grids[0].name == "temperature_code");
    CHECK(grids[0].type == "uint8");
    CHECK(grids[0].times == 101);
    CHECK(grids[0].resolution == Vec3i(37, 29, 23));
    CHECK(grids[0].voxel_m.x == Approx(0.1));
    CHECK(grids[0].voxel_m.z == Approx(0.0968).margin(1e-4));
    // The sister file in OpenVDB holds the decoded step 50: K = 293.15 + (code + 0.5) 1980 / 254.
    const auto vdb = shared_file("data/fds_steckler_room_fire/vdb/steckler.t050.vdb");
    const Dense codes(open_volume(file, std::vector<GridRequest>{{"co2_density_code", true, false, 50}}).at(0));
    if (!vdb.empty()) {
      const VoxelStream decoded = open_volume(vdb, std::vector<std::string>{"co2_density"}).at(0);
      CHECK(codes.sum(0) * 0.1 / 254 == Approx(Dense(decoded).sum(0)).epsilon(1e-5));
    }
  }
  const auto corridor = shared_file("data/fds_smoke_corridor_sequence/smoke_corridor.nc");
  if (!corridor.empty()) {
    CHECK(inspect_volume(corridor).size() == 4);
    const Dense dense(open_volume(corridor, std::vector<GridRequest>{{"soot_code", true, false, 120}}).at(0));
    CHECK(dense.size() == Vec3i(49, 37, 13));
    CHECK(dense.sum(0) > 0);
  }
}

TEST_CASE("profiles, maps and axes that are no lengths are refused", "[octree][import][netcdf]") {
  const auto profile = shared_file("data/atmosphere_profiles_afgl/AFGL_summer_mid_lat.nc");
  if (!profile.empty())
    CHECK_THROWS_WITH(inspect_volume(profile), Catch::Contains("no numeric variable over three axes"));

  const ScratchFolder folder;
  const auto one = [](const auto&) { return 1.0; };
  const auto write = [&](const Axis& x) {
    write_file(folder / "a.nc", {{"z", even(0, 1, 3), "m"}, {"y", even(0, 1, 3), "m"}, x}, NC_FLOAT, one);
  };
  write({"lon", even(0, 1, 3), "degrees_east"});
  CHECK_THROWS_WITH(open_volume(folder / "a.nc", kSmoke), Catch::Contains("degrees_east"));
  write({"x", even(0, 1, 3), "none"});
  CHECK_THROWS_WITH(open_volume(folder / "a.nc", kSmoke), Catch::Contains("no coordinate variable"));
  write({"x", {0, 1, 1}, "m"});
  CHECK_THROWS_WITH(open_volume(folder / "a.nc", kSmoke), Catch::Contains("neither ascends nor descends"));
  write({"x", {0}, "m"});
  CHECK_THROWS_WITH(open_volume(folder / "a.nc", kSmoke), Catch::Contains("one point"));
}

TEST_CASE("broken NetCDF files and values are refused", "[octree][import][netcdf][not_finite]") {
  const ScratchFolder folder;
  const std::vector<Axis> axes{{"z", even(0, 1, 3), "m"}, {"y", even(0, 1, 3), "m"}, {"x", even(0, 1, 40), "m"}};
  write_file(folder / "a.nc", axes, NC_FLOAT,
             [](const auto& i) { return i[2] == 7 && i[0] == 2 ? std::nan("") : 1.0; });
  CHECK_THROWS_WITH(Dense(open_volume(folder / "a.nc", kSmoke).at(0)),
                    Catch::Contains("'smoke'") && Catch::Contains("(7, 0, 2)") && Catch::Contains("NaN"));
  write_file(folder / "b.nc", axes, NC_FLOAT, [](const auto& i) { return i[2] == 7 ? -1.0 : 1.0; });
  CHECK_THROWS_WITH(Dense(open_volume(folder / "b.nc", kSmoke).at(0)), Catch::Contains("negative"));
  CHECK_THROWS_AS(open_volume(folder.write("c.nc", ""), kSmoke), InputError);
  CHECK_THROWS_AS(open_volume(folder.write("d.nc", "not a file of this kind at all"), kSmoke), InputError);
  const std::string whole = read_bytes(folder / "b.nc");
  CHECK_THROWS_AS(Dense(open_volume(folder.write("e.nc", whole.substr(0, whole.size() / 2)), kSmoke).at(0)),
                  InputError);
}
