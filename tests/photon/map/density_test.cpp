// The density estimate against light that is known: photons are sown with the density extinction times
// fluence, and the estimate has to give that fluence back. Each test has a wrong estimate beside it that
// the same judgement refuses.
#include "photon/map/density.h"

#include <catch2/catch.hpp>
#include <functional>
#include <vector>

#include "octree/base/random.h"
#include "octree/base/statistics.h"
#include "tests/support/agree.h"

using namespace obscura;
using test::agree;

namespace {

using Field = std::function<double(const Vec3d&)>;

/// A medium in the unit cube: k (1/m) and the fluence (W/m2) that its photons carry.
struct Medium {
  Field extinction, fluence;
  double most;  // of their product
};

bool in_cube(const Vec3d& y) { return y.x >= 0 && y.y >= 0 && y.z >= 0 && y.x < 1 && y.y < 1 && y.z < 1; }

Vec3d isotropic(Stream& stream) {
  const double z = 2 * stream.uniform() - 1, angle = 2 * kPi * stream.uniform();
  const double s = std::sqrt(1 - z * z);
  return {s * std::cos(angle), s * std::sin(angle), z};
}

/// About `count` photons where k times fluence is uniform at its most; each `copies` times.
std::vector<Photon> sow(const Medium& medium, int count, std::uint64_t seed, int copies = 1) {
  std::vector<Photon> photons;
  Stream stream(seed, 0, 1);
  for (int i = 0; i < count; ++i) {
    const Vec3d y(stream.uniform(), stream.uniform(), stream.uniform());
    const bool kept = stream.uniform() * medium.most < medium.extinction(y) * medium.fluence(y);
    if (!kept) continue;
    const auto direction = encode_direction(isotropic(stream));
    const auto power = static_cast<float>(medium.most / count / copies);
    for (int copy = 0; copy < copies; ++copy) {
      photons.push_back({Vec3f(y), direction, power, static_cast<std::uint16_t>(i % kBatches), 0});
    }
  }
  return photons;
}

double one(const Vec3d&) { return 1; }

struct Trial {
  int photons = 20000;  // in a map
  int maps = 60;
  int points = 60;  // in a map
  Vec3d from{0.35, 0.35, 0.35}, to{0.65, 0.65, 0.65};
  GatherSettings settings{};
  int copies = 1;
};

/// Mean and error of what `judge(map, x)` gives, over points in a box and over maps. Points of one map
/// share photons: the error comes from the maps.
Moments over_maps(const Medium& medium, const Trial& trial,
                  const std::function<double(const PhotonMap&, const Vec3d&)>& judge) {
  Moments moments;
  for (int m = 0; m < trial.maps; ++m) {
    const PhotonMap map(sow(medium, trial.photons, 1000 + m, trial.copies));
    Stream stream(77, m, 2);
    double sum = 0;
    for (int i = 0; i < trial.points; ++i) {
      Vec3d x;
      for (int a = 0; a < 3; ++a) {
        x[a] = trial.from[a] + (trial.to[a] - trial.from[a]) * stream.uniform();
      }
      sum += judge(map, x);
    }
    moments.add(sum / trial.points);
  }
  return moments;
}

/// Of the estimate relative to the fluence at its point.
Moments relative(const Medium& medium, const Trial& trial) {
  return over_maps(medium, trial, [&](const PhotonMap& map, const Vec3d& x) {
    return estimate(map, x, medium.extinction, one, trial.settings).value / medium.fluence(x);
  });
}

/// The estimates of the textbooks, with 1 / (k V).
double textbook(const PhotonMap& map, const Vec3d& x, double extinction, int k) {
  Nearest nearest(k);
  map.nearest(map.local(x), nearest);
  const double r = std::sqrt(nearest.distance2(nearest.count() - 1));
  double sum = 0;
  for (int i = 0; i + 1 < nearest.count(); ++i) sum += map.photon(nearest.index(i)).power;
  return sum / (extinction * 4 / 3 * kPi * r * r * r);
}

const Medium& homogeneous() {
  static const Medium medium{[](const Vec3d& y) { return in_cube(y) ? 5.0 : 0.0; }, one, 5};
  return medium;
}

}  // namespace

