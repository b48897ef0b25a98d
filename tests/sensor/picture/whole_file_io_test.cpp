// What is there stays whole until what comes is whole.
#include "sensor/picture/whole_file_io.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <ostream>
#include <stdexcept>

#include "octree/base/error.h"
#include "tests/support/scratch_folder.h"

using namespace obscura;
using obscura::test::ScratchFolder;

TEST_CASE("a file that fails on the way leaves the old one and nothing else", "[sensor][whole_file_io]") {
  const ScratchFolder folder;
  const auto path = folder.write("a.txt", "old");
  const auto text = [&] {
    std::ifstream file(path);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  CHECK_THROWS_AS(write_whole_stream(path,
                                     [](std::ostream& out) {
                                       out << "half";
                                       throw std::runtime_error("lost");
                                     }),
                  std::runtime_error);
  CHECK(text() == "old");
  CHECK_THROWS_AS(write_whole_stream(path, [](std::ostream& out) { out.setstate(std::ios::badbit); }), ResourceError);
  CHECK(text() == "old");
  CHECK(folder.file_count() == 1);
  write_whole_stream(path, [&](std::ostream& out) {
    out << "new";
    out.flush();
    CHECK(text() == "old");
  });
  CHECK(text() == "new");
  CHECK(folder.file_count() == 1);
}
