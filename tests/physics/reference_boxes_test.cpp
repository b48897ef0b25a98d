// Boxes of the reference tables: cells, the step cloud, voids and ducts; by photons and by paths.
#include <catch2/catch.hpp>

#include "tests/physics/reference_bodies.h"
#include "tests/support/path_measures.h"
#include "tests/support/photon_measures.h"
#include "tests/support/reference_rules.h"
#include "tests/support/reference_worlds.h"
#include "tests/support/shapes_of_surfaces.h"

using namespace obscura;
using namespace obscura::test;

namespace {

AgreeOptions photon_rule(double reference, double error, double comparisons, double reference_error = 0) {
  return held_to(reference, error, comparisons, kManyBatches, reference_error);
}
AgreeOptions path_rule(double reference, double error, double comparisons, double reference_error = 0) {
  return held_to(reference, error, comparisons, kPathBatches, reference_error);
}

}  // namespace

TEST_CASE("e2: boxes let light out of every side", "[physics][reference][box]") {
  const Csv csv = reference_table("e2_boxes.csv");
  Verified photons("e2_boxes.csv", kPhotons, "every side, T and A of P1 to P3, R + T and A of P4",
                   "SE < 0.4 % of the light each, 0.3 % together");
  Verified paths("e2_boxes.csv", kPaths, "every side, R and T of P1 to P4",
                 "SE < 1.5 % of the light each, 0.5 % together");
  const auto boxes = [&](const std::string& name) {
    if (name == "box_P1") return box_contents({1, 1, 1}, 1, {{10, 0.9}}, hg(0), [](const Vec3i&) { return 0; });
    if (name == "box_P2") return box_contents({1, 1, 1}, 1, {{20, 1}}, hg(0.85), [](const Vec3i&) { return 0; });
    return box_contents({4, 4, 4}, 0.25, {{2, 0.99}, {18, 0.9}}, hg(0.5),
                        [](const Vec3i& v) { return (v.x + v.y + v.z) % 2; });
  };
  for (const char* name : {"box_P1", "box_P2", "box_P3"}) {
    WorldContents contents = boxes(name);
    const double angle = name[5] == '1' ? 0 : kPi / 6;
    contents.sun = Sun{{-std::sin(angle), 0, std::cos(angle)}, {1}, 0};
    if (angle > 0) {
      // Only the upper face is lit: a black wall stands close to the side that looks at the sun. What leaves
      // there is absorbed behind the place where it is counted.
      contents.materials = {grey_material(1)};
      contents.objects = {grey_object(parallelogram({-2e-3, -0.5, -1}, {0, 2, 0}, {0, 0, 2}), 0, 0)};
    }
    const World world(std::move(contents));
    const double incident = std::cos(angle), e = 1e-3;
    const std::pair<const char*, FluxRectangle> sides[] = {{"R", {{0.5, 0.5, 1 + e}, {1, 0, 0}, {0, 1, 0}}},
                                                           {"T", {{0.5, 0.5, -e}, {0, 1, 0}, {1, 0, 0}}},
                                                           {"side_xmin", {{-e, 0.5, 0.5}, {0, 0, 1}, {0, 1, 0}}},
                                                           {"side_xmax", {{1 + e, 0.5, 0.5}, {0, 1, 0}, {0, 0, 1}}},
                                                           {"side_ymin", {{0.5, -e, 0.5}, {1, 0, 0}, {0, 0, 1}}},
                                                           {"side_ymax", {{0.5, 1 + e, 0.5}, {0, 0, 1}, {1, 0, 0}}}};
    std::vector<FluxRectangle> rectangles;
    for (const auto& side : sides) rectangles.push_back(side.second);
    std::vector<std::vector<double>> out(7);
    for (std::uint64_t run = 0; run < kRuns; ++run) {
      TraceSettings settings;
      settings.photons = 30000;
      settings.seed = run + 1;
      const TraceResult traced = trace_photons({world, 0}, settings, rectangles);
      for (std::size_t s = 0; s < 6; ++s) {
        for (const double value : traced.flux[s].forward) out[s].push_back(kBatches * value / incident);
      }
      for (const double value : traced.energy.absorbed) out[6].push_back(kBatches * value / incident);
    }
    for (std::size_t row = 0; row < csv.size(); ++row) {
      if (csv.text(row, "case") != name) continue;
      const std::string& quantity = csv.text(row, "quantity");
      const double reference = csv.number(row, "value"), error = csv.number(row, "stderr");
      if (quantity == "T_direct" || reference < 1e-3) continue;
      INFO(name << " " << quantity);
      std::size_t s = 0;
      while (s < 6 && quantity != sides[s].first) ++s;
      CHECK(photons.mean(batch_mean(out[s]), reference, photon_rule(reference, 0.004, 30, error)));
      if (s == 6) continue;
      const Vec3d normal = rectangles[s].side_u.cross(rectangles[s].side_v);
      const BatchMean found = path_average(world, 9600, 10 + s, [&](const auto& u) {
        const Vec3d place = rectangles[s].center - 0.5 * e * normal + (u[2] - 0.5) * rectangles[s].side_u +
                            (u[3] - 0.5) * rectangles[s].side_v;
        return WeightedRay{{place, -cosine_direction(normal, u[0], u[1]), 0, kInfinity}, kPi / incident};
      });
      // Sunlight itself on the faces that it comes out of: no path finds a sun without size.
      double sunlit = 0;
      if (const double cosine = -world.suns()[0].toward.dot(normal); cosine > 1e-9) {
        constexpr std::uint32_t kPoints = 4096;
        const LowDiscrepancy numbers(1, 0, false);
        std::vector<Ray> rays;
        std::vector<double> depths(kPoints);
        for (std::uint32_t i = 0; i < kPoints; ++i) {
          const auto u = numbers.point(i);
          rays.push_back(
              {rectangles[s].center + (u[0] - 0.5) * rectangles[s].side_u + (u[1] - 0.5) * rectangles[s].side_v,
               world.suns()[0].toward, 0, kInfinity});
        }
        SpectralWorld(world, 0).optical_depths(rays, depths);
        Stream stream(1, 0, 0);
        for (std::size_t i = 0; i < kPoints; ++i) {
          if (!world.blocked(rays[i], {}, stream)) sunlit += cosine / incident * std::exp(-depths[i]) / kPoints;
        }
      }
      CHECK(paths.mean({found.mean + sunlit, found.standard_error}, reference, path_rule(reference, 0.015, 30, error)));
    }
  }

  WorldContents contents =
      box_contents({2, 2, 2}, 0.5, {{8, 0.95}}, hg(0), [](const Vec3i& v) { return (v.x + v.y + v.z) % 2 - 1; });
  contents.clouds[0].media[0].channel = 0;
  contents.clouds[0].octree = exact_octree(lattice(
      {2, 2, 2}, Vec3d(0.5), {"density"}, [](int, const Vec3i& v) { return (v.x + v.y + v.z) % 2 ? 1.0f : 0.0f; }));
  contents.clouds[0].period_m = {1, 1};
  contents.sky = {1};
  double reflected = 0, transmitted = 0, absorbed = 0;
  for (std::size_t row = 0; row < csv.size(); ++row) {
    if (csv.text(row, "case") != "box_P4") continue;
    (csv.text(row, "quantity") == "R"   ? reflected
     : csv.text(row, "quantity") == "T" ? transmitted
                                        : absorbed) = csv.number(row, "value");
    if (csv.text(row, "quantity") == "A") break;
  }
  REQUIRE(reflected + transmitted + absorbed == Approx(1).epsilon(1e-4));
  {
    // Lit from both sides; turned over, the cells are the same.
    const SlabLight found = slab_light(World(contents), 1, 1, kPi, 60000, 5);
    INFO("box_P4");
    CHECK(photons.mean(found.up, reflected + transmitted, photon_rule(0.7, 0.004, 30, 1e-4)));
    CHECK(photons.mean(scaled(found.absorbed, 0.5), absorbed, photon_rule(absorbed, 0.004, 30, 1e-4)));
  }
  // By paths with a black layer below, so that light comes from above alone.
  Cloud black = contents.clouds[0];
  black.octree = exact_octree(lattice({1, 1, 1}, {1, 1, 1}, {"density"}, [](int, const Vec3i&) { return 1.0f; }));
  black.media[0] = {0, {60}, {0}, hg(0)};
  black.local_to_world = placement({0, 0, -1}, Vec3d(0), 1);
  contents.clouds.push_back(black);
  const World lit(contents);
  for (const bool up : {true, false}) {
    const double reference = up ? reflected : transmitted;
    const BatchMean found = path_average(lit, 9600, 20 + up, [&](const auto& u) {
      const Vec3d travels = cosine_direction(Vec3d(0, 0, up ? 1 : -1), u[0], u[1]);
      return WeightedRay{{{u[2], u[3], up ? 1.0 : 0.0}, -travels, 0, kInfinity}, 1};
    });
    INFO("box_P4 " << (up ? "R" : "T"));
    CHECK(paths.mean(found, reference, path_rule(reference, 0.01, 30, 7e-5)));
  }
  check_common(photons, 0.003);
  check_common(paths, 0.005);
}

