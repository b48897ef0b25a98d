// Irradiance from photons on surfaces: planes, edges, corners, spheres and sheets that are lit evenly.
#include "photon/map/surface_density.h"

#include <catch2/catch.hpp>

#include "octree/base/statistics.h"
#include "photon/optics/sampling.h"
#include "tests/support/agree.h"
#include "tests/support/shapes_of_surfaces.h"

using namespace obscura;
using namespace obscura::test;

namespace {

constexpr double kIrradiance = 3;

/// Photons on surfaces, in the frame of the World's maps.
struct Landed {
  const World& world;
  std::vector<Photon> photons;
  Stream random;

  void add(const Vec3d& position, const Vec3d& normal, double power, const Vec3d& travels) {
    Photon photon;
    photon.position = Vec3f(transform_point(world.world_to_map(), position));
    photon.direction = encode_direction(travels);
    photon.power = static_cast<float>(power);
    photon.batch = static_cast<std::uint16_t>(photons.size() % kBatches);
    photon.collisions = encode_normal(normal);
    photons.push_back(photon);
  }
  /// Evenly over a parallelogram, independent of one another.
  void lay(int count, const Vec3d& corner, const Vec3d& u, const Vec3d& v, double irradiance, double flip = 1) {
    const Vec3d normal = flip * u.cross(v).normalized();
    const double power = irradiance * u.cross(v).length() / count;
    for (int i = 0; i < count; ++i) {
      const double a = random.uniform();
      add(corner + a * u + random.uniform() * v, normal, power, -normal);
    }
  }
};

SurfacePoint seen(const World& world, const Vec3d& above, const Vec3d& direction) {
  const Ray ray{above, direction.normalized(), 0, kInfinity};
  const SurfaceHit hit = world.surfaces().intersect(ray);
  REQUIRE(hit.exists());
  return SpectralWorld(world, 0).surface_at(ray, hit);
}

const auto one = [](const Vec3d&) { return 1.0; };

/// Mean over places; `where` gives a place and a way of looking at it.
template <class Where>
Moments irradiance(const World& world, const PhotonMap& map, int count, const Where& where,
                   const GatherSettings& settings = {}) {
  Stream random(4, 0, 0);
  Moments result;
  for (int i = 0; i < count; ++i) {
    const auto [above, direction] = where(random);
    const SurfacePoint at = seen(world, above, direction);
    result.add(surface_estimate({world, 0}, map, at, one, settings, Vec3d(i, 1, 0)).value);
  }
  return result;
}

/// Mean over sets of photons that are laid anew, and its error.
/// @param lay void(Landed&)
template <class Lay, class Where>
Moments many_times(const World& world, int rounds, const Lay& lay, const Where& where, int places = 100) {
  Moments result;
  for (int round = 0; round < rounds; ++round) {
    Landed landed{world, {}, Stream(9, static_cast<std::uint64_t>(round), 0)};
    lay(landed);
    result.add(irradiance(world, PhotonMap(landed.photons), places, where).mean());
  }
  return result;
}

/// Within a bound that the error is small enough to hold.
void check_within(const Moments& value, double expected, double bound) {
  INFO(value.mean() << " +- " << value.standard_error() << " against " << expected);
  CHECK(std::abs(value.mean() - expected) < bound * expected);
  CHECK(value.standard_error() < bound * expected / 3);
}

using Look = std::pair<Vec3d, Vec3d>;
const Vec3d kDown(0, 0, -1);

WorldContents square_of(double side) {
  WorldContents contents = empty_contents();
  contents.materials = {grey_material(0.5)};
  contents.objects = {grey_object(parallelogram({0, 0, 0}, {side, 0, 0}, {0, side, 0}), 0, 0)};
  return contents;
}

}  // namespace

TEST_CASE("kernels over the disc integrate to 1, and their points are as dense as they are high",
          "[photon][surface_density]") {
  for (const Kernel kernel : {Kernel::constant, Kernel::epanechnikov, Kernel::cone, Kernel::gaussian}) {
    double sum = 0;
    constexpr int kSteps = 100000;
    for (int i = 0; i < kSteps; ++i) sum += kPi * obscura::detail::disc_kernel(kernel, (i + 0.5) / kSteps) / kSteps;
    CHECK(sum == Approx(1).epsilon(1e-5));
    CHECK(obscura::detail::disc_kernel(kernel, 1) == 0);
    // Mean of 1 / kernel over its points is the disc's area; the mean of u is that under the kernel.
    double mean_u = 0, kernel_u = 0;
    for (const obscura::detail::DiscPoint& point : obscura::detail::disc_points(kernel))
      mean_u += (point.x * point.x + point.y * point.y) / obscura::detail::kRoundPoints;
    for (int i = 0; i < kSteps; ++i) {
      const double u = (i + 0.5) / kSteps;
      kernel_u += kPi * obscura::detail::disc_kernel(kernel, u) * u / kSteps;
    }
    CHECK(mean_u == Approx(kernel_u).epsilon(0.01));
  }
}

