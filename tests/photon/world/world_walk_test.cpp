// The merged walk of several clouds against point sampling and against clouds tiled by hand.
#include "photon/world/world_walk.h"

#include <catch2/catch.hpp>

#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

struct Placed {
  Vec3i voxels;
  double voxel_m, extinction, albedo, source;
  std::uint64_t seed;
  Affine place;

  double density(const Vec3i& v) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (v[axis] < 0 || v[axis] >= voxels[axis]) return 0;
    }
    return voxel_noise(seed, Vec3i(v.x >> 1, v.y >> 1, v.z >> 1), 1) < 0.4 ? 0.0 : 0.25 + voxel_noise(seed, v, 2);
  }
  Cloud cloud() const {
    CloudWish wish;
    wish.voxels = voxels;
    wish.voxel_m = voxel_m;
    wish.density = [this](const Vec3i& v) { return density(v); };
    wish.extinction = extinction;
    wish.albedo = albedo;
    wish.source = source;
    Cloud result = make_cloud(wish);
    result.local_to_world = place;
    return result;
  }
  /// Without octree or World: the inverse placement and the voxel's own density.
  LocalOptics at(const Vec3d& x) const {
    const Vec3d index = transform_point(place.inverse(), x) / voxel_m;
    const double d = static_cast<double>(
        static_cast<float>(density(Vec3i(static_cast<int>(std::floor(index.x)), static_cast<int>(std::floor(index.y)),
                                         static_cast<int>(std::floor(index.z))))));
    return {d * extinction, d * extinction * albedo, d * extinction * (1 - albedo) * source};
  }
};

Placed random_cloud(Stream& random) {
  Placed p;
  for (int axis = 0; axis < 3; ++axis) p.voxels[axis] = 3 + static_cast<int>(random.bits() % 14u);
  p.voxel_m = 0.3 + 0.5 * random.uniform();
  p.extinction = random.uniform();
  p.albedo = random.uniform();
  p.source = 1 + random.uniform();
  p.seed = random.bits();
  Affine centred;
  centred.setTranslation(Vec3d(p.voxels) * (-0.5 * p.voxel_m));
  const Vec3d at(2 * random.uniform(), 2 * random.uniform(), 2 * random.uniform());
  const Vec3d turn(6 * random.uniform(), 6 * random.uniform(), 6 * random.uniform());
  p.place = centred * placement(at, random.uniform() < 0.3 ? Vec3d(0) : turn, 0.5 + random.uniform());
  return p;
}

bool near(double a, double b) { return std::abs(a - b) <= 1e-9 * (std::abs(a) + std::abs(b)) + 1e-15; }
bool same(const LocalOptics& a, const LocalOptics& b) {
  return near(a.extinction, b.extinction) && near(a.scattering, b.scattering) && near(a.emission, b.emission);
}

World world_of(std::vector<Cloud> clouds) {
  WorldContents contents;
  contents.bands.emplace_back("grey");
  contents.clouds = std::move(clouds);
  return World(std::move(contents));
}

struct Step {
  double begin, end;
  LocalOptics optics;
};
std::vector<Step> steps(const World& world, const Ray& ray) {
  std::vector<Step> result;
  WorldWalk walk({world, 0}, ray);
  while (walk.next()) result.push_back({walk.begin(), walk.end(), walk.optics()});
  return result;
}

double depth(const World& world, const Ray& ray) {
  double sum = 0;
  for (const Step& step : steps(world, ray)) sum += step.optics.extinction * (step.end - step.begin);
  return sum;
}

}  // namespace

TEST_CASE("segments of 2 to 5 overlapping clouds are what points along the ray say", "[photon][world_walk]") {
  Stream random(17, 0, 0);
  for (int trial = 0; trial < 12; ++trial) {
    std::vector<Placed> placed;
    for (int c = 0; c < 2 + trial % 4; ++c) placed.push_back(random_cloud(random));
    std::vector<Cloud> clouds;
    for (const Placed& p : placed) clouds.push_back(p.cloud());
    const World world = world_of(clouds);
    const auto at = [&](const Vec3d& x) {
      LocalOptics sum;
      for (const Placed& p : placed) sum += p.at(x);
      return sum;
    };
    int met = 0, overlapping = 0, wrong = 0, disordered = 0, gaps_filled = 0;
    for (int r = 0; r < 60; ++r) {
      const Vec3d d = random_direction(random);
      Vec3d x = world.bounds().min;
      for (int axis = 0; axis < 3; ++axis) x[axis] += random.uniform() * world.bounds().size()[axis];
      Ray ray{r % 4 ? x - 40.0 * d : x, d, 0, kInfinity};
      if (r % 5 == 0) ray.t_max = 41;
      double last = 0;
      double sum = 0;
      for (const Step& step : steps(world, ray)) {
        disordered += !(step.begin >= last) || !(step.end > step.begin) || step.end > ray.t_max;
        // Not so near to a face that rounding decides.
        if (step.begin - last > 1e-8) gaps_filled += at(ray.at(0.5 * (last + step.begin))).extinction > 0;
        if (step.end - step.begin > 1e-8) {
          ++met;
          for (const double share : {0.02, 0.5, 0.98}) {
            wrong += !same(step.optics, at(ray.at(step.begin + share * (step.end - step.begin))));
          }
        }
        sum += step.optics.extinction * (step.end - step.begin);
        last = step.end;
      }
      if (last < 70 && ray.t_max == kInfinity) gaps_filled += at(ray.at(last + 1e-6)).extinction > 0;
      // The whole is the sum of the clouds, each by its own walk.
      double alone = 0;
      int clouds_met = 0;
      for (const Cloud& cloud : clouds) {
        const double part = optical_depth(
            *cloud.octree,
            transform_ray(cloud.octree->local_to_index(), transform_ray(cloud.local_to_world.inverse(), ray)),
            std::vector<double>{cloud.media[0].extinction[0]});
        alone += part;
        clouds_met += part > 0;
      }
      overlapping += clouds_met > 1;
      CHECK(sum == Approx(alone).epsilon(1e-11).margin(1e-12));
    }
    INFO("trial " << trial);
    CHECK(met > 100);
    CHECK(overlapping > 5);
    CHECK(wrong == 0);
    CHECK(disordered == 0);
    CHECK(gaps_filled == 0);
  }
}

