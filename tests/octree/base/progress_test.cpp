#include "octree/base/progress.h"

#include <catch2/catch.hpp>
#include <string>

using namespace obscura;

TEST_CASE("progress reaches its listener and cancellation its worker", "[base][progress]") {
  std::string heard;
  std::atomic<bool> stop{false};
  const Progress progress(
      [&](std::string_view stage, std::uint64_t done, std::uint64_t total) {
        heard = std::string(stage) + " " + std::to_string(done) + "/" + std::to_string(total);
      },
      &stop);
  progress.report("build", 3, 8);
  CHECK(heard == "build 3/8");
  CHECK_FALSE(progress.cancelled());
  stop = true;
  CHECK(progress.cancelled());
}

TEST_CASE("progress without a listener is silent and never cancelled", "[base][progress]") {
  const Progress progress;
  progress.report("build", 1, 0);
  CHECK_FALSE(progress.cancelled());
}

TEST_CASE("a part of a stage reports its share of the whole", "[base][progress]") {
  std::string heard;
  std::atomic<bool> stop{false};
  const Progress whole(
      [&](std::string_view stage, std::uint64_t done, std::uint64_t total) {
        heard = std::string(stage) + " " + std::to_string(done) + "/" + std::to_string(total);
      },
      &stop);
  const Progress part = whole.part("sphere", 2, 4);
  part.report("photons", 3, 4);
  CHECK(heard == "sphere 2750/4000");
  part.report("photons", 0, 0);
  CHECK(heard == "sphere 2000/4000");
  stop = true;
  CHECK(part.cancelled());
  CHECK_FALSE(Progress().part("none", 0, 1).cancelled());
}