TEST_CASE("an even plane has its irradiance, with every kernel and number of neighbours", "[photon][surface_density]") {
  const World world(square_of(10));
  Landed landed{world, {}, Stream(9, 0, 0)};
  landed.lay(100000, {0, 0, 0}, {10, 0, 0}, {0, 10, 0}, kIrradiance);
  const PhotonMap map(landed.photons);
  for (const Kernel kernel : {Kernel::constant, Kernel::epanechnikov, Kernel::cone, Kernel::gaussian}) {
    for (const int nearest : {16, 64, 200}) {
      GatherSettings settings;
      settings.kernel = kernel;
      settings.nearest = nearest;
      const Moments mean = irradiance(
          world, map, 1500,
          [](Stream& random) {
            const double x = 2 + 6 * random.uniform();
            return Look{{x, 2 + 6 * random.uniform(), 1}, kDown};
          },
          settings);
      INFO("kernel " << static_cast<int>(kernel) << ", k = " << nearest << ": " << mean.mean() << " +- "
                     << mean.standard_error());
      // Places share photons, hence a bound in place of the standard error: k / (k - 1) would show at 16.
      CHECK(mean.mean() == Approx(kIrradiance).epsilon(0.02));
      CHECK(std::sqrt(mean.variance()) < 2.0 * kIrradiance / std::sqrt(nearest));
    }
  }
}

TEST_CASE("batches are shares of the value, weights see where light travels, bias is small where all is even",
          "[photon][surface_density]") {
  const World world(square_of(10));
  Landed landed{world, {}, Stream(9, 0, 0)};
  landed.lay(100000, {0, 0, 0}, {10, 0, 0}, {0, 10, 0}, kIrradiance);
  const PhotonMap map(landed.photons);
  const SurfacePoint at = seen(world, {5, 5, 1}, kDown);
  const Estimate all = surface_estimate({world, 0}, map, at, one, {}, Vec3d(0));
  double mean = 0;
  for (const double batch : all.batch) mean += batch / kBatches;
  CHECK(all.value == Approx(mean).epsilon(1e-12));
  CHECK(all.photons == GatherSettings{}.nearest - 1);
  const Estimate down = surface_estimate(
      {world, 0}, map, at, [](const Vec3d& w) { return w.z < -0.99 ? 0.25 : 100.0; }, {}, Vec3d(0));
  CHECK(down.value == Approx(0.25 * all.value).epsilon(1e-12));
  Moments bias;
  Stream random(1, 0, 0);
  for (int i = 0; i < 400; ++i) {
    const double x = 2 + 6 * random.uniform();
    bias.add(
        surface_estimate({world, 0}, map, seen(world, {x, 2 + 6 * random.uniform(), 1}, kDown), one, {}, Vec3d(i, 0, 0))
            .bias);
  }
  CHECK(std::abs(bias.mean()) < 0.05 * kIrradiance);
}

TEST_CASE("a plane's edge and corner are as bright as its middle", "[photon][surface_density]") {
  const World world(square_of(10));
  const auto lay = [](Landed& landed) { landed.lay(20000, {0, 0, 0}, {10, 0, 0}, {0, 10, 0}, kIrradiance); };
  check_within(many_times(world, 40, lay,
                          [](Stream& random) {
                            return Look{{1e-6, 1 + 8 * random.uniform(), 1}, kDown};
                          }),
               kIrradiance, 0.03);
  check_within(many_times(
                   world, 60, lay,
                   [](Stream& random) {
                     const double x = 0.02 * random.uniform();
                     return Look{{x, 0.02 * random.uniform(), 1}, kDown};
                   },
                   20),
               kIrradiance, 0.08);
}

