// Hard cases of surfaces, each with its right answer: broken and coincident triangles, faces in voxel faces,
// cameras on surfaces, touching bodies, sizes from a micrometre to ten thousand kilometres.
#include "photon/world/surfaces.h"

#include <catch2/catch.hpp>

#include "photon/optics/sampling.h"
#include "sensor/capture/render.h"
#include "tests/support/agree.h"
#include "tests/support/rendered.h"
#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

constexpr double kB = 3.7;

TraceSettings photons(std::uint64_t count) {
  TraceSettings settings;
  settings.photons = count;
  return settings;
}

RadianceParts only_background() { return {true, true, true, false, false, false, false, false}; }

/// What one ray sees without any light that is scattered or reflected.
double unscattered(const World& world, const Vec3d& from, const Vec3d& direction) {
  RadianceSettings settings;
  settings.parts = only_background();
  return ray_radiance(world, {}, {from, direction.normalized(), 0, kInfinity}, 1, settings).mean;
}

double total(const BatchTally& tally) { return pairwise_sum(tally); }

/// The picture holds nothing but numbers, and nothing was left out on the way to it.
void check_numbers(const World& world, const Vec3d& from, const Vec3d& at, std::uint64_t count = 20000) {
  const Light light = trace_light(world, photons(count));
  CHECK(light.anomalies == 0);
  CameraSettings camera;
  camera.position_m = from;
  camera.look_at_m = at;
  camera.up = {0.1, 0.2, 1};
  camera.fov_deg = 60;
  camera.resolution = {16, 12};
  const Rendered rendered =
      test::render_pass(world, light.maps, Camera(camera), {.max_oversampling = 2, .seed = 1}, {});
  CHECK(rendered.counts.anomalies == 0);
  const auto values = rendered.film.values(0, Film::Value::radiance);
  CHECK(std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v) && v >= 0; }));
  const EnergyTally& energy = light.bands[0].energy;
  CHECK(total(energy.absorbed) + total(energy.surface) + total(energy.escaped) + total(energy.truncated) ==
        Approx(total(energy.emitted)).epsilon(1e-9).margin(1e-300));
}

}  // namespace

TEST_CASE("triangles without area emit nothing and change nothing", "[stability][surfaces]") {
  WorldContents plain = empty_contents(0.5);
  plain.materials = {grey_material(0.6)};
  plain.objects = {grey_object(parallelogram({0, 0, 0}, {2, 0, 0}, {0, 1, 0}), 0, kB)};
  WorldContents broken = plain;
  auto mesh = std::make_shared<Mesh>(*plain.objects[0].mesh);
  mesh->vertices.push_back({1, 0.5, 0});  // on the diagonal
  mesh->vertices.push_back({0.5, 0.5, 2});
  mesh->vertices.push_back({0.5, 0.5, 2});
  mesh->faces.insert(mesh->faces.begin(), {0, 0, 0});
  mesh->faces.push_back({0, 4, 2});  // three in a line
  mesh->faces.push_back({5, 6, 5});  // a point in the air
  mesh->faces.push_back({1, 5, 6});  // a line through the air
  broken.objects[0].mesh = mesh;
  const World a(plain), b(broken);
  CHECK(SpectralWorld(b, 0).face_lights().power() == Approx(SpectralWorld(a, 0).face_lights().power()).epsilon(1e-14));
  CHECK(SpectralWorld(b, 0).face_lights().power() == Approx(kPi * 0.6 * kB * 2).epsilon(1e-14));
  Stream random(1, 0, 0);
  int met = 0;
  for (int i = 0; i < 500; ++i) {
    const double x = 2.2 * random.uniform() - 0.1;
    const Vec3d from(x, random.uniform(), 3);
    const double seen = unscattered(b, from, {0, 0, -1});
    CHECK(seen == unscattered(a, from, {0, 0, -1}));
    CHECK(seen == Approx(x > 0 && x < 2 ? 0.6 * kB : 0.5).epsilon(1e-12));
    met += seen > 1;
    // Along the line of the broken ones.
    CHECK(unscattered(b, {0.5, 0.5 + 1e-3 * random.uniform(), 3}, {0, 0, -1}) == Approx(0.6 * kB).epsilon(1e-12));
  }
  CHECK(met > 400);
  check_numbers(b, {1, 0.4, 3}, {1, 0.5, 0});
}