TEST_CASE("clouds that touch, coincide or end together are merged to the bit", "[photon][world_walk]") {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.extinction = 2;
  CloudWish behind = wish;
  behind.corner_m = {8, 0, 0};
  behind.extinction = 3;
  CloudWish half = wish;
  half.voxels = {4, 8, 8};
  half.corner_m = {4, 0, 0};
  half.extinction = 5;
  const World world = world_of({make_cloud(behind), make_cloud(wish), make_cloud(half), make_cloud(wish)});
  const std::vector<Step> found = steps(world, {{-1, 4.5, 4.5}, {1, 0, 0}, 0, kInfinity});
  const double expected[3][3] = {{1, 5, 4}, {5, 9, 9}, {9, 17, 3}};
  REQUIRE(found.size() >= 3);
  // Leaves may split a segment; what they say together is this.
  double begin = 1;
  for (const Step& step : found) {
    CHECK(step.begin == begin);
    begin = step.end;
    for (const auto& [from, to, extinction] : expected) {
      if (step.begin >= from && step.end <= to) CHECK(step.optics.extinction == extinction);
    }
  }
  CHECK(begin == 17);
}

TEST_CASE("a periodic cloud is the same as 5 x 5 clouds set by hand", "[photon][world_walk]") {
  Stream random(23, 0, 0);
  for (int trial = 0; trial < 6; ++trial) {
    Placed one = random_cloud(random);
    one.place = placement({1, -2, 0.5}, trial % 2 ? Vec3d(0, 0, 1.1) : Vec3d(0.2, -0.3, 0.4), 0.8);
    Cloud cloud = one.cloud();
    const double gap = trial % 3 == 0 ? 0 : 0.7;
    cloud.period_m = {one.voxels.x * one.voxel_m + gap, one.voxels.y * one.voxel_m + 2 * gap};
    if (trial == 5) cloud.period_m[1] = 0;
    const World world = world_of({cloud});
    std::vector<Cloud> tiles;
    for (int i = -2; i <= 2; ++i) {
      for (int j = -2; j <= 2; ++j) {
        if (cloud.period_m[1] == 0 && j != 0) continue;
        Cloud tile = cloud;
        tile.period_m = {0, 0};
        Affine shift;
        shift.setTranslation(Vec3d(i * cloud.period_m[0], j * cloud.period_m[1], 0));
        tile.local_to_world = shift * cloud.local_to_world;
        tiles.push_back(tile);
      }
    }
    const World tiled = world_of(tiles);
    int met = 0, wrong = 0;
    for (int r = 0; r < 80; ++r) {
      // Over less than two cells from a point of the middle one.
      const Vec3d local(one.voxel_m * one.voxels.x * random.uniform(), one.voxel_m * one.voxels.y * random.uniform(),
                        one.voxel_m * one.voxels.z * random.uniform());
      const double reach = 1.6 * std::min(one.voxels.x, one.voxels.y) * one.voxel_m;
      const Ray ray{transform_point(cloud.local_to_world, local), random_direction(random), 0, reach};
      const double expected = depth(tiled, ray);
      met += expected > 0;
      CHECK(depth(world, ray) == Approx(expected).epsilon(1e-9).margin(1e-10));
      double last = 0;
      for (const Step& step : steps(world, ray)) {
        wrong += step.begin < last || !(step.end > step.begin);
        last = step.end;
        if (step.end - step.begin < 1e-8) continue;
        wrong += !same(step.optics, SpectralWorld(tiled, 0).at(ray.at(0.5 * (step.begin + step.end))));
      }
    }
    INFO("trial " << trial);
    CHECK(met > 60);
    CHECK(wrong == 0);
  }
}

TEST_CASE("a ray in a face or along a period's border is in one cell only", "[photon][world_walk]") {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.period_m = {8, 8};
  wish.extinction = 1;
  const World world = world_of({make_cloud(wish)});
  // Homogeneous: every way through the layer has its length as depth, on borders and edges too.
  for (const Vec3d& through : {Vec3d(0, 0, 4), Vec3d(8, 8, 4), Vec3d(-16, 3, 4), Vec3d(4, 8, 4)}) {
    CHECK(depth(world, {through - Vec3d(0, 0, 10), {0, 0, 1}, 0, kInfinity}) == Approx(8));
    for (const Vec3d& d :
         {Vec3d(1, 0, 0), Vec3d(-1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, -1, 0), Vec3d(1, 1, 0).normalized(),
          Vec3d(-1, 1, 0).normalized(), Vec3d(-1e-12, 1, 0), Vec3d(1, -1e-300, 0)}) {
      CHECK(depth(world, {through, d, 0, 50}) == Approx(50));
      CHECK(depth(world, {through, d, 7, 50}) == Approx(43));
    }
  }
}
