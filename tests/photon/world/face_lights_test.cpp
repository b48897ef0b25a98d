// The choice of emitting faces: power, density and places of every kind of object.
#include "photon/world/face_lights.h"

#include <catch2/catch.hpp>

#include "photon/world/spectral_world.h"
#include "tests/support/chi_square.h"
#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/voxel_fields.h"

using namespace obscura;
using namespace obscura::test;

namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// What one side of a face should send out, W, computed apart from FaceLights.
struct Side {
  FaceId id;
  double power;
  double area;
};

/// Two copies of a mesh at two scales; a mesh of two materials and temperatures; temperatures per vertex
/// and per face, some missing; a double-sided sheet of a net; a sphere and one that is cold.
struct Yard {
  WorldContents contents;
  std::vector<Side> sides;  // an object that is double-sided has each twice
  Band band{"infrared", 8, 12, 1};

  Object place(std::shared_ptr<const Mesh> mesh, const Vec3d& where, const Vec3d& turn, double scale,
               std::vector<int> materials, std::vector<double> K) {
    Object object;
    object.mesh = std::move(mesh);
    object.local_to_world = placement(where, turn, scale);
    object.materials = std::move(materials);
    object.K = std::move(K);
    return object;
  }

  Yard() {
    contents.bands.push_back(band);
    Material angled = grey_material(0.9);
    angled.angle_deg = {0, 90};
    angled.angle_factor = {1, 0.3};
    Material net = grey_material(0.5);
    net.permeable = 0.4;
    contents.materials = {grey_material(0.4), angled, net};
    // 0.9 (1 - 0.7 t / 90) over a cosine-weighted hemisphere: the mean of the angle is pi / 4.
    const double angled_mean = 0.9 * (1 - 0.7 * 0.5);
    const double hemispherical[] = {0.4, angled_mean, 0.5 * 0.6};

    auto steps = std::make_shared<Mesh>();
    steps->vertices = {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 3}, {1, 1, 1}};
    steps->faces = {{0, 1, 2}, {0, 2, 3}, {0, 0, 1}, {1, 4, 2}};  // one has no area
    auto slotted = std::make_shared<Mesh>(*steps);
    slotted->slots = {1, 0, 0, 1};
    auto by_vertex = std::make_shared<Mesh>(*steps);
    by_vertex->vertex_K = {300, 350, 320, kNone, 340};
    auto by_face = std::make_shared<Mesh>(*steps);
    by_face->face_K = {310, kNone, 330, 0};

    contents.objects = {place(steps, {0, 0, 0}, {0.1, 0.2, 0.3}, 1, {0}, {300}),
                        place(steps, {10, 0, 0}, {0, 0.5, 0}, 2, {1}, {280}),
                        place(slotted, {20, 0, 0}, {0, 0, 0}, 1, {0, 1}, {290, 360}),
                        place(by_vertex, {0, 20, 0}, {0, 0, 1}, 1.5, {0}, {290}),
                        place(by_face, {0, 10, 0}, {0, 1, 0}, 1, {1}, {400}),
                        place(steps, {10, 10, 0}, {1, 0, 0}, 1, {2}, {330}),
                        place(nullptr, {20, 20, 0}, {0, 0, 0}, 2, {1}, {320}),
                        place(steps, {30, 0, 0}, {0, 0, 0}, 1, {0}, {0}),
                        place(nullptr, {30, 20, 0}, {0, 0, 0}, 1, {0}, {0}),
                        place(std::make_shared<Mesh>(), {30, 30, 0}, {0, 0, 0}, 1, {0}, {300})};
    contents.objects[5].double_sided = true;
    contents.objects[6].radius = 0.5;
    contents.objects[8].radius = 0.5;

