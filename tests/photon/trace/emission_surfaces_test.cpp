// Photons of hot spheres and faces: their power, where they start, where they go, and what they weigh.
#include <catch2/catch.hpp>

#include "photon/trace/emission.h"
#include "tests/photon/trace/emit_many.h"
#include "tests/support/agree.h"
#include "tests/support/chi_square.h"
#include "tests/support/shapes_of_surfaces.h"

using namespace obscura;
using namespace obscura::test;

TEST_CASE("hot spheres emit Lambertian light from their surface; only sources are in the direct set",
          "[photon][emission]") {
  WorldContents contents;
  contents.bands.emplace_back("grey");
  contents.sources.push_back({{1, 2, 3}, 0.5, {4}});
  contents.particles.push_back({{5, 2, 3}, 0.25, {8}});
  const World world(std::move(contents));
  const PhotonEmitter emitter({world, 0});
  const double powers[] = {4 * 4 * kPi * kPi * 0.25, 8 * 4 * kPi * kPi * 0.0625};
  CHECK(emitter.power() == Approx(powers[0] + powers[1]));
  std::vector<Vec3d> normals;
  std::vector<double> cosines(10);
  double of_particle = 0;
  emit_many(emitter, kPhotons, [&](const EmittedPhoton& photon) {
    const HotSphere& sphere = world.spheres()[photon.position.x > 3 ? 1 : 0];
    of_particle += photon.position.x > 3 ? 1 : 0;
    CHECK(photon.in_direct_set == (photon.position.x < 3));
    const Vec3d normal = (photon.position - sphere.center) / sphere.radius;
    REQUIRE(normal.length() == Approx(1));
    normals.push_back(normal);
    const double cosine = normal.dot(photon.direction);
    REQUIRE(cosine >= -1e-12);
    ++cosines[std::min<std::size_t>(9, static_cast<std::size_t>(10 * cosine * cosine))];
  });
  const double share = powers[1] / (powers[0] + powers[1]);
  CHECK(chi_square({of_particle, kPhotons - of_particle}, {share * kPhotons, (1 - share) * kPhotons}));
  CHECK(chi_square(cosines, std::vector<double>(10, kPhotons / 10.0)));
  std::size_t next = 0;
  CHECK(chi_square_directions([&] { return normals[next++]; }, [](const Vec3d&) { return 1 / (4 * kPi); }, kPhotons));
}

TEST_CASE("faces emit exactly their power, by the cosine and from the side that shines",
          "[photon][emission][surfaces]") {
  for (const bool double_sided : {false, true}) {
    WorldContents contents = empty_contents();
    contents.materials = {grey_material(0.6)};
    Object sheet = grey_object(parallelogram({1, 2, 3}, {2, 0, 0}, {0, 3, 0}), 0, 5);
    sheet.local_to_world = placement({-4, 1, 0}, {0.4, 0.3, -0.2}, 2);
    sheet.double_sided = double_sided;
    contents.objects = {sheet};
    const World world(contents);
    const PhotonEmitter emitter({world, 0});
    const double power = kPi * 0.6 * 5 * 24 * (double_sided ? 2 : 1);
    CHECK(emitter.power() == Approx(power).epsilon(1e-12));
    const Vec3d front = transform_direction(sheet.local_to_world, Vec3d(0, 0, 1)).normalized();
    std::vector<double> cosines(20), sides(2), cells(24);
    double worst_power = 0, worst_place = 0;
    int strangers = 0;
    emit_many(emitter, kPhotons, [&](const EmittedPhoton& photon) {
      worst_power = std::max(worst_power, std::abs(photon.power / power - 1));
      const double cosine = photon.direction.dot(front);
      ++cosines[std::min<std::size_t>(19, static_cast<std::size_t>(20 * cosine * cosine))];
      ++sides[cosine > 0 ? 0 : 1];
      strangers += photon.from.surface != 0 || photon.from.face > 1 || !photon.in_direct_set || photon.from_beyond;
      const Vec3d local = transform_point(sheet.local_to_world.inverse(), photon.position) - Vec3d(1, 2, 3);
      worst_place = std::max(worst_place, std::abs(local.z));
      ++cells[std::min<std::size_t>(3, static_cast<std::size_t>(2 * std::max(0.0, local.x))) +
              4 * std::min<std::size_t>(5, static_cast<std::size_t>(2 * std::max(0.0, local.y)))];
    });
    CHECK(worst_power < 1e-12);
    CHECK(worst_place < 1e-12);
    CHECK(strangers == 0);
    CHECK(chi_square(cosines, std::vector<double>(20, kPhotons / 20.0)));
    CHECK(chi_square(cells, std::vector<double>(24, kPhotons / 24.0)));
    if (double_sided) {
      CHECK(chi_square(sides, {kPhotons / 2.0, kPhotons / 2.0}));
    } else {
      CHECK(sides[1] == 0);
    }
  }
}

TEST_CASE("what varies with angle and place over a face is made up for by weights", "[photon][emission][surfaces]") {
  WorldContents contents;
  const Band band("infrared", 8, 12, 1);
  contents.bands.push_back(band);
  Material angled = grey_material(0.9);
  angled.angle_deg = {0, 90};
  angled.angle_factor = {1, 0.2};
  contents.materials = {angled};
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh->faces = {{0, 1, 2}};
  mesh->vertex_K = {300, 600, 300};
  Object object;
  object.mesh = mesh;
  contents.objects = {object};
  const World world(contents);
  const PhotonEmitter emitter({world, 0});
  constexpr int kParts = 8;
  std::vector<Moments> by_place(kParts), by_cosine(kParts);
  const Moments power = emit_many(emitter, kPhotons, [&](const EmittedPhoton& photon) {
    const double cosine2 = photon.direction.z * photon.direction.z;
    for (int i = 0; i < kParts; ++i) {
      by_place[static_cast<std::size_t>(i)].add(static_cast<int>(kParts * photon.position.x) == i ? photon.power : 0.0);
      by_cosine[static_cast<std::size_t>(i)].add(
          std::min(static_cast<int>(kParts * cosine2), kParts - 1) == i ? photon.power : 0.0);
    }
  });
  // Integrals over strips of x, where the temperature is 300 + 300 x and the width 1 - x, and over the angle.
  std::array<double, kParts> places{}, angles{};
  double over_places = 0, over_angles = 0;
  constexpr int kSteps = 4000;
  for (int i = 0; i < kSteps; ++i) {
    const double x = (i + 0.5) / kSteps;
    const double here = band.planck(0, 300 + 300 * x) * (1 - x) / kSteps;
    places[static_cast<std::size_t>(kParts * x)] += here;
    over_places += here;
    const double emissivity = 0.9 * (1 - 0.8 * std::acos(std::sqrt(x)) / (0.5 * kPi));  // x is the cosine's square
    angles[static_cast<std::size_t>(kParts * x)] += kPi * emissivity / kSteps;
    over_angles += kPi * emissivity / kSteps;
  }
  CHECK(
      agree(power.mean(), power.standard_error(), over_places * over_angles, {.resolution = 0.02, .comparisons = 17}));
  for (std::size_t i = 0; i < kParts; ++i) {
    INFO("part " << i);
    CHECK(agree(by_place[i].mean(), by_place[i].standard_error(), places[i] * over_angles,
                {.resolution = 0.25, .comparisons = 17}));
    CHECK(agree(by_cosine[i].mean(), by_cosine[i].standard_error(), angles[i] * over_places,
                {.resolution = 0.1, .comparisons = 17}));
  }
}