TEST_CASE("a body turned inside out is black and cold from outside and shines inward", "[stability][surfaces]") {
  for (const bool inward : {false, true}) {
    WorldContents contents = empty_contents(0.5);
    contents.materials = {grey_material(0.6)};
    contents.objects = {grey_object(box_mesh({0, 0, 0}, {1, 1, 1}, inward), 0, kB)};
    const World world(contents);
    CHECK(unscattered(world, {0.3, 0.4, 3}, {0, 0, -1}) ==
          Approx(inward ? 0.0 : 0.6 * kB).margin(1e-300).epsilon(1e-12));
    CHECK(unscattered(world, {0.3, 0.4, 0.5}, {0, 0, -1}) ==
          Approx(inward ? 0.6 * kB : 0.0).margin(1e-300).epsilon(1e-12));
    // Nothing leaves the one, nothing stays in the other; all that meets a back ends there.
    const EnergyTally energy = trace_light(world,
                                           [&] {
                                             TraceSettings settings = photons(20000);
                                             settings.sources.sky = false;
                                             return settings;
                                           }())
                                   .bands[0]
                                   .energy;
    CHECK(total(energy.emitted) == Approx(kPi * 0.6 * kB * 6).epsilon(1e-6));
    CHECK(total(inward ? energy.escaped : energy.surface) == Approx(0).margin(1e-9));
    CHECK(total(inward ? energy.surface : energy.escaped) == Approx(total(energy.emitted)).epsilon(1e-9));
  }
}

TEST_CASE("sheets that share an edge three by three are each met on their own side", "[stability][surfaces]") {
  // Three half planes about the z axis, at 0, 120 and 240 degrees; one temperature each by its object.
  WorldContents contents = empty_contents(0.5);
  contents.materials = {grey_material(0.6)};
  for (int i = 0; i < 3; ++i) {
    const double angle = i * 2 * kPi / 3;
    Object sheet =
        grey_object(parallelogram({0, 0, -1}, {std::cos(angle), std::sin(angle), 0}, {0, 0, 2}), 0, kB * (i + 1));
    sheet.double_sided = true;
    contents.objects.push_back(sheet);
  }
  const World world(contents);
  Stream random(2, 0, 0);
  int hits = 0;
  for (int i = 0; i < 3000; ++i) {
    // From a point of the circle to the axis or nearly so: a gap at the edge would show the sky.
    const double angle = 2 * kPi * random.uniform();
    const Vec3d from(2 * std::cos(angle), 2 * std::sin(angle), 0.3);
    const double beside = i % 2 ? 0 : 1e-5;
    const Vec3d aim(-beside * std::sin(angle), beside * std::cos(angle), 1.6 * random.uniform() - 0.8);
    const double seen = unscattered(world, from, aim - from);
    const bool one_of_three = std::abs(seen / (0.6 * kB) - std::round(seen / (0.6 * kB))) < 1e-9;
    CHECK(one_of_three);
    hits += seen > 0.6;
    // At the edge it may be any of the three, which are all at the same distance. Beside it, from between
    // two sheets, it can only be one of these two.
    const int sector = static_cast<int>(angle / (2 * kPi / 3));
    const int met = static_cast<int>(std::round(seen / (0.6 * kB))) - 1;
    if (beside > 0) CHECK((met == sector || met == (sector + 1) % 3));
  }
  CHECK(hits == 3000);
  check_numbers(world, {2, 1, 0.3}, {0, 0, 0});
}