TEST_CASE("e1: the step cloud, column by column", "[physics][reference][box]") {
  const Csv columns = reference_table("e1_i3rc_step_cloud_columns.csv"),
            means = reference_table("e1_i3rc_step_cloud_mean.csv");
  Verified fluxes("e1_i3rc_step_cloud_columns.csv", kPhotons, "R and T of every column, experiments 1 to 4",
                  "SE < 6 % of the light each, 0.4 % together");
  Verified totals("e1_i3rc_step_cloud_mean.csv", kPhotons, "mean R, T and A",
                  "SE < 0.6 % of the light each, 0.4 % together");
  Verified nadir("e1_i3rc_step_cloud_columns.csv", kPaths, "Iu of the columns of experiments 1 and 2", "10 % + 5 SE");
  Verified path_totals("e1_i3rc_step_cloud_mean.csv", kPaths, "mean R, and Iu of experiments 1 and 2",
                       "SE < 5 %, Iu 8 %");
  constexpr double kSide = 500, kTop = 250;
  for (const int experiment : {1, 2, 3, 4}) {
    const double mu0 = experiment % 2 ? 1 : 0.5, albedo = experiment < 3 ? 1 : 0.99;
    WorldContents contents = box_contents({1, 1, 1}, 1, {{1, albedo}}, hg(0.85), [](const Vec3i&) { return 0; });
    contents.clouds[0].octree = exact_octree(lattice({32, 1, 1}, {kSide / 32, kSide, kTop}, {"density"},
                                                     [](int, const Vec3i& v) { return v.x < 16 ? 0.008f : 0.072f; }));
    contents.clouds[0].period_m = {kSide, kSide};
    contents.sun = Sun{{-std::sqrt(1 - mu0 * mu0), 0, mu0}, {1}, 0};
    const World world(std::move(contents));
    std::vector<FluxRectangle> rectangles;
    for (int c = 0; c < 32; ++c) {
      for (const double z : {kTop + 1e-3, -1e-3})
        rectangles.push_back(horizontal({(c + 0.5) * kSide / 32, kSide / 2, z}, kSide / 32, kSide));
    }
    double nadir_sum = 0, nadir_error2 = 0;
    std::vector<std::vector<double>> out(64);
    std::array<double, kManyBatches> absorbed{}, up{}, down{};
    const double unit = mu0 * kSide * kSide / kBatches;
    for (int run = 0; run < kRuns; ++run) {
      TraceSettings settings;
      settings.photons = 10000;
      settings.seed = static_cast<std::uint64_t>(10 * experiment + run);
      const TraceResult traced = trace_photons({world, 0}, settings, rectangles);
      for (std::size_t b = 0; b < kBatches; ++b) {
        const std::size_t k = static_cast<std::size_t>(run * kBatches) + b;
        for (std::size_t r = 0; r < 64; ++r) {
          const double value = (r % 2 ? traced.flux[r].backward[b] : traced.flux[r].forward[b]) / unit;
          out[r].push_back(32 * value);
          (r % 2 ? down : up)[k] += value;
        }
        absorbed[k] = traced.energy.absorbed[b] / unit;
      }
    }
    for (std::size_t row = 0; row < columns.size(); ++row) {
      if (static_cast<int>(columns.number(row, "exp")) != experiment) continue;
      const std::string& quantity = columns.text(row, "quantity");
      const int column = static_cast<int>(columns.number(row, "column"));
      const double reference = columns.number(row, "value"), error = columns.number(row, "stderr");
      INFO("experiment " << experiment << ", column " << column << " " << quantity);
      if (quantity == "R" || quantity == "T") {
        const std::size_t r = static_cast<std::size_t>(2 * column + (quantity == "T"));
        CHECK(fluxes.mean(batch_mean(out[r]), reference, photon_rule(reference, 0.06, 260, error)));
      } else if (quantity == "Iu" && experiment < 3) {
        const BatchMean found = path_average(world, 1920, row, [&](const auto& u) {
          return WeightedRay{{{(column + u[0]) * kSide / 32, kSide * u[1], kTop + 1}, {0, 0, -1}, 0, kInfinity},
                             kPi / mu0};
        });
        // Light that comes straight from the sun by few scatterings is a rare and bright find.
        CHECK(nadir.within(found.mean, reference, 0.1 + 5 * std::hypot(found.standard_error, error) / reference));
        CHECK(found.standard_error < 0.4 * reference);
        nadir_sum += found.mean / 32;
        nadir_error2 += found.standard_error * found.standard_error / 1024;
      }
    }
    for (std::size_t row = 0; row < means.size(); ++row) {
      if (static_cast<int>(means.number(row, "exp")) != experiment) continue;
      const std::string& quantity = means.text(row, "quantity");
      const double reference = means.number(row, "value"), error = means.number(row, "stderr");
      INFO("experiment " << experiment << ", mean " << quantity);
      if (reference == 0) continue;
      if (quantity == "Iu" && experiment < 3) {
        INFO(nadir_sum << " +- " << std::sqrt(nadir_error2));
        CHECK(path_totals.mean({nadir_sum, std::sqrt(nadir_error2)}, reference,
                               path_rule(reference, 0.08 * reference, 12, error)));
      }
      if (quantity != "Iu") {
        CHECK(totals.mean(batch_mean(quantity == "R"   ? up
                                     : quantity == "T" ? down
                                                       : absorbed),
                          reference, photon_rule(reference, 0.006, 12, error)));
      }
      if (quantity == "R") {
        const BatchMean found = path_average(world, 9600, row, [&](const auto& u) {
          return WeightedRay{
              {{kSide * u[2], kSide * u[3], kTop + 1}, -cosine_direction(Vec3d(0, 0, 1), u[0], u[1]), 0, kInfinity},
              kPi / mu0};
        });
        CHECK(path_totals.mean(found, reference, path_rule(reference, 0.05 * reference, 3, error)));
      }
    }
  }
  check_common(fluxes, 0.004);
  check_common(totals, 0.004);
}

