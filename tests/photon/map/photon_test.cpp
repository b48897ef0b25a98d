// The 24 bytes of a photon: the direction's code.
#include "photon/map/photon.h"

#include <catch2/catch.hpp>

#include "octree/base/random.h"

using namespace obscura;

TEST_CASE("directions survive their 32 bits to 7e-5 rad without drift", "[photon]") {
  double worst = 0;
  Vec3d drift(0, 0, 0);
  const int count = 200000;
  for (int i = 0; i < count; ++i) {
    Stream stream(1, i, 3);
    const double z = 2 * stream.uniform() - 1, angle = 2 * kPi * stream.uniform();
    const double s = std::sqrt(1 - z * z);
    const Vec3d direction(s * std::cos(angle), s * std::sin(angle), z);
    const Vec3d back = decode_direction(encode_direction(direction));
    REQUIRE(back.length() == Approx(1).epsilon(1e-14));
    worst = std::max(worst, (back - direction).length());
    drift += back - direction;
    // Its length does not matter.
    REQUIRE(encode_direction(direction * 3) == encode_direction(direction));
  }
  CHECK(worst < 7e-5);
  CHECK(worst > 1e-5);  // a code of 16 bits a component can't do better
  CHECK((drift / count).length() < 3 * 2.7e-5 / std::sqrt(count));
}

TEST_CASE("the six axes and the folded seams are exact", "[photon]") {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Vec3d direction(0, 0, 0);
      direction[axis] = sign;
      CHECK((decode_direction(encode_direction(direction)) - direction).length() == 0);
    }
  }
  for (const Vec3d& direction : {Vec3d(1, 1, 0), Vec3d(-1, 1, 0), Vec3d(1, -1, -1e-9), Vec3d(-1, -1, 1e-9)}) {
    CHECK((decode_direction(encode_direction(direction)) - direction.normalized()).length() < 7e-5);
  }
}