TEST_CASE("a surface in a voxel face ends the cloud there, exactly, from both sides", "[stability][surfaces]") {
  // Layers of different extinction along x, and a black sheet at x = 4, the face between two of them.
  CloudWish wish;
  wish.voxels = {8, 8, 8};
  wish.voxel_m = 0.5;
  wish.density = [](const Vec3i& v) { return 0.1 * (v.x + 1); };
  wish.source = 2;
  for (const bool shifted : {false, true}) {
    const Vec3d corner = shifted ? Vec3d(0.1, 0.7, 0.3) : Vec3d(0);
    wish.corner_m = corner;
    WorldContents contents = grey_contents(wish, 0.5);
    contents.materials = {grey_material(1)};
    Object sheet = grey_object(parallelogram(corner + Vec3d(2, -9, -9), {0, 18, 0}, {0, 0, 18}), 0, kB);
    sheet.double_sided = true;
    contents.objects = {sheet};
    const World world(contents);
    double left = 0, right = 0;
    for (int i = 0; i < 4; ++i) left += 0.5 * 0.1 * (i + 1);
    for (int i = 4; i < 8; ++i) right += 0.5 * 0.1 * (i + 1);
    Stream random(3, 0, 0);
    for (int i = 0; i < 50; ++i) {
      // Among them rays along voxel faces and edges.
      const double y = i < 5 ? 0.5 * i + 0.5 : 0.05 + 3.9 * random.uniform();
      const double z = i < 3 ? 1.0 : 0.05 + 3.9 * random.uniform();
      for (const bool from_left : {true, false}) {
        const double depth = from_left ? left : right;
        const Ray ray{corner + Vec3d(from_left ? -3 : 7, y, z), {from_left ? 1.0 : -1.0, 0, 0}, 0, kInfinity};
        std::vector<Incoming> in(1);
        RadianceSettings settings;
        settings.parts = only_background();
        incoming_radiance({world, 0}, nullptr, settings, std::span(&ray, 1), std::array<std::uint64_t, 1>{0}, in);
        CHECK(in[0].transmission == Approx(std::exp(-depth)).epsilon(1e-6));
        CHECK(in[0].distance == Approx(5).epsilon(1e-12));
        CHECK(in[0].direct == Approx(kB * std::exp(-depth) + 2 * (1 - std::exp(-depth))).epsilon(1e-6));
      }
      // From the sheet itself outward: the other half does not exist.
      const Vec3d on = corner + Vec3d(2, y, z);
      CHECK(unscattered(world, on + Vec3d(1e-9, 0, 0), {1, 0, 0}) ==
            Approx(0.5 * std::exp(-right) + 2 * (1 - std::exp(-right))).epsilon(1e-6));
      CHECK(unscattered(world, on - Vec3d(1e-9, 0, 0), {-1, 0, 0}) ==
            Approx(0.5 * std::exp(-left) + 2 * (1 - std::exp(-left))).epsilon(1e-6));
    }
  }
}

TEST_CASE("no photon passes a sheet in a voxel face", "[stability][surfaces]") {
  CloudWish wish;
  wish.voxels = {8, 8, 8};
  wish.voxel_m = 0.5;
  wish.albedo = 0.99;
  wish.extinction = 3;
  WorldContents contents = grey_contents(wish);
  contents.materials = {grey_material(0.3)};
  Object sheet = grey_object(parallelogram({2, -9, -9}, {0, 18, 0}, {0, 0, 18}), 0, 0);
  sheet.double_sided = true;
  contents.objects = {sheet};
  contents.beams.push_back({{-2, 2, 2}, {1, 0, 0}, 1, {5}});
  const World world(contents);
  const TraceResult result = trace_photons({world, 0}, photons(20000));
  int beyond = 0;
  for (const Photon& photon : result.photons) {
    beyond += transform_point(world.map_to_world(), Vec3d(photon.position)).x > 2;
  }
  CHECK(result.photons.size() > 50000);
  CHECK(beyond == 0);
  CHECK(total(result.energy.surface) > 0.1);
}

TEST_CASE("a camera on a surface sees what is before it, and along it the sky", "[stability][surfaces]") {
  WorldContents contents = empty_contents(0.5);
  contents.materials = {grey_material(0.6)};
  contents.objects = {grey_object(parallelogram({-5, -5, 0}, {10, 0, 0}, {0, 10, 0}), 0, kB),
                      grey_object(parallelogram({-5, -5, 2}, {0, 10, 0}, {10, 0, 0}), 0, 3 * kB),
                      grey_sphere({0, 0, 10}, 2, 0, 2 * kB)};
  const World world(contents);
  Stream random(4, 0, 0);
  for (int i = 0; i < 200; ++i) {
    const double x = 4 * random.uniform() - 2;
    const Vec3d on(x, 4 * random.uniform() - 2, 0);
    CHECK(unscattered(world, on, {0.1 * x, 0.1, 1}) == Approx(3 * 0.6 * kB).epsilon(1e-12));
    // In its plane it meets nothing, wherever it goes.
    const double angle = 2 * kPi * random.uniform();
    CHECK(unscattered(world, on, {std::cos(angle), std::sin(angle), 0}) == 0.5);
    // Just below the horizon from just above the surface, the floor again.
    CHECK(unscattered(world, on + Vec3d(0, 0, 1e-6), {std::cos(angle), std::sin(angle), -1e-4}) ==
          Approx(0.6 * kB).epsilon(1e-12));
    // On a sphere, outward.
    const double u = random.uniform();
    const Vec3d out = uniform_direction(u, random.uniform());
    if (out.z > 0.1) CHECK(unscattered(world, Vec3d(0, 0, 10) + 2.0 * out, out) == 0.5);
  }
  check_numbers(world, {0.5, 0.25, 0}, {0.6, 0.2, 1});
  check_numbers(world, {0.5, 0.25, 0}, {3, 2, 0});
}

