// Sources of photons: what a beam emits, and that the parts make the whole.
#include "photon/trace/emission.h"

#include <catch2/catch.hpp>

#include "tests/photon/trace/emit_many.h"
#include "tests/support/chi_square.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

TEST_CASE("a beam leaves its disc along its direction", "[photon][emission]") {
  WorldContents contents;
  contents.bands.emplace_back("grey");
  const Vec3d d = Vec3d(2, -1, 2).normalized();
  contents.beams.push_back({{1, 2, 3}, d, 0.5, {6}});
  const World world(std::move(contents));
  const PhotonEmitter emitter({world, 0});
  CHECK(emitter.power() == 6);
  std::vector<double> rings(10);
  emit_many(emitter, 20000, [&](const EmittedPhoton& photon) {
    CHECK(photon.direction == d);
    CHECK(photon.power == 6);
    CHECK_FALSE(photon.in_direct_set);
    const Vec3d o = photon.position - Vec3d(1, 2, 3);
    CHECK(o.dot(d) == Approx(0).margin(1e-12));
    ++rings[std::min<std::size_t>(9, static_cast<std::size_t>(10 * o.length2() / 0.25))];
  });
  CHECK(chi_square(rings, std::vector<double>(10, 2000.0)));
}

TEST_CASE("sources that are off emit nothing, and a dark World has no power", "[photon][emission]") {
  CloudWish wish;
  wish.source = 1;
  WorldContents contents = grey_contents(wish, 1);
  contents.sun = Sun{{0, 0, 1}, {1}, 0.01};
  contents.sources.push_back({{0, 0, 30}, 1, {1}});
  contents.particles.push_back({{0, 0, 40}, 1, {1}});
  contents.beams.push_back({{0, 0, -3}, {0, 0, 1}, 1, {1}});
  const World world(std::move(contents));
  const double whole = PhotonEmitter({world, 0}).power();
  double sum = 0;
  for (bool SourceSelection::*source :
       {&SourceSelection::emission, &SourceSelection::sun, &SourceSelection::sky, &SourceSelection::spheres,
        &SourceSelection::particles, &SourceSelection::beams}) {
    SourceSelection one{false, false, false, false, false, false, false};
    one.*source = true;
    const double part = PhotonEmitter({world, 0}, one).power();
    CHECK(part > 0);
    sum += part;
  }
  CHECK(sum == Approx(whole).epsilon(1e-12));
  CHECK(PhotonEmitter({world, 0}, {false, false, false, false, false, false, false}).power() == 0);
}