namespace {

/// What the cells of 10 cm of a problem of Kobayashi's hold, in the first octant: 0 source, 1 shield, 2 void.
int duct_cell(int problem, const Vec3i& v) {
  if (v.x == 0 && v.y == 0 && v.z == 0) return 0;
  if (problem == 1) return v.x < 5 && v.y < 5 && v.z < 5 ? 2 : 1;
  if (problem == 2) return v.x < 1 && v.z < 1 ? 2 : 1;
  const bool leg = (v.x < 1 && v.z < 1 && v.y >= 1 && v.y < 6) || (v.x >= 1 && v.x < 4 && v.y == 5 && v.z < 1) ||
                   (v.x == 3 && v.y == 5 && v.z >= 1 && v.z < 4) || (v.x == 3 && v.y >= 6 && v.z == 3);
  return leg ? 2 : 1;
}

/// Mirrored into all octants; the metre stands for the centimetre.
WorldContents duct_contents(int problem, double albedo) {
  const Vec3i half = problem == 1 ? Vec3i(10, 10, 10) : Vec3i(6, 10, 6);
  WorldContents contents;
  contents.bands.emplace_back("grey");
  contents.sky = {0};
  Cloud cloud;
  cloud.name = "duct";
  cloud.octree = exact_octree(lattice(2 * half, Vec3d(10), {"source", "rest"}, [&](int channel, const Vec3i& v) {
    const auto fold = [](int i, int n) { return i < n ? n - 1 - i : i - n; };
    const int kind = duct_cell(problem, {fold(v.x, half.x), fold(v.y, half.y), fold(v.z, half.z)});
    return channel == 0 ? (kind == 0 ? 1.0f : 0.0f) : kind == 1 ? 1.0f : kind == 2 ? 1e-3f : 0.0f;
  }));
  cloud.local_to_world = placement(-10.0 * Vec3d(half), Vec3d(0), 1);
  cloud.media.push_back({0, {0.1}, {albedo}, hg(0)});
  cloud.media.push_back({1, {0.1}, {albedo}, hg(0)});
  cloud.emission = {1 / (4 * kPi)};
  contents.clouds.push_back(std::move(cloud));
  return contents;
}

}  // namespace