TEST_CASE("a sphere that touches a plane leaves no gap and lights the floor about its foot", "[stability][surfaces]") {
  WorldContents contents = empty_contents();
  contents.materials = {grey_material(1), grey_material(0.5)};
  contents.objects = {grey_object(parallelogram({-50, -50, 0}, {100, 0, 0}, {0, 100, 0}), 1, 0),
                      grey_sphere({0, 0, 1}, 1, 0, kB)};
  const World world(contents);
  // Through the touching point from above: the sphere; grazing it from the side: sphere or floor, never the
  // dark sky between them.
  CHECK(unscattered(world, {0, 0, 5}, {0, 0, -1}) == Approx(kB));
  Stream random(5, 0, 0);
  for (int i = 0; i < 300; ++i) {
    const double angle = 2 * kPi * random.uniform();
    const Vec3d from(3 * std::cos(angle), 3 * std::sin(angle), 0.2);
    const SurfaceHit hit = world.surfaces().intersect({from, -from.normalized(), 0, kInfinity});
    REQUIRE(hit.exists());
    CHECK(from.length() - hit.t < 0.25);
    CHECK(from.length() - hit.t > -0.01);
  }
  // At the distance s from the foot a plane sees of the sphere E = pi B h / d^3 with h = 1, d^2 = 1 + s^2,
  // while all of it is above the horizon: it touches the horizon everywhere.
  for (const double s : {0.02, 0.5, 2.0}) {
    const Vec3d foot(s, 0, 0);
    const Vec3d from = foot + Vec3d(1, 0, 0.05 * s * s);
    const double d = std::sqrt(1 + s * s);
    const RayRadiance seen = ray_radiance(world, {}, {from, (foot - from).normalized(), 0, kInfinity}, 150000);
    CHECK(agree(seen.mean, seen.error, 0.5 * kB / (d * d * d), {.resolution = 0.05, .comparisons = 3}));
  }
  check_numbers(world, {3, 0, 1}, {0, 0, 0});
}

TEST_CASE("thousands of coincident copies are as one", "[stability][surfaces]") {
  const auto seen_by_floor = [](int copies, bool in_one_mesh) {
    WorldContents contents = empty_contents(0.1);
    contents.materials = {grey_material(0.6), grey_material(0.5)};
    auto mesh = std::make_shared<Mesh>(*parallelogram({-1, -1, 1}, {0, 2, 0}, {2, 0, 0}));
    if (in_one_mesh) {
      const auto faces = mesh->faces;
      for (int i = 1; i < copies; ++i) mesh->faces.insert(mesh->faces.end(), faces.begin(), faces.end());
    }
    contents.objects.push_back(grey_object(parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), 1, 0));
    for (int i = 0; i < (in_one_mesh ? 1 : copies); ++i) contents.objects.push_back(grey_object(mesh, 0, kB));
    const World world(contents);
    // Looked at, whichever copy it is, it is there once.
    CHECK(unscattered(world, {0.3, 0.2, 0.5}, {0, 0, 1}) == Approx(0.6 * kB).epsilon(1e-12));
    const SurfaceHit hit = world.surfaces().intersect({{0.3, 0.2, 0.5}, {0, 0, 1}, 0, kInfinity});
    CHECK(hit.id.surface == 1);
    CHECK(hit.id.face < 2);
    const RayRadiance seen = ray_radiance(world, {}, {{0.3, 0.2, 0.5}, {0, 0, -1}, 0, kInfinity}, 3000);
    TraceSettings settings = photons(500);
    settings.sources.sky = false;
    const BandLight light = trace_light(world, settings).bands[0];
    return std::array<double, 3>{seen.mean, seen.error, total(light.energy.emitted)};
  };
  const auto one = seen_by_floor(1, false);
  for (const bool in_one_mesh : {false, true}) {
    INFO((in_one_mesh ? "faces" : "objects"));
    const auto many = seen_by_floor(1000, in_one_mesh);
    CHECK(agree(many[0], many[1], one[0], {.resolution = 0.1, .reference_error = one[1], .comparisons = 2}));
    CHECK(many[2] == Approx(one[2]).epsilon(0.1));
  }
}

