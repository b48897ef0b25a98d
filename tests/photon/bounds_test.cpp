// The bounds behind decisions, on clouds whose answer is known.
#include "photon/bounds.h"

#include <catch2/catch.hpp>

#include "octree/base/error.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

World box(double extinction, double albedo, double g) {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.extinction = extinction;
  wish.albedo = albedo;
  wish.phase = PhaseFunction::henyey_greenstein(g);
  return World(grey_contents(wish));
}

}  // namespace

TEST_CASE("the largest depth lies between a side and the diagonal of a box", "[photon][bounds]") {
  const double depth = largest_optical_depth(box(0.5, 0, 0), 0);
  CHECK(depth >= 0.5 * 8);
  CHECK(depth <= 0.5 * 8 * std::sqrt(3.0) * (1 + 1e-6));
  CHECK(depth > 0.5 * 8 * 1.4);  // 256 chords come near the diagonal
  CHECK(largest_optical_depth(box(5, 0, 0), 0) == Approx(10 * depth).epsilon(1e-4));
  WorldContents nothing;
  nothing.bands.emplace_back("grey");
  CHECK(largest_optical_depth(World(std::move(nothing)), 0) == 0);
}

TEST_CASE("histories that would not end are refused by name, those that end are not", "[photon][bounds]") {
  CHECK_THROWS_AS(refuse_endless_histories(box(1e4, 1, 0), 0, "photon"), NumericalError);
  CHECK_THROWS_WITH(refuse_endless_histories(box(1e4, 1, 0), 0, "photon"),
                    Catch::Contains("photon") && Catch::Contains("ordinates"));
  CHECK_THROWS_AS(refuse_endless_histories(box(1e4, 1 - 1e-6, 0.5), 0, "photon"), NumericalError);
  CHECK_NOTHROW(refuse_endless_histories(box(1e4, 0.999, 0), 0, "photon"));  // absorbs in time
  CHECK_NOTHROW(refuse_endless_histories(box(500, 1, 0), 0, "photon"));       // some 1e7 collisions
  CHECK_NOTHROW(refuse_endless_histories(box(1e4, 1, 0.95), 0, "photon"));   // mostly forward
  CHECK_NOTHROW(refuse_endless_histories(box(1e6, 0, 0), 0, "photon"));
}