TEST_CASE("in a homogeneous medium the estimate is the fluence", "[photon][density]") {
  const auto kernel = GENERATE(Kernel::constant, Kernel::epanechnikov, Kernel::cone, Kernel::gaussian);
  Trial trial;
  trial.settings.kernel = kernel;
  trial.settings.nearest = 32;
  trial.from = {0.15, 0.15, 0.15};
  trial.to = {0.85, 0.85, 0.85};
  trial.points = 400;
  trial.maps = 60;
  const double resolution = 0.02;
  const Moments found = relative(homogeneous(), trial);
  CHECK(agree(found.mean(), found.standard_error(), 1, {.resolution = resolution}));
  // The k-th photon counted as well.
  CHECK_FALSE(agree(found.mean() * 32 / 31, found.standard_error(), 1, {.resolution = resolution}));
}

TEST_CASE("the default estimate is right to 0.5 %", "[photon][density]") {
  Trial trial;
  trial.from = {0.1, 0.1, 0.1};
  trial.to = {0.9, 0.9, 0.9};
  trial.photons = 100000;
  trial.points = 1500;
  trial.maps = 70;
  const Moments found = relative(homogeneous(), trial);
  CHECK(agree(found.mean(), found.standard_error(), 1, {.resolution = 0.005}));
  CHECK_FALSE(agree(found.mean() * 64 / 63, found.standard_error(), 1, {.resolution = 0.005}));
}

TEST_CASE("beside voids and at faces and corners the estimate is the fluence", "[photon][density]") {
  // One voxel in three holds something; the ball of 64 photons spans several.
  const Medium voids{[](const Vec3d& y) {
                       const int sum =
                           static_cast<int>(y.x * 8) + static_cast<int>(y.y * 8) + static_cast<int>(y.z * 8);
                       return in_cube(y) && sum % 3 == 0 ? 5.0 : 0.0;
                     },
                     one, 5};
  Trial trial;
  trial.settings.edge_correction = GENERATE(true, false);
  const auto naive = [](const PhotonMap& map, const Vec3d& x) { return textbook(map, x, 5, 64); };

  SECTION("voids") {
    trial.from = {0.15, 0.15, 0.15};
    trial.to = {0.85, 0.85, 0.85};
    trial.points = 200;
    const Moments found = relative(voids, trial);
    CHECK(agree(found.mean(), found.standard_error(), 1, {.resolution = 0.03}));
    const Moments wrong = over_maps(voids, trial, naive);
    CHECK_FALSE(agree(wrong.mean(), wrong.standard_error(), 1, {.resolution = 0.03}));
  }
  SECTION("a face of the cloud") {
    trial.from.z = trial.to.z = 0;
    const Moments found = relative(homogeneous(), trial);
    CHECK(agree(found.mean(), found.standard_error(), 1, {.resolution = 0.2}));
    const Moments wrong = over_maps(homogeneous(), trial, naive);
    CHECK_FALSE(agree(wrong.mean(), wrong.standard_error(), 1, {.resolution = 0.2}));
  }
  SECTION("a corner") {
    trial.from = {0, 0, 0};
    trial.to = {0.03, 0.03, 0.03};
    trial.photons = 2000;
    trial.maps = 400;
    trial.points = 4;
    const Moments found = relative(homogeneous(), trial);
    CHECK(agree(found.mean(), found.standard_error(), 1, {.resolution = 0.2}));
    const Moments wrong = over_maps(homogeneous(), trial, naive);
    CHECK_FALSE(agree(wrong.mean(), wrong.standard_error(), 1, {.resolution = 0.2}));
  }
}

TEST_CASE("thin beside thick, a hundredfold, the estimate is the fluence", "[photon][density]") {
  const Medium step{[](const Vec3d& y) { return !in_cube(y) ? 0.0 : y.z < 0.5 ? 5.0 : 0.05; }, one, 5};
  Trial trial;
  trial.from = {0.2, 0.2, GENERATE(0.48, 0.505, 0.53)};
  trial.to = {0.8, 0.8, trial.from.z};
  const Moments found = relative(step, trial);
  CHECK(agree(found.mean(), found.standard_error(), 1, {.resolution = 0.1}));
  // 1 / (k(x) V): wrong on both sides, many times over on the thin one.
  const Moments wrong = over_maps(
      step, trial, [&](const PhotonMap& map, const Vec3d& x) { return textbook(map, x, step.extinction(x), 64); });
  CHECK_FALSE(agree(wrong.mean(), wrong.standard_error(), 1, {.resolution = 0.1}));
}

