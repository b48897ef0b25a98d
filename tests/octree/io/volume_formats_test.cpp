// The table of volume formats: what reading, messages and scenes take from it.
#include "octree/io/volume_formats.h"

#include <catch2/catch.hpp>
#include <set>

#include "octree/base/error.h"
#include "octree/io/import.h"
#include "tests/support/scratch_folder.h"

using namespace obscura;
using obscura::test::ScratchFolder;

TEST_CASE("every format has a name, an extension of its own and both functions", "[octree][import][formats]") {
  std::set<std::string> names, extensions;
  for (const VolumeFormat& format : volume_formats()) {
    INFO(format.name);
    CHECK(names.insert(format.name).second);
    CHECK(!format.extensions.empty());
    CHECK(format.inspect != nullptr);
    CHECK(format.open != nullptr);
    for (const std::string& extension : format.extensions) {
      CHECK(extension.front() == '.');
      CHECK(extensions.insert(extension).second);
      CHECK(volume_format_of("cloud" + extension) == &format);
    }
  }
  const std::vector<std::string> all = volume_extensions();
  CHECK(std::set<std::string>(all.begin(), all.end()) == extensions);
}

TEST_CASE("a file's format is told by its extension in any case", "[octree][import][formats]") {
  REQUIRE(volume_format_of("/some where/Smoke.VDB") != nullptr);
  CHECK(volume_format_of("/some where/Smoke.VDB") == volume_format_of("smoke.vdb"));
  CHECK(volume_format_of("smoke.vdb.xyz") == nullptr);
  CHECK(volume_format_of("smoke") == nullptr);
  CHECK(volume_format_of("") == nullptr);
}

TEST_CASE("a file of no known kind is refused with all that are", "[octree][import][formats]") {
  const ScratchFolder folder("formats");
  const std::filesystem::path file = folder.write("cloud.xyz", "1");
  for (const VolumeFormat& format : volume_formats()) {
    const std::string entry = format.name + " (" + format.extensions.front();
    CHECK_THAT(volume_format_list(), Catch::Contains(entry));
    CHECK_THROWS_WITH(inspect_volume(file), Catch::Contains("'.xyz'") && Catch::Contains(entry));
    CHECK_THROWS_AS(open_volume(file, std::vector<std::string>{"density"}), InputError);
  }
}