    const double areas[] = {1, 1.5, 0, 0.5 * Vec3d(-1, 1, 1).cross(Vec3d(-2, 1, 0)).length()};
    const auto add = [&](std::uint32_t object, std::uint32_t face, double scale, int material, double radiance) {
      const double area = areas[face] * scale * scale;
      sides.push_back({{object, face}, kPi * hemispherical[material] * radiance * area, area});
    };
    const auto B = [&](double K) { return band.planck(0, K); };
    for (std::uint32_t f : {0u, 1u, 2u, 3u}) add(0, f, 1, 0, B(300));
    for (std::uint32_t f : {0u, 1u, 2u, 3u}) add(1, f, 2, 1, B(280));
    for (std::uint32_t f : {0u, 1u, 2u, 3u}) add(2, f, 1, f % 3 == 0 ? 1 : 0, B(f % 3 == 0 ? 360 : 290));
    // Corners' mean where all have a temperature, else the object's.
    add(3, 0, 1.5, 0, (B(300) + B(350) + B(320)) / 3);
    add(3, 1, 1.5, 0, B(290));
    add(3, 2, 1.5, 0, 0);
    add(3, 3, 1.5, 0, (B(350) + B(340) + B(320)) / 3);
    add(4, 0, 1, 1, B(310));
    add(4, 1, 1, 1, B(400));
    add(4, 2, 1, 1, B(330));
    add(4, 3, 1, 1, 0);
    for (std::uint32_t f : {0u, 1u, 2u, 3u}) add(5, f, 1, 2, B(330));
    sides.push_back({{6, 0}, kPi * angled_mean * B(320) * 4 * kPi, 4 * kPi});
  }
};

}  // namespace

TEST_CASE("the power of faces is that of all their sides", "[photon][face_lights]") {
  const Yard yard;
  const World world(yard.contents);
  const FaceLights& lights = SpectralWorld(world, 0).face_lights();
  double power = 0, probability = 0;
  for (const Side& side : yard.sides) {
    const double count = world.objects()[side.id.surface].double_sided ? 2 : 1;
    power += count * side.power;
    const double density = lights.density({world, 0}, side.id);
    probability += count * density * side.area;
    if (side.area > 0) CHECK(density == Approx(side.power / side.area / lights.power()).epsilon(1e-7).margin(1e-300));
  }
  CHECK_FALSE(lights.empty());
  CHECK(lights.power() == Approx(power).epsilon(1e-7));
  CHECK(probability == Approx(1).epsilon(1e-7));
  for (std::uint32_t f = 0; f < 4; ++f) CHECK(lights.density({world, 0}, {7, f}) == 0);
  CHECK(lights.density({world, 0}, {8, 0}) == 0);
  // Nothing that emits: no power, and no place is asked for.
  WorldContents cold = yard.contents;
  for (Object& object : cold.objects) object.radiance = {0.0};
  const World dark(cold);
  CHECK(SpectralWorld(dark, 0).face_lights().empty());
  CHECK(SpectralWorld(dark, 0).face_lights().power() == 0);
  CHECK(SpectralWorld(dark, 0).face_lights().density({dark, 0}, {0, 0}) == 0);
}