TEST_CASE("a small square with fewer photons than are asked for has its mean irradiance", "[photon][surface_density]") {
  const World world(square_of(0.3));
  Moments mean;
  for (int round = 0; round < 200; ++round) {
    Landed landed{world, {}, Stream(9, static_cast<std::uint64_t>(round), 0)};
    landed.lay(40, {0, 0, 0}, {0.3, 0, 0}, {0, 0.3, 0}, kIrradiance);
    const PhotonMap map(landed.photons);
    mean.add(irradiance(world, map, 5, [](Stream& random) {
               const double x = 0.05 + 0.2 * random.uniform();
               return Look{{x, 0.05 + 0.2 * random.uniform(), 1}, kDown};
             }).mean());
  }
  INFO(mean.mean() << " +- " << mean.standard_error());
  CHECK(mean.mean() == Approx(kIrradiance).epsilon(0.05));
}

TEST_CASE("in a corner of two walls each keeps its own light", "[photon][surface_density]") {
  WorldContents contents = square_of(4);
  contents.objects.push_back(grey_object(parallelogram({0, 0, 0}, {0, 4, 0}, {0, 0, 4}), 0, 0));  // faces +x
  const World world(contents);
  const auto lay = [](Landed& landed) {
    landed.lay(20000, {0, 0, 0}, {4, 0, 0}, {0, 4, 0}, kIrradiance);
    landed.lay(40000, {0, 0, 0}, {0, 4, 0}, {0, 0, 4}, 5 * kIrradiance);
  };
  for (const double from_wall : {1e-6, 0.02, 0.1}) {
    INFO("at " << from_wall);
    check_within(many_times(world, 20, lay,
                            [&](Stream& random) {
                              return Look{{from_wall, 0.5 + 3 * random.uniform(), 1}, kDown};
                            }),
                 kIrradiance, 0.04);
    check_within(many_times(world, 20, lay,
                            [&](Stream& random) {
                              return Look{{1, 0.5 + 3 * random.uniform(), from_wall}, {-1, 0, 0}};
                            }),
                 5 * kIrradiance, 0.04);
  }
}

TEST_CASE("an even sphere has its irradiance outside and inside", "[photon][surface_density]") {
  for (const bool inside : {false, true}) {
    WorldContents contents = empty_contents();
    contents.materials = {grey_material(0.5)};
    Object ball = grey_sphere({0, 0, 0}, 1, 0, 0);
    ball.double_sided = true;
    contents.objects = {ball};
    const World world(contents);
    const auto lay = [&](Landed& landed) {
      constexpr int kCount = 20000;
      for (int i = 0; i < kCount; ++i) {
        const double u = landed.random.uniform();
        const Vec3d out = uniform_direction(u, landed.random.uniform());
        const Vec3d normal = inside ? -out : out;
        landed.add(out, normal, kIrradiance * 4 * kPi / kCount, -normal);
      }
    };
    INFO((inside ? "inside" : "outside"));
    check_within(many_times(world, 15, lay,
                            [&](Stream& random) {
                              const double u = random.uniform();
                              const Vec3d out = uniform_direction(u, random.uniform());
                              return inside ? Look{Vec3d(0), out} : Look{2.0 * out, -out};
                            }),
                 kIrradiance, 0.02);
  }
}

TEST_CASE("the two sides of a thin sheet never share light", "[photon][surface_density]") {
  WorldContents contents = square_of(4);
  contents.objects[0].double_sided = true;
  const World world(contents);
  const auto look = [](double height) {
    return [height](Stream& random) {
      const double x = 1 + 2 * random.uniform();
      return Look{{x, 1 + 2 * random.uniform(), height}, {0, 0, -height}};
    };
  };
  const auto lay_above = [](Landed& landed) { landed.lay(20000, {0, 0, 0}, {4, 0, 0}, {0, 4, 0}, kIrradiance); };
  check_within(many_times(world, 10, lay_above, look(1)), kIrradiance, 0.03);
  CHECK(many_times(world, 2, lay_above, look(-1)).mean() == 0);
  const auto lay_both = [&](Landed& landed) {
    lay_above(landed);
    landed.lay(40000, {0, 0, 0}, {4, 0, 0}, {0, 4, 0}, 7 * kIrradiance, -1);
  };
  check_within(many_times(world, 15, lay_both, look(1)), kIrradiance, 0.03);
  check_within(many_times(world, 15, lay_both, look(-1)), 7 * kIrradiance, 0.03);
}

