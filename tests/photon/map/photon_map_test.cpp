// The map around the tree: that it repeats, and what it costs.
#include "photon/map/photon_map.h"

#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>

#include "octree/base/random.h"
#include "photon/map/density.h"

using namespace obscura;

namespace {

std::vector<Photon> uniform_photons(int count, const Vec3d& size, std::uint64_t seed) {
  std::vector<Photon> photons(count);
  Stream stream(seed, 0, 1);
  for (int i = 0; i < count; ++i) {
    const double x = stream.uniform(), y = stream.uniform();
    photons[i].position = Vec3f(Vec3d(x, y, stream.uniform()) * size);
    photons[i].power = static_cast<float>(stream.uniform());
    photons[i].batch = static_cast<std::uint16_t>(i % kBatches);
  }
  return photons;
}

bool same_bits(const PhotonMap& a, const PhotonMap& b) {
  return a.size() == b.size() && a.power() == b.power() &&
         std::memcmp(a.photons().data(), b.photons().data(), a.size() * sizeof(Photon)) == 0;
}

std::vector<float> distances(const PhotonMap& map, const Vec3d& x, int k) {
  Nearest nearest(k, static_cast<float>(map.reach() * map.reach()));
  const Vec3f local = map.local(x);
  map.nearest(local, nearest);
  std::vector<float> found;
  for (int i = 0; i < nearest.count(); ++i) {
    found.push_back(nearest.distance2(i));
    CHECK(map.offset(local, nearest.index(i)).length2() == Approx(nearest.distance2(i)).epsilon(1e-6));
  }
  std::sort(found.begin(), found.end());
  return found;
}

constexpr auto one = [](const Vec3d&) { return 1.0; };

}  // namespace

TEST_CASE("a map that repeats finds what tiles of it hold", "[photon][photon_map]") {
  const Vec3d size(1, 2, 3);
  const auto photons = uniform_photons(GENERATE(3, 500), size, 4);
  const Vec3d period = GENERATE(Vec3d(1, 2, 0), Vec3d(0, 2, 0), Vec3d(1, 2, 3));
  const PhotonMap map(photons, period);
  CHECK(map.periodic());
  CHECK(map.reach() >= 3);

  for (int query = 0; query < 60; ++query) {
    Stream stream(9, query, 2);
    Vec3d x(stream.uniform(), stream.uniform(), stream.uniform());
    x = x * size;
    if (query % 5 == 0) x[query / 5 % 3] = 1e-3;
    const int k = 1 + query;
    // Brute force in doubles over tiles that reach farther.
    std::vector<double> all;
    const int tiles = 5;
    for (int i = period.x > 0 ? -tiles : 0; i <= (period.x > 0 ? tiles : 0); ++i) {
      for (int j = period.y > 0 ? -tiles : 0; j <= (period.y > 0 ? tiles : 0); ++j) {
        for (int l = period.z > 0 ? -tiles : 0; l <= (period.z > 0 ? tiles : 0); ++l) {
          for (const Photon& photon : photons) {
            const double d2 = (Vec3d(photon.position) + Vec3d(i, j, l) * period - x).length2();
            if (d2 < map.reach() * map.reach()) all.push_back(d2);
          }
        }
      }
    }
    std::sort(all.begin(), all.end());
    const auto found = distances(map, x, k);
    REQUIRE(found.size() == std::min<std::size_t>(all.size(), k));
    for (std::size_t i = 0; i < found.size(); ++i) {
      REQUIRE(std::sqrt(found[i]) == Approx(std::sqrt(all[i])).margin(1e-5));
    }
    // Whole periods away it is the same point.
    const auto elsewhere = distances(map, x + period * Vec3d(7, -40, 3), k);
    REQUIRE(elsewhere.size() == found.size());
    CHECK(std::sqrt(elsewhere.back()) == Approx(std::sqrt(found.back())).margin(1e-5));
  }
}

TEST_CASE("photons outside of the cell are wrapped into it", "[photon][photon_map]") {
  auto photons = uniform_photons(200, {1, 1, 1}, 6);
  const PhotonMap inside(photons, {1, 1, 0});
  for (std::size_t i = 0; i < photons.size(); ++i) {
    photons[i].position += Vec3f(static_cast<float>(i % 5) - 2, static_cast<float>(i % 3), 0);
  }
  const PhotonMap wrapped(photons, {1, 1, 0});
  for (const Photon& photon : wrapped.photons()) {
    CHECK(photon.position.x >= 0);
    CHECK(photon.position.x <= 1);
  }
  CHECK(distances(wrapped, {0.01, 0.99, 0.5}, 20).back() ==
        Approx(distances(inside, {0.01, 0.99, 0.5}, 20).back()).epsilon(1e-4));
}

TEST_CASE("light is as strong at the border of a cell as in its middle", "[photon][photon_map]") {
  const auto everywhere = [](const Vec3d& y) { return y.z >= 0 && y.z < 1 ? 2.0 : 0.0; };
  double repeated = 0, alone = 0;
  const int seeds = 300;
  for (int seed = 0; seed < seeds; ++seed) {
    auto photons = uniform_photons(2000, {1, 1, 1}, 100 + seed);
    for (Photon& photon : photons) photon.power = 2.0f / 2000;
    const Vec3d corner(0.003, 0.997, 0.5);
    repeated += estimate(PhotonMap(photons, {1, 1, 0}), corner, everywhere, one, {}).value;
    alone += estimate(PhotonMap(photons), corner, everywhere, one, {}).value;
  }
  CHECK(repeated / seeds == Approx(1).margin(4 * 0.16 / std::sqrt(seeds)));
  CHECK_FALSE(alone / seeds == Approx(1).margin(0.5));
}

TEST_CASE("a map of many photons takes less than 25 bytes each", "[photon][photon_map]") {
  const PhotonMap map(uniform_photons(10000, {1, 1, 1}, 2));
  CHECK(map.bytes() >= 24 * map.size());
  CHECK(map.bytes() < 25 * map.size());
}

TEST_CASE("maps and estimates have the same bits for any number of threads", "[photon][photon_map]") {
  const auto photons = uniform_photons(30000, {1, 1, 1}, 12);
  const PhotonMap reference(photons);
  const auto k = [](const Vec3d& y) { return y.x < 0.5 ? 3.0 : 0.1; };
  const Estimate expected = estimate(reference, {0.49, 0.5, 0.5}, k, one, {});
  for (const int threads : {1, 2, 7}) {
    oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism, threads);
    const PhotonMap map(photons);
    CHECK(same_bits(map, reference));
    const Estimate e = estimate(map, {0.49, 0.5, 0.5}, k, one, {});
    CHECK(e.value == expected.value);
    CHECK(e.bias == expected.bias);
    CHECK(e.batch == expected.batch);
  }
}