TEST_CASE("faces are chosen by their power, sides alike, and places evenly on them", "[photon][face_lights]") {
  constexpr int kSamples = 400000;
  const Yard yard;
  const World world(yard.contents);
  const FaceLights& lights = SpectralWorld(world, 0).face_lights();
  std::vector<double> faces(2 * yard.sides.size()), expected(faces.size());
  for (std::size_t s = 0; s < yard.sides.size(); ++s) {
    const Side& side = yard.sides[s];
    const double power = kSamples * lights.density({world, 0}, side.id) * side.area;
    expected[2 * s] = power;
    if (world.objects()[side.id.surface].double_sided) expected[2 * s + 1] = power;
  }
  constexpr int kParts = 5;  // of each edge: 25 small triangles
  std::vector<std::vector<double>> places(yard.sides.size(), std::vector<double>(2 * kParts * kParts));
  std::vector<Vec3d> on_sphere;
  Stream random(1, 0, 0);
  double worst = 0, worst_normal = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double u = random.uniform(), v = random.uniform();
    const FaceLights::Place place = lights.sample({world, 0}, u, v, random.uniform());
    std::size_t s = 0;
    while (s < yard.sides.size() && yard.sides[s].id != place.id) ++s;
    if (s == yard.sides.size()) FAIL("a face that does not emit");
    if (place.id.surface == 6) {
      const Vec3d out = (place.position - Vec3d(20, 20, 0)) / 1.0;
      worst = std::max(worst, std::abs(out.length() - 1));
      worst_normal = std::max(worst_normal, (out - place.normal).length());
      ++faces[2 * s];
      on_sphere.push_back(place.normal);
      continue;
    }
    const auto p = world.surfaces().corners(place.id);
    const Vec3d front = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    const bool back = place.normal.dot(front) < 0;
    worst_normal = std::max(worst_normal, (place.normal - (back ? -front : front)).length());
    ++faces[2 * s + (back ? 1 : 0)];
    const double w = 1 - place.u - place.v;
    worst = std::max({worst, -place.u, -place.v, -w});
    worst = std::max(worst, (place.position - (w * p[0] + place.u * p[1] + place.v * p[2])).length());
    // Which of the small triangles: a cell of (u, v), and whether it is that cell's upper half.
    const int a = std::min(static_cast<int>(kParts * place.u), kParts - 1),
              b = std::min(static_cast<int>(kParts * place.v), kParts - 1);
    const bool upper = kParts * (place.u + place.v) - a - b >= 1;
    ++places[s][static_cast<std::size_t>(2 * (a + kParts * b) + upper)];
  }
  CHECK(worst < 1e-9);
  CHECK(worst_normal < 1e-9);
  CHECK(chi_square(faces, expected));
  // By area alone, or by the number of faces, it would fail.
  std::vector<double> by_area(faces.size());
  double area = 0;
  for (const Side& side : yard.sides) area += side.area;
  for (std::size_t s = 0; s < yard.sides.size(); ++s) by_area[2 * s] = kSamples * yard.sides[s].area / area;
  CHECK(!chi_square(faces, by_area));
  int tested = 0;
  for (std::size_t s = 0; s < yard.sides.size(); ++s) {
    const double count = std::accumulate(places[s].begin(), places[s].end(), 0.0);
    if (count < 500) continue;
    std::vector<double> even(places[s].size());
    for (int b = 0; b < kParts; ++b) {
      for (int a = 0; a + b < kParts; ++a) {
        even[static_cast<std::size_t>(2 * (a + kParts * b))] = count / (kParts * kParts);
        if (a + b + 1 < kParts) even[static_cast<std::size_t>(2 * (a + kParts * b) + 1)] = count / (kParts * kParts);
      }
    }
    INFO("side " << s);
    CHECK(chi_square(places[s], even, 30));
    ++tested;
  }
  CHECK(tested >= 14);
  std::size_t next = 0;
  CHECK(on_sphere.size() > 1000);
  CHECK(chi_square_directions([&] { return on_sphere[next++]; }, [](const Vec3d&) { return 1 / (4 * kPi); },
                              static_cast<int>(on_sphere.size())));
}

TEST_CASE("a place emits what Kirchhoff's law says of its temperature and angle", "[photon][face_lights]") {
  const Yard yard;
  const World world(yard.contents);
  const FaceLights& lights = SpectralWorld(world, 0).face_lights();
  const auto emission = [&](const FaceId& id, double u, double v, double cosine) {
    return lights.emission({world, 0}, {id, Vec3d(0), Vec3d(0), u, v}, cosine);
  };
  const Band& band = yard.band;
  CHECK(emission({0, 1}, 0.2, 0.3, 0.4) == Approx(0.4 * band.planck(0, 300)).epsilon(1e-9));
  CHECK(emission({1, 0}, 0.2, 0.3, std::cos(kPi / 4)) == Approx(0.9 * 0.65 * band.planck(0, 280)).epsilon(1e-9));
  CHECK(emission({2, 3}, 0.2, 0.3, 1) == Approx(0.9 * band.planck(0, 360)).epsilon(1e-9));
  // Temperatures are linear over a face: 0.5 300 + 0.2 350 + 0.3 320.
  CHECK(emission({3, 0}, 0.2, 0.3, 1) == Approx(0.4 * band.planck(0, 316)).epsilon(1e-7));
  CHECK(emission({3, 1}, 0.2, 0.3, 1) == Approx(0.4 * band.planck(0, 290)).epsilon(1e-9));
  CHECK(emission({4, 1}, 0.2, 0.3, 1) == Approx(0.9 * band.planck(0, 400)).epsilon(1e-9));
  CHECK(emission({4, 3}, 0.2, 0.3, 1) == 0);
  CHECK(emission({5, 0}, 0.2, 0.3, 1) == Approx(0.5 * 0.6 * band.planck(0, 330)).epsilon(1e-9));
  CHECK(emission({7, 0}, 0.2, 0.3, 1) == 0);
}
