#include "octree/base/error.h"

#include <catch2/catch.hpp>

using namespace obscura;

TEST_CASE("a message says where, what and what to do", "[base][error]") {
  CHECK(Problem{"/sensor/fov", "unknown key", "did you mean fov_deg?"}.text() ==
        "/sensor/fov: unknown key (did you mean fov_deg?)");
  CHECK(Problem{"", "no bands", ""}.text() == "no bands");
  CHECK(Problem{"a.vdb", "is empty", ""}.text() == "a.vdb: is empty");
}

TEST_CASE("an input error keeps all its problems", "[base][error]") {
  const InputError error({{"/a", "is wrong", ""}, {"/b", "is missing", "add it"}});
  REQUIRE(error.problems().size() == 2);
  CHECK(error.problems()[1].where == "/b");
  CHECK(std::string(error.what()) == "/a: is wrong\n/b: is missing (add it)");
  const InputError one("/c", "is odd");
  REQUIRE(one.problems().size() == 1);
  CHECK(std::string(one.what()) == "/c: is odd");
}

TEST_CASE("the failures of the world and of the numbers are told apart", "[base][error]") {
  CHECK(std::string(ResourceError("out.exr", "disk full", "free space").what()) == "out.exr: disk full (free space)");
  CHECK(std::string(NumericalError("photon", "refuses", "use path").what()) == "photon: refuses (use path)");
  CHECK_THROWS_AS(throw ResourceError("a", "b"), std::runtime_error);
  CHECK_THROWS_AS(throw NumericalError("a", "b"), std::runtime_error);
}
