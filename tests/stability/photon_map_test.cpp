// The map's hard cases, each with its right answer: extreme extinction, scale and place, few photons.
#include <catch2/catch.hpp>
#include <vector>

#include "octree/base/random.h"
#include "photon/map/density.h"

using namespace obscura;

namespace {

/// Photons of a homogeneous cube whose fluence is 1: N P = k V.
std::vector<Photon> cube_photons(int count, double extinction, double size, std::uint64_t seed) {
  std::vector<Photon> photons(count);
  Stream stream(seed, 0, 1);
  for (int i = 0; i < count; ++i) {
    const double x = stream.uniform(), y = stream.uniform();
    photons[i].position = Vec3f(size * Vec3d(x, y, stream.uniform()));
    photons[i].power = static_cast<float>(extinction * size * size * size / count);
    photons[i].batch = static_cast<std::uint16_t>(i % kBatches);
  }
  return photons;
}

constexpr auto one = [](const Vec3d&) { return 1.0; };

}  // namespace

TEST_CASE("extinctions of 1e-10 to 1e6 and voxels of 1 mm to 100 km give the same light", "[stability][photon_map]") {
  const auto value = [](double extinction, double size) {
    const PhotonMap map(cube_photons(4000, extinction, size, 3));
    const auto k = [=](const Vec3d& y) {
      const bool inside = y.x >= 0 && y.y >= 0 && y.z >= 0 && y.x < size && y.y < size && y.z < size;
      return inside ? extinction : 0.0;
    };
    return estimate(map, size * Vec3d(0.5, 0.5, 0.01), k, one, {});
  };
  const Estimate reference = value(1, 1);
  CHECK(reference.value == Approx(1).margin(0.8));
  CHECK(reference.value > 0.2);
  for (const double extinction : {1e-10, 1e-3, 1e6}) {
    for (const double size : {1e-3, 1.0, 1e5}) {
      const Estimate e = value(extinction, size);
      // The cubature turns by a hash of x, so other sizes see other points.
      CHECK(e.value == Approx(reference.value).epsilon(size == 1 ? 1e-5 : 0.35));
      CHECK(e.radius / size == Approx(reference.radius).epsilon(1e-5));
      CHECK_FALSE(e.anomaly);
    }
  }
}

TEST_CASE("250 K beside 3000 K: dim photons are not lost among bright ones", "[stability][photon_map]") {
  // Powers of 1 : 1e12 at the same places; the dim half alone gives the same as within the whole.
  auto photons = cube_photons(4000, 1, 1, 7);
  for (Photon& photon : photons) {
    const bool bright = photon.position.x > 0.9f;
    if (bright) photon.power *= 1e12f;
  }
  const auto k = [](const Vec3d&) { return 1.0; };
  const Estimate e = estimate(PhotonMap(photons), {0.1, 0.5, 0.5}, k, one, {});
  CHECK(e.value == Approx(1).margin(0.6));
}

TEST_CASE("a query far outside of the map gives the light at the nearest photon", "[stability][photon_map]") {
  const PhotonMap map(cube_photons(1000, 1, 1, 9));
  const auto k = [](const Vec3d& y) {
    return y.x >= 0 && y.y >= 0 && y.z >= 0 && y.x < 1 && y.y < 1 && y.z < 1 ? 1.0 : 0.0;
  };
  const Estimate e = estimate(map, {1e6, 0.5, 0.5}, k, one, {});
  CHECK(!e.anomaly);
  CHECK(e.value == Approx(1).margin(0.6));
  CHECK(e.radius < 1);  // of the ball there: hardly a point of one around the query would meet the cube
}

TEST_CASE("a lattice of photons and a query at one of them has no division by 0", "[stability][photon_map]") {
  std::vector<Photon> photons;
  for (int i = 0; i < 1000; ++i) {
    Photon photon;
    photon.position = Vec3f(static_cast<float>(i % 10), static_cast<float>(i / 10 % 10), static_cast<float>(i / 100));
    photon.power = 1;
    photon.batch = static_cast<std::uint16_t>(i % kBatches);
    photons.push_back(photon);
  }
  const PhotonMap map(photons);
  const auto k = [](const Vec3d&) { return 1.0; };  // one photon a cubic metre: fluence 1
  for (const Kernel kernel : {Kernel::constant, Kernel::epanechnikov, Kernel::cone, Kernel::gaussian}) {
    GatherSettings settings;
    settings.kernel = kernel;
    // Only as near as balls of a lattice are to their volume.
    CHECK(estimate(map, {5, 5, 5}, k, one, settings).value == Approx(1).epsilon(0.3));
    CHECK(estimate(map, {4.5, 4.5, 4.5}, k, one, settings).value == Approx(1).epsilon(0.3));
  }
}

TEST_CASE("a single sheet of medium has an estimate", "[stability][photon_map]") {
  // 1 mm thin in a ball of decimetres: the second moment is singular across.
  double sum = 0;
  const int maps = 200;
  for (int m = 0; m < maps; ++m) {
    auto photons = cube_photons(4000, 0.02, 1, 20 + m);
    for (Photon& photon : photons) photon.position.z = 0.5f + 0.02f * (photon.position.z - 0.5f);
    for (Photon& photon : photons) photon.power = 1.0f * 0.02f / 4000;
    const auto k = [](const Vec3d& y) { return std::abs(y.z - 0.5) < 0.01 ? 1.0 : 0.0; };
    // Elsewhere in each: the cubature is the same at the same point.
    const Vec3d x(0.3 + 0.4 * m / maps, 0.5, 0.5);
    const Estimate e = estimate(PhotonMap(photons), x, k, one, {});
    CHECK(std::isfinite(e.value));
    sum += e.value;
  }
  CHECK(sum / maps == Approx(1).epsilon(0.1));
}

TEST_CASE("at the corners of a thin sheet with few photons the cubature still meets the sheet",
          "[stability][photon_map]") {
  // A ball of half the sheet's width holds 1 % of it at a corner.
  double sum = 0;
  int anomalies = 0, count = 0;
  const int maps = 300;
  for (int m = 0; m < maps; ++m) {
    auto photons = cube_photons(300, 0.01, 1, 500 + m);
    for (Photon& photon : photons) photon.position.z *= 0.01f;
    for (Photon& photon : photons) photon.power = 1.0f * 0.01f / 300;
    const auto k = [](const Vec3d& y) {
      return y.x >= 0 && y.y >= 0 && y.z >= 0 && y.x < 1 && y.y < 1 && y.z < 0.01 ? 1.0 : 0.0;
    };
    const PhotonMap map(photons);
    for (const double corner : {0.02, 0.98}) {
      const Estimate e = estimate(map, Vec3d(corner, 0.03 + 1e-4 * m, 0.005), k, one, {});
      anomalies += e.anomaly;
      sum += e.value;
      ++count;
    }
  }
  CHECK(anomalies == 0);
  CHECK(sum / count == Approx(1).epsilon(0.2));
}