TEST_CASE("photons behind a wall do not count, and the wall takes no light away", "[photon][surface_density]") {
  for (const double thickness : {0.0, 0.02}) {
    WorldContents contents = square_of(4);
    // A thin wall on the floor at x = 2, lit on the far side alone.
    if (thickness > 0) {
      contents.objects.push_back(grey_object(box_mesh({2, -1, -1}, {2 + thickness, 5, 3}, false), 0, 0));
    } else {
      Object sheet = grey_object(parallelogram({2, -1, -1}, {0, 6, 0}, {0, 0, 4}), 0, 0);
      sheet.double_sided = true;
      contents.objects.push_back(sheet);
    }
    const World world(contents);
    const auto lay = [&](Landed& landed) {
      landed.lay(20000, {2 + thickness, 0, 0}, {2 - thickness, 0, 0}, {0, 4, 0}, kIrradiance);
    };
    const auto at = [](double x) {
      return [x](Stream& random) { return Look{{x, 0.5 + 3 * random.uniform(), 0.5}, kDown}; };
    };
    CHECK(many_times(world, 2, lay, at(1.999)).mean() == 0);
    CHECK(many_times(world, 2, lay, at(1.95)).mean() == 0);
    INFO("thickness " << thickness);
    check_within(many_times(world, 20, lay, at(2.001 + thickness)), kIrradiance, 0.04);
  }
}

TEST_CASE("few, coincident and no photons have the answers that can be given", "[photon][surface_density]") {
  const World world(square_of(1));
  const SurfacePoint at = seen(world, {0.5, 0.5, 1}, kDown);
  CHECK(surface_estimate({world, 0}, PhotonMap(), at, one, {}, Vec3d(0)).value == 0);
  // One photon, or many at one place, have no density.
  for (const int count : {1, 10, 200}) {
    Landed landed{world, {}, Stream(9, 0, 0)};
    for (int i = 0; i < count; ++i) landed.add({0.4, 0.5, 0}, {0, 0, 1}, 1, kDown);
    const Estimate estimate = surface_estimate({world, 0}, PhotonMap(landed.photons), at, one, {}, Vec3d(0));
    CHECK(estimate.value == 0);
    CHECK(estimate.photons == 0);
  }
  // All where the question is.
  Landed here{world, {}, Stream(9, 0, 0)};
  for (int i = 0; i < 200; ++i) here.add({0.5, 0.5, 0}, {0, 0, 1}, 1, kDown);
  CHECK(surface_estimate({world, 0}, PhotonMap(here.photons), at, one, {}, Vec3d(0)).value == 0);
  // More coincident than are asked for, and one beyond: the search goes on to it.
  Landed landed{world, {}, Stream(9, 0, 0)};
  for (int i = 0; i < 80; ++i) landed.add({0.5, 0.5, 0}, {0, 0, 1}, 0.01, kDown);
  landed.add({0.5, 0.9, 0}, {0, 0, 1}, 1, kDown);
  const Estimate estimate = surface_estimate({world, 0}, PhotonMap(landed.photons), at, one, {}, Vec3d(0));
  CHECK(estimate.photons == 80);
  CHECK(estimate.radius == Approx(0.4).epsilon(1e-6));
  CHECK(estimate.value == Approx(0.8 * 2 / kPi / 0.16).epsilon(1e-5));
  // Of two, the farther gives the radius alone.
  Landed two{world, {}, Stream(9, 0, 0)};
  two.add({0.5, 0.6, 0}, {0, 0, 1}, 2, kDown);
  two.add({0.5, 0.2, 0}, {0, 0, 1}, 5, kDown);
  GatherSettings constant;
  constant.kernel = Kernel::constant;
  const Estimate alone = surface_estimate({world, 0}, PhotonMap(two.photons), at, one, constant, Vec3d(0));
  CHECK(alone.value == Approx(2 / (kPi * 0.09)).epsilon(1e-5));
}

TEST_CASE("a limit to the radius keeps far light away", "[photon][surface_density]") {
  const World world(square_of(10));
  Landed landed{world, {}, Stream(9, 0, 0)};
  landed.lay(20000, {5, 0, 0}, {5, 0, 0}, {0, 10, 0}, kIrradiance);
  const PhotonMap map(landed.photons);
  GatherSettings settings;
  settings.max_radius_m = 0.25;
  const SurfacePoint dark = seen(world, {4.5, 5, 1}, kDown);
  CHECK(surface_estimate({world, 0}, map, dark, one, settings, Vec3d(0)).value == 0);
  CHECK(surface_estimate({world, 0}, map, dark, one, {}, Vec3d(0)).value > 0);
  settings.nearest = 1000;
  const Estimate within = surface_estimate({world, 0}, map, seen(world, {7.5, 5, 1}, kDown), one, settings, Vec3d(0));
  CHECK(within.radius == Approx(0.25));
  CHECK(within.value == Approx(kIrradiance).epsilon(0.3));
}