TEST_CASE("mirrors that face each other end, with and without light of their own", "[stability][surfaces]") {
  for (const double emissivity : {0.0, 0.1}) {
    WorldContents contents = empty_contents(0.5);
    contents.materials = {grey_material(emissivity, 1)};
    contents.objects = {grey_object(parallelogram({-5, -5, 0}, {10, 0, 0}, {0, 10, 0}), 0, kB),
                        grey_object(parallelogram({-5, -5, 1}, {0, 10, 0}, {10, 0, 0}), 0, kB)};
    const World world(contents);
    RadianceSettings settings;
    settings.parts = only_background();
    settings.specular_depth = 6;
    const double seen = ray_radiance(world, {}, {{0, 0, 0.5}, {0, 0, 1}, 0, kInfinity}, 1, settings).mean;
    // Seven mirrors are seen one behind another; the last one's reflection is cut off.
    CHECK(seen == Approx(kB * (1 - std::pow(1 - emissivity, 7))).margin(1e-12));
    check_numbers(world, {0, 0, 0.5}, {0, 1, 1}, 5000);
  }
  // A closed box of perfect mirrors: a beam goes round until it is cut off, and every watt of it is told.
  WorldContents contents = empty_contents();
  contents.materials = {grey_material(0, 1)};
  contents.objects = {grey_object(box_mesh({0, 0, 0}, {1, 2, 3}, true), 0, 0)};
  contents.beams.push_back({{0.5, 0.5, 0.5}, Vec3d(1, 2, 3).normalized(), 0.1, {5}});
  const World world(contents);
  const EnergyTally energy = trace_photons({world, 0}, photons(50)).energy;
  CHECK(total(energy.truncated) == Approx(5).epsilon(1e-9));
  CHECK(total(energy.escaped) == 0);
}

TEST_CASE("ten thousand kilometres and a micrometre are both right in one scene", "[stability][surfaces]") {
  WorldContents contents = empty_contents(0.5);
  contents.materials = {grey_material(0.6)};
  const double size = 1e7;
  contents.objects = {grey_object(parallelogram({-0.5 * size, -0.5 * size, -2}, {size, 0, 0}, {0, size, 0}), 0, kB),
                      grey_object(parallelogram({0, 0, 0}, {1e-6, 0, 0}, {0, 1e-6, 0}), 0, 2 * kB),
                      grey_sphere({3, 0, 0}, 1e-6, 0, 3 * kB)};
  const World world(contents);
  CHECK(SpectralWorld(world, 0).face_lights().power() ==
        Approx(kPi * 0.6 * kB * (size * size + 2e-12 + 3 * 4 * kPi * 1e-12)).epsilon(1e-12));
  Stream random(6, 0, 0);
  int small = 0, sphere = 0;
  for (int i = 0; i < 200; ++i) {
    const double x = 1e-6 * random.uniform(), y = 1e-6 * random.uniform();
    small += unscattered(world, {x, y, 1e-3}, {0, 0, -1}) == Approx(2 * 0.6 * kB);
    sphere += unscattered(world, {3 + 0.9 * (x - 0.5e-6), 0, 1e-3}, {0, 0, -1}) == Approx(3 * 0.6 * kB);
    // Beside them, and far out, the plane.
    CHECK(unscattered(world, {x + 2e-6, y, 1e-3}, {0, 0, -1}) == Approx(0.6 * kB).epsilon(1e-12));
    CHECK(unscattered(world, {0.4 * size * (2 * random.uniform() - 1), 1, 5}, {0, 0, -1}) ==
          Approx(0.6 * kB).epsilon(1e-12));
  }
  CHECK(small == 200);
  CHECK(sphere == 200);
  check_numbers(world, {1, 1, 3}, {0, 0, 0});
}

TEST_CASE("a mesh without faces is nothing at all", "[stability][surfaces]") {
  CloudWish wish = rough_wish(0.7, 0, 2);
  WorldContents without = grey_contents(wish, 0.5);
  WorldContents with = without;
  auto nothing = std::make_shared<Mesh>();
  auto points = std::make_shared<Mesh>();
  points->vertices = {{1, 1, 1}, {2, 2, 2}, {900, 900, 900}};  // that no face uses
  with.materials = {grey_material(0.6)};
  with.objects = {grey_object(nothing, 0, kB), grey_object(points, 0, kB)};
  const World a(without), b(with);
  CHECK(b.surfaces().empty());
  CHECK(SpectralWorld(b, 0).face_lights().empty());
  CHECK(b.bounds() == a.bounds());
  const Light light_a = trace_light(a, photons(5000)), light_b = trace_light(b, photons(5000));
  const Ray ray{{-1, 1.5, 1.6}, {1, 0, 0}, 0, kInfinity};
  CHECK(ray_radiance(a, light_a, ray, 20).mean == ray_radiance(b, light_b, ray, 20).mean);
  // Among others it is as if it were not there.
  with.objects.push_back(grey_sphere({1.6, 1.6, 8}, 1, 0, kB));
  const World c(with);
  CHECK(c.surfaces().intersect({{1.6, 1.6, 20}, {0, 0, -1}, 0, kInfinity}).id.surface == 2);
  check_numbers(c, {-3, 1, 8}, {1.6, 1.6, 5});
}