TEST_CASE("the edge correction removes the first-order bias at a face", "[photon][density]") {
  const Medium slope{homogeneous().extinction, [](const Vec3d& y) { return 1 + 4 * y.z; }, 25};
  Trial trial;
  trial.from = {0.15, 0.15, 0};
  trial.to = {0.85, 0.85, 0};
  trial.points = 150;
  const Moments corrected = relative(slope, trial);
  CHECK(agree(corrected.mean(), corrected.standard_error(), 1, {.resolution = 0.12}));
  trial.settings.edge_correction = false;
  const Moments plain = relative(slope, trial);
  CHECK_FALSE(agree(plain.mean(), plain.standard_error(), 1, {.resolution = 0.12}));
  CHECK(std::abs(corrected.mean() - 1) < 0.25 * std::abs(plain.mean() - 1));
}

TEST_CASE("the bias from two radii is the kernel's bias, with its sign", "[photon][density]") {
  const double bend = GENERATE(8.0, -4.0);
  // The same second derivative everywhere, so the same bias.
  const Medium bowl{homogeneous().extinction, [=](const Vec3d& y) { return 2 + bend * (y.z - 0.5) * (y.z - 0.5); }, 20};
  Trial trial;
  trial.from = {0.25, 0.25, 0.4};
  trial.to = {0.75, 0.75, 0.6};
  trial.maps = 300;
  trial.photons = 10000;
  trial.settings.nearest = 256;
  trial.points = 20;
  Moments told;
  const Moments error = over_maps(bowl, trial, [&](const PhotonMap& map, const Vec3d& x) {
    const Estimate e = estimate(map, x, bowl.extinction, one, trial.settings);
    told.add(e.bias);
    return e.value - bowl.fluence(x);
  });
  INFO("error " << error.mean() << " +- " << error.standard_error() << ", bias told " << told.mean());
  CHECK(std::abs(error.mean()) > 4.5 * error.standard_error());
  CHECK(std::abs(told.mean() - error.mean()) < 4.5 * error.standard_error());
  CHECK_FALSE(std::abs(-told.mean() - error.mean()) < 4.5 * error.standard_error());
}

TEST_CASE("the scatter of the batches is the error of the estimate", "[photon][density]") {
  // Student's t with 15 degrees of freedom: 93.6 % within 2.
  const auto share_within = [](double factor) {
    int within = 0;
    const int seeds = 400;
    for (int seed = 0; seed < seeds; ++seed) {
      const PhotonMap map(sow(homogeneous(), 3000, 5000 + seed));
      const Estimate e = estimate(map, {0.5, 0.5, 0.5}, homogeneous().extinction, one, {});
      double squares = 0, sum = 0;
      for (const double b : e.batch) {
        squares += (b - e.value) * (b - e.value);
        sum += b;
      }
      CHECK(e.value == Approx(sum / kBatches));
      const double error = std::sqrt(squares / (kBatches - 1) / kBatches);
      within += std::abs(e.value - 1) < 2 * factor * error;
    }
    return within / static_cast<double>(seeds);
  };
  CHECK(share_within(1) >= 0.90);
  CHECK(share_within(1) <= 0.98);
  CHECK_FALSE(share_within(0.7) >= 0.90);  // an error that is 30 % too small
  CHECK_FALSE(share_within(1.5) <= 0.98);
}

TEST_CASE("the weight sees each photon's direction", "[photon][density]") {
  auto photons = sow(homogeneous(), 5000, 3);
  const double cosine = 0.25;
  for (Photon& photon : photons) {
    photon.direction = encode_direction({std::sqrt(1 - cosine * cosine), 0, cosine});
  }
  const PhotonMap map(photons);
  const Vec3d x(0.5, 0.4, 0.6);
  const auto all = estimate(map, x, homogeneous().extinction, one, {});
  const auto weighted = estimate(map, x, homogeneous().extinction, [](const Vec3d& w) { return 3 + 2 * w.z; }, {});
  CHECK(weighted.value == Approx(3.5 * all.value).epsilon(1e-4));
  CHECK(weighted.bias == Approx(3.5 * all.bias).epsilon(1e-3));
  CHECK(weighted.batch[5] == Approx(3.5 * all.batch[5]).epsilon(1e-4));
}

