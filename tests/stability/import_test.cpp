// Voxels that no cloud can have: every importer refuses them by grid and voxel, whatever the file's kind.
#include "octree/io/import.h"

#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/IO.h>
#include <netcdf.h>
#include <openvdb/openvdb.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "octree/base/error.h"
#include "octree/build/build.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/voxel_fields.h"

using namespace obscura;
using namespace obscura::test;

namespace {

using Path = std::filesystem::path;

/// Writes the value `bad` into voxel (1, 2, 1) of a small cloud of density 1.
using Writer = std::function<Path(const ScratchFolder&, float bad)>;

float value_at(int x, int y, int z, float bad) { return x == 1 && y == 2 && z == 1 ? bad : 1.0f; }

Path write_vdb(const ScratchFolder& folder, float bad) {
  openvdb::initialize();
  auto grid = openvdb::FloatGrid::create(0);
  grid->setName("density");
  for (int i = 0; i < 64; ++i) {
    const int x = i % 4, y = i / 4 % 4, z = i / 16;
    grid->tree().setValueOn(openvdb::Coord(x, y, z), value_at(x, y, z, bad));
  }
  openvdb::io::File(folder / "a.vdb").write({grid});
  return folder / "a.vdb";
}

Path write_nvdb(const ScratchFolder& folder, float bad) {
  nanovdb::GridBuilder<float> builder(0.0f, nanovdb::GridClass::FogVolume);
  auto accessor = builder.getAccessor();
  for (int i = 0; i < 64; ++i) {
    const int x = i % 4, y = i / 4 % 4, z = i / 16;
    accessor.setValue(nanovdb::Coord(x, y, z), value_at(x, y, z, bad));
  }
  nanovdb::io::writeGrid((folder / "a.nvdb").string(), builder.getHandle<>(1.0, nanovdb::Vec3d(0), "density"));
  return folder / "a.nvdb";
}

Path write_netcdf(const ScratchFolder& folder, float bad) {
  const Path path = folder / "a.nc";
  int file = 0, variable = 0, dimensions[3], axes[3];
  REQUIRE(nc_create(path.c_str(), NC_NETCDF4 | NC_CLOBBER, &file) == NC_NOERR);
  const char* names[] = {"z", "y", "x"};
  for (int a = 0; a < 3; ++a) {
    nc_def_dim(file, names[a], 4, &dimensions[a]);
    nc_def_var(file, names[a], NC_DOUBLE, 1, &dimensions[a], &axes[a]);
    nc_put_att_text(file, axes[a], "units", 1, "m");
  }
  nc_def_var(file, "density", NC_FLOAT, 3, dimensions, &variable);
  nc_enddef(file);
  const double points[] = {0, 1, 2, 3};
  for (const int axis : axes) nc_put_var_double(file, axis, points);
  std::vector<float> values;
  for (int i = 0; i < 64; ++i) values.push_back(value_at(i % 4, i / 4 % 4, i / 16, bad));
  nc_put_var_float(file, variable, values.data());
  REQUIRE(nc_close(file) == NC_NOERR);
  return path;
}

Path write_raw(const ScratchFolder& folder, float bad) {
  std::string bytes;
  for (int i = 0; i < 64; ++i) {
    const float value = value_at(i % 4, i / 4 % 4, i / 16, bad);
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  folder.write("a.raw", bytes);
  return folder.write("a.json", R"({"raw": "a.raw", "type": "float32", "resolution": [4, 4, 4], "order": "x-fastest",
                                    "voxel_m": [1, 1, 1], "origin_m": [0, 0, 0], "grid": "density"})");
}

Path write_les(const ScratchFolder& folder, float bad) {
  std::string text = "# c\n4,4,4\n0.02,0.02\n0.4,0.44,0.48,0.52\nx,y,z,density,reff\n";
  for (int i = 0; i < 64; ++i) {
    const int x = i % 4, y = i / 4 % 4, z = i / 16;
    text += std::to_string(x) + "," + std::to_string(y) + "," + std::to_string(z) + "," +
            std::to_string(value_at(x, y, z, bad)) + ",10\n";
  }
  return folder.write("a.txt", text);
}

std::string refusal(const Path& path, bool non_negative) {
  try {
    for (const VoxelStream& stream : open_volume(path, std::vector<GridRequest>{{"density", non_negative}})) {
      BuildSettings lossless;
      lossless.tolerance = 0;
      build_octree(stream, lossless);
    }
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("NaN, infinite and negative voxels are refused by every importer, by grid and voxel",
          "[stability][import][not_finite]") {
  const ScratchFolder folder;
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  const std::pair<const char*, Writer> kinds[] = {
      {".vdb", write_vdb}, {".nvdb", write_nvdb}, {".nc", write_netcdf}, {".json", write_raw}, {".txt", write_les}};
  for (const auto& [kind, write] : kinds) {
    INFO(kind);
    CHECK(refusal(write(folder, 0.5f), true) == "accepted");
    for (const float bad : {nan, -nan, infinity, -infinity, -1.0f, -1e-30f}) {
      if (std::string(kind) == ".txt" && bad == -1e-30f) continue;  // six digits
      INFO("value " << bad);
      const std::string told = refusal(write(folder, bad), true);
      CHECK_THAT(told, Catch::Contains("(1, 2, 1)"));
      CHECK_THAT(told, Catch::Contains("density"));
      // What may be negative, such as a temperature in degrees, still has to be a number.
      CHECK((refusal(write(folder, bad), false) == "accepted") == std::isfinite(bad));
    }
  }
}

TEST_CASE("NaN and infinite voxels from arrays do not become an octree", "[stability][import][not_finite]") {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    BuildSettings lossless;
    lossless.tolerance = 0;
    const VoxelStream stream = field_stream(Box3i(Vec3i(0), Vec3i(16)), {"density"},
                                            [bad](int, const Vec3i& v) { return v == Vec3i(9, 2, 3) ? bad : 1.0f; });
    CHECK_THROWS_AS(build_octree(stream, lossless), InputError);
    CHECK_THROWS_WITH(build_octree(stream, lossless), Catch::Contains("density") && Catch::Contains("(9, 2, 3)"));
  }
}