TEST_CASE("e5: light through voids and ducts", "[physics][reference][box]") {
  const Csv csv = reference_table("e5_kobayashi.csv");
  Verified direct("e5_kobayashi.csv", "world walk", "case i, every point but the source's own", "0.3 %");
  Verified paths("e5_kobayashi.csv", kPaths, "case ii, points of flux above 0.05", "SE < 8 % each, 0.5 % together");
  std::array<World, 4> worlds{World(empty_contents()), World(duct_contents(1, 0)), World(duct_contents(2, 0)),
                              World(duct_contents(3, 0))};
  const auto uncollided = [&](int problem, const Vec3d& point) {
    // The source is [-10, 10]^3: the sum over its volume of what each part sends through what is between.
    constexpr std::uint32_t kPoints = 1 << 14;
    const LowDiscrepancy numbers(1, 0, false);
    std::vector<Ray> rays;
    std::vector<double> depths(kPoints), weights;
    for (std::uint32_t i = 0; i < kPoints; ++i) {
      const auto u = numbers.point(i);
      const Vec3d away = 20.0 * Vec3d(u[0] - 0.5, u[1] - 0.5, u[2] - 0.5) - point;
      rays.push_back({point, away.normalized(), 0, away.length()});
      weights.push_back(8000 / (4 * kPi * away.length2()));
    }
    SpectralWorld(worlds[static_cast<std::size_t>(problem)], 0).optical_depths(rays, depths);
    double sum = 0;
    for (std::size_t i = 0; i < kPoints; ++i) sum += weights[i] * std::exp(-depths[i]) / kPoints;
    return sum;
  };
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const auto number = [&](const char* column) { return csv.number(row, column); };
    const int problem = static_cast<int>(number("problem"));
    const Vec3d point(number("x"), number("y"), number("z"));
    INFO("problem " << problem << csv.text(row, "case") << " at " << point);
    if (csv.text(row, "case") == "i") {
      if (point.y < 10) continue;  // inside the source the sum is singular
      CHECK(direct.within(uncollided(problem, point), number("flux"), 0.003));
    } else if (number("flux") > 0.05) {
      const World world(duct_contents(problem, 0.5));
      const BatchMean all =
          scaled(path_average(world, 24000, row,
                              [&](const auto& u) {
                                return WeightedRay{{point, uniform_direction(u[0], u[1]), 0, kInfinity}, 1};
                              }),
                 4 * kPi);
      CHECK(paths.mean(all, number("flux"),
                       path_rule(number("flux"), 0.08 * number("flux"), 20, number("rel_err") * number("flux"))));
    }
  }
  check_common(paths, 0.005);
}