TEST_CASE("with fewer photons than k the mean is still right", "[photon][density]") {
  // The ball around the middle holds all of a sphere: whatever k asks for, phi = N P / integral of k.
  const Medium sphere{[](const Vec3d& y) { return (y - Vec3d(0.5)).length() < 0.5 ? 5.0 : 0.0; }, one, 5};
  Trial trial;
  trial.from = trial.to = {0.5, 0.5, 0.5};
  trial.points = 1;
  trial.photons = GENERATE(40, 100);
  trial.maps = 6000;
  trial.settings.nearest = 200;
  const Moments found = relative(sphere, trial);
  CHECK(agree(found.mean(), found.standard_error(), 1, {.resolution = 0.04}));
  // All of them counted in the ball of the farthest.
  const Moments wrong = over_maps(sphere, trial, [&](const PhotonMap& map, const Vec3d& x) {
    const Estimate e = estimate(map, x, sphere.extinction, one, trial.settings);
    return e.value * (e.photons + 1) / e.photons;
  });
  CHECK(agree(wrong.mean(), wrong.standard_error(), 1, {.resolution = 0.04}).z > 3);
}

TEST_CASE("where fewer than k are within the greatest radius it is the radius", "[photon][density]") {
  Trial trial;
  trial.photons = 2000;
  trial.maps = 400;
  trial.points = 200;
  trial.from = {0.15, 0.15, 0.15};
  trial.to = {0.85, 0.85, 0.85};
  trial.settings.max_radius_m = 0.1;  // 8 photons on the average
  const Moments found = relative(homogeneous(), trial);
  CHECK(agree(found.mean(), found.standard_error(), 1, {.resolution = 0.05}));
  const PhotonMap map(sow(homogeneous(), 2000, 1));
  CHECK(estimate(map, {0.5, 0.5, 0.5}, homogeneous().extinction, one, trial.settings).radius == Approx(0.1));
  CHECK(estimate(map, {5, 5, 5}, homogeneous().extinction, one, trial.settings).value == 0);
}

TEST_CASE("photons in coincident pairs count as what they are", "[photon][density]") {
  Trial trial;
  trial.copies = GENERATE(2, 8);
  trial.photons = 4000;
  trial.points = 100;
  trial.maps = 120;
  trial.from = {0.15, 0.15, 0.15};
  trial.to = {0.85, 0.85, 0.85};
  trial.settings.kernel = GENERATE(Kernel::constant, Kernel::epanechnikov);
  const Moments found = relative(homogeneous(), trial);
  CHECK(agree(found.mean(), found.standard_error(), 1, {.resolution = 0.05}));
}

TEST_CASE("more coincident photons than k are searched past", "[photon][density]") {
  // Clumps of 100 with k = 64: the nearest clump alone has no density, the next one gives the radius.
  Trial trial;
  trial.copies = 100;
  trial.photons = 500;
  trial.points = 10;
  trial.maps = 100;
  trial.from = {0.3, 0.3, 0.3};
  trial.to = {0.7, 0.7, 0.7};
  const Moments found = relative(homogeneous(), trial);
  CHECK(agree(found.mean(), found.standard_error(), 1, {.resolution = 0.15}));
}

TEST_CASE("no photons, one photon and photons at one place have no density", "[photon][density]") {
  const PhotonMap empty, none(std::vector<Photon>{});
  Photon photon;
  photon.position = {0.5f, 0.5f, 0.5f};
  photon.power = 1;
  const PhotonMap single({photon});
  const PhotonMap clump(std::vector<Photon>(300, photon));
  for (const PhotonMap* map : {&empty, &none, &single, &clump}) {
    for (const Vec3d& x : {Vec3d(0.5), Vec3d(0.1, 0.2, 0.3)}) {
      const Estimate e = estimate(*map, x, homogeneous().extinction, one, {});
      CHECK(e.value == 0);
      CHECK(e.bias == 0);
      CHECK_FALSE(e.anomaly);
      CHECK(std::isfinite(e.radius));
    }
  }
}

TEST_CASE("photons where there is no extinction are an anomaly, not a number", "[photon][density]") {
  const PhotonMap map(sow(homogeneous(), 1000, 1));
  const Estimate e = estimate(map, {0.5, 0.5, 0.5}, [](const Vec3d&) { return 0.0; }, one, {});
  CHECK(e.anomaly);
  CHECK(e.value == 0);
  CHECK(e.batch[3] == 0);
  CHECK_FALSE(estimate(map, {0.5, 0.5, 0.5}, homogeneous().extinction, one, {}).anomaly);
}

TEST_CASE("specks far apart, each with a photon, are dark or found, and no anomaly", "[photon][density]") {
  // Specks of a thousandth of their distance: no point of a cubature meets one.
  std::vector<Photon> photons;
  for (int i = 0; i < 12 * 12 * 12; ++i) {
    Photon photon;
    photon.position = Vec3f(static_cast<float>(i % 12), static_cast<float>(i / 12 % 12), static_cast<float>(i / 144));
    photon.direction = encode_direction({0, 0, 1});
    photon.power = 1;
    photons.push_back(photon);
  }
  const PhotonMap map(std::move(photons));
  const auto specks = [](double half) {
    return [half](const Vec3d& y) {
      double far = 0;
      for (int a = 0; a < 3; ++a) far = std::max(far, std::abs(y[a] - std::round(y[a])));
      return far < half ? 1.0 : 0.0;
    };
  };
  for (const Vec3d& x : {Vec3d(5.3, 5.4, 5.2), Vec3d(0.1, 0.2, 6.4), Vec3d(4, 4, 4)}) {
    const Estimate tiny = estimate(map, x, specks(5e-4), one, {});
    CHECK_FALSE(tiny.anomaly);
    CHECK(std::isfinite(tiny.value));
    // Of a twelfth of their distance a wide ball meets some: a photon in each of volume 1 / 216 is 216 a unit of k.
    const Estimate found = estimate(map, x, specks(1.0 / 12), one, {});
    CHECK_FALSE(found.anomaly);
    CHECK(found.value < 20 * 216);
  }
  // A photon on the face of its speck, on the wrong side by rounding, is in it.
  CHECK(detail::in_medium({1 + 1e-7, 0, 0}, [](const Vec3d& y) { return y.x < 1 ? 1.0 : 0.0; }));
  CHECK_FALSE(detail::in_medium({1.1, 0, 0}, [](const Vec3d& y) { return y.x < 1 ? 1.0 : 0.0; }));
}

TEST_CASE("where surfaces hide all photons there is no light, and no anomaly", "[photon][density]") {
  struct Hidden : Unobstructed {
    bool obstructed(const Vec3d&, double) const { return true; }
    bool sees(const Vec3d&, const Vec3d&) const { return false; }
  };
  const PhotonMap map(sow(homogeneous(), 1000, 5));
  const Estimate e = estimate(map, {0.5, 0.5, 0.5}, homogeneous().extinction, one, {}, Hidden{});
  CHECK(e.value == 0);
  CHECK(e.photons == 0);
  CHECK_FALSE(e.anomaly);
}

TEST_CASE("the rounds of the cubature are uniform rotations", "[photon][density]") {
  // First and second moments of where an axis goes, and other rounds go elsewhere.
  const int count = 20000;
  Vec3d sum(0, 0, 0), squares(0, 0, 0);
  for (int i = 0; i < count; ++i) {
    const detail::Rotation turn = detail::rotation_at({i * 1e-3, 0.5, -2}, i % 3);
    CHECK(turn.x.cross(turn.y).dot(turn.z) == Approx(1));
    CHECK(std::abs(turn.x.dot(turn.y)) < 1e-12);
    sum += turn.x;
    for (int a = 0; a < 3; ++a) squares[a] += turn.x[a] * turn.x[a];
  }
  for (int a = 0; a < 3; ++a) {
    CHECK(std::abs(sum[a] / count) < 5 / std::sqrt(3.0 * count));
    CHECK(squares[a] / count == Approx(1 / 3.0).margin(5 * 0.3 / std::sqrt(count)));
  }
  CHECK(detail::rotation_at({1, 2, 3}, 0).x != detail::rotation_at({1, 2, 3}, 1).x);
}
